"""Recordings of runs: written as MCAP while the method runs, and read back to replay and compare."""
