"""How likely each virtual door is a real one: features of walls, space and detour, and the curves that weigh them."""
