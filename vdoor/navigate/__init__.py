"""What the map is for: routes from room to room, the order of rooms, and paths that cover the floor."""
