"""A path whose tool sweeps the floor, room by room: passes along the walls, lanes in between, one tour, polished."""
