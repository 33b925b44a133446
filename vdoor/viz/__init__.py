"""Pictures of records: the Rerun recording and the terminal."""
