"""The stages of the method, one module each: record, settings, algorithm. `vdoor.pipeline` calls them in order."""
