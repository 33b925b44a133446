"""Geometry on grids of cells, independent of the method: contours, lines, rays, components, polygons."""
