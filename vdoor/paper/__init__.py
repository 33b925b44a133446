"""The paper's own evidence, done again: each function gives one figure or table as plain data."""
