"""Many maps in one go: a map in, a result folder and a row of the table out."""
