"""Geometry on grids of cells, with nothing of the method in it: contours, lines, rays, components, polygons."""
