"""The Rerun recording: what is drawn of each record, the views it opens with, and pictures of them."""
