"""The result folder, written by `vdoor run --out` and read back by the commands that take a result."""
