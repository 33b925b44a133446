"""What the map is for: routes from room to room, the order of rooms, and paths that cover the floor."""

ROBOT_RADIUS_M = 0.17
"""The radius of a usual robot vacuum."""
NAV2_RADIUS_M = 0.22
"""The radius of the robot in Nav2's own parameters."""
TOOL_M = 0.30
"""The width of its tool."""
TRADE, LEAVE = 0.24, 0.02
"""How much area a covering path gives up for a length saved, and at most in all; see `CoverFloor`."""
