"""Pictures of stages for people: PNGs of our own, without a viewer."""
