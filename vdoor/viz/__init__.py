"""Visualisation of records: the Rerun recording, the terminal and charts."""
