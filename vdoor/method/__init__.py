"""The stages of the method, one file each: record, settings, algorithm. `vdoor.pipeline` puts them in a row."""
