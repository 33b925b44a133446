"""How likely each virtual door is real: features of walls, space and detour, and the curves that weight them."""
