"""Recordings of runs: written as MCAP during the run, read back for replay and comparison."""
