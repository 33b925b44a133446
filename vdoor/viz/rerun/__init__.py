"""The Rerun recording: drawings of each record, the views that it opens with, and pictures of them."""
