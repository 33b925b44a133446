"""Rooms and doors from occupancy grid maps, every stage on record."""

__version__ = "0.1.0"
