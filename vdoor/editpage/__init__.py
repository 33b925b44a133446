"""The page to edit a result on: the report with tools, served on this machine only."""
