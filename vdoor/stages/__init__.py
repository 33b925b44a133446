"""The stages of the method: one file a stage, its record, its settings, its algorithm."""
