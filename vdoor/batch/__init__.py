"""Many maps in one go: a map in, a result folder out, and an index of all."""
