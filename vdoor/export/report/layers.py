"""How each stage is drawn in the report: one function per record, and the table of them."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from vdoor.errors import RecordingError
from vdoor.explain import coverage
from vdoor.explain.routes import described, obstacle_text
from vdoor.explain.stages import view_of
from vdoor.export.report.sheet import Layer, Sheet, colour_text, polygon, polyline, room_codes
from vdoor.frame import Frame
from vdoor.grid import FREE_TO, OCCUPIED_FROM, Annotations, Line, OccupancyGrid
from vdoor.history.provenance import Provenance
from vdoor.history.records import RunRecords
from vdoor.method.boundary import BoundaryPath
from vdoor.method.corners import Candidates, Corners
from vdoor.method.curvature import Curvature
from vdoor.method.doors import PROPOSED, VERDICTS, VirtualDoors
from vdoor.method.initial_map import InitialMap
from vdoor.method.scoring.score import DoorScores
from vdoor.method.search.generation import Generation
from vdoor.method.simplify import REASONS, SimplifiedGrid
from vdoor.navigate.cover_floor import Coverage
from vdoor.navigate.coverage.path import KINDS as PURPOSES
from vdoor.navigate.find_route import Route
from vdoor.record import RASTERS, Record, specs, tables, texts_of
from vdoor.topology import KINDS
from vdoor.viz.marks.boundary import BECAME, BINS
from vdoor.viz.marks.doors import WHY, scores
from vdoor.viz.rerun import style
from vdoor.viz.rerun.restrictions import restriction_lines, restrictions

Drawn = Iterator[Layer]
FREE, BETWEEN, OCCUPIED = 1, 2, 3
"""Codes of cell states, unknown is 0; a reduced raster keeps the highest code."""
CELLS: dict[int, tuple[style.Colour, str]] = {
    0: (style.UNKNOWN, "unknown"),
    FREE: (style.FREE, "free"),
    BETWEEN: (style.BETWEEN, "between"),
    OCCUPIED: (style.OCCUPIED, "occupied"),
}
OTHER: style.Colour = (160, 60, 140)
"""Colour of words without a colour of their own."""


def layers(sheet: Sheet, provenance: Provenance | None, annotations: Annotations | None = None) -> Iterator[Layer]:
    """Layers of all recorded stages, in the order of the method; records without a function use `draw_any`."""
    if provenance is None:
        return
    for record in provenance.records:
        if isinstance(record, DoorScores) and provenance.run.has(VirtualDoors):
            yield draw_scores(sheet, provenance.run)
        else:
            yield from DRAW.get(type(record), draw_any)(sheet, record)
        if isinstance(record, OccupancyGrid):
            yield from draw_restrictions(sheet, restriction_lines(annotations) or restrictions(record))
        if isinstance(record, InitialMap) and len(provenance.run.search):
            yield draw_search(sheet, record, provenance)


def draw_input(sheet: Sheet, grid: OccupancyGrid) -> Drawn:
    """The input map."""
    yield _cells(sheet, grid, Layer("input", view_of(OccupancyGrid).name, on=True))


def draw_restrictions(sheet: Sheet, found: Sequence[tuple[str, style.Colour, Sequence[Line]]]) -> Drawn:
    """Walls and areas that the robot must not cross or enter."""
    layer = Layer("restrictions", "Restrictions in the map file", on=True)
    for word, colour, lines in found:
        paths = [polyline(sheet.world_points(np.array(line))) for line in lines]
        layer.add_lines(paths, colour_text(colour), word, tips=[word] * len(paths), wide_px=3)
    if layer.shapes:
        yield layer


def draw_simplified(sheet: Sheet, grid: SimplifiedGrid) -> Drawn:
    """The working grid, and the changed cells as a separate layer."""
    yield _cells(
        sheet, grid, Layer("simplified", f"{view_of(SimplifiedGrid).name}, cells of {grid.frame.resolution_m:g} m")
    )
    changed = Layer("changed", "Cells changed by simplification")
    colours: dict[int, Sequence[int]] = {
        code: style.OF_REASON.get(word, OTHER) for code, word in enumerate(REASONS) if code
    }
    changed.picture = sheet.picture(grid.reason, colours, grid.frame)
    counts = np.bincount(grid.reason.ravel(), minlength=len(REASONS)).tolist()
    changed.key = [
        (colour_text(colour), f"{BECAME.get(REASONS[code], REASONS[code])} ({counts[code]})")
        for code, colour in colours.items()
        if counts[code]
    ]
    yield changed


def draw_path(sheet: Sheet, path: BoundaryPath) -> Drawn:
    """The boundary path, ring by ring."""
    layer = Layer("path", view_of(BoundaryPath).name)
    points = sheet.points((path.half - 1) / 2, path.frame)
    rings = np.split(points, path.first[1:])
    for outer, word, colour in ((True, "around free space", style.BOUNDARY), (False, "around islands", style.NOTCH)):
        own = [polygon([ring]) for ring, is_outer in zip(rings, path.outer, strict=True) if is_outer == outer]
        layer.add_lines(own, colour_text(colour), f"{word} ({len(own)})")
    yield layer


def draw_curvature(sheet: Sheet, curvature: Curvature) -> Drawn:
    """Samples of the path, coloured by their angle; nearly straight ones are not drawn."""
    layer = Layer("curvature", view_of(Curvature).name)
    points, angle_deg = sheet.points(curvature.cell, curvature.frame), np.degrees(curvature.angle_rad)
    for lower, upper, colour in BINS[1:]:
        own = (angle_deg >= lower) & (angle_deg < upper)
        layer.add_dots(points[own], colour_text(colour), f"{lower:g}° to {min(upper, 180):g}°", wide_px=4)
    yield layer


def draw_bends(sheet: Sheet, bends: Candidates | Corners) -> Drawn:
    """Candidates or corners, coloured by convexity."""
    is_corners = isinstance(bends, Corners)
    layer = Layer(bends.topic, view_of(type(bends)).name)
    cells = bends.quarter / 4 - 0.5 if isinstance(bends, Corners) else bends.cell
    points, angle_deg = sheet.points(cells, bends.frame), np.degrees(bends.angle_rad)
    for convex, word, colour in ((True, "convex", style.CONVEX), (False, "concave", style.CONCAVE)):
        own = np.flatnonzero(bends.convex == convex)
        name = "corner" if is_corners else "candidate"
        tips = [f"{name} {row}: {word}, {angle_deg[row]:.1f}°" for row in own.tolist()]
        text = f"{word} ({len(own)})"
        layer.add_dots(points[own], colour_text(colour), text, tips=tips, wide_px=8 if is_corners else 4)
    yield layer


def draw_doors(sheet: Sheet, doors: VirtualDoors) -> Drawn:
    """Proposed doors, and rejected doors with their reasons as a separate layer."""
    proposed, rejected = Layer("doors", view_of(VirtualDoors).name), Layer("rejected", "Rejected doors")
    paths = sheet.segments(doors.start, doors.end, doors.frame)
    for code, verdict in enumerate(VERDICTS):
        own = np.flatnonzero(doors.verdict == code).tolist()
        tips = [f"virtual door {row}: {verdict}, {doors.width_m[row]:.2f} m, {KINDS[doors.kind[row]]}" for row in own]
        colour = style.DOOR if code == PROPOSED else style.REJECTED.get(verdict, OTHER)
        layer, wide_px = (proposed, 3) if code == PROPOSED else (rejected, 1.5)
        text = f"{WHY.get(verdict, verdict)} ({len(own)})"
        own_paths = [paths[row] for row in own]
        layer.add_lines(own_paths, colour_text(colour), text, tips=tips, doors=own, wide_px=wide_px)
    yield proposed
    yield rejected


def draw_scores(sheet: Sheet, run: RunRecords) -> Layer:
    """Scored doors by judgement and odds, as pictures show them."""
    layer = Layer("scores", view_of(DoorScores).name)
    for mark in scores(run):
        paths = [polyline(sheet.points(strip, mark.frame)) for strip in mark.strips]
        layer.add_lines(paths, colour_text(mark.colour), mark.meaning, tips=mark.tips, wide_px=mark.wide_px)
    return layer


def draw_initial(sheet: Sheet, initial: InitialMap) -> Drawn:
    """Regions between all virtual doors."""
    layer = Layer(initial.topic, f"{view_of(InitialMap).name}: {len(initial.area_m2)} regions")
    codes, colours = room_codes(initial.piece)
    layer.picture = sheet.picture(codes, colours, initial.frame)
    yield layer


def draw_search(sheet: Sheet, initial: InitialMap, provenance: Provenance) -> Layer:
    """The doors that the search decided about; the page colours them by the best string of each generation."""
    if provenance.run.search.edges != len(initial.door):
        found = f"generation.removed: wanted a choice for each of {len(initial.door)} doors"
        raise RecordingError(f"{found}, found {provenance.run.search.edges}")
    layer = Layer("search", view_of(Generation).name)
    kept = ~provenance.run.search[-1].removed
    tips = [
        f"edge {edge}, virtual door {door}: {initial.width_m[edge]:.2f} m"
        for edge, door in enumerate(initial.door.tolist())
    ]
    paths = sheet.segments(initial.start, initial.end, initial.frame)
    for path, tip, door, keeps in zip(paths, tips, initial.door.tolist(), kept, strict=True):
        line = {"colour": colour_text(style.KEPT if keeps else style.REMOVED), "wide": 3 if keeps else 2}
        layer.shapes.append(line | {"d": path, "tip": tip, "door": door})
    layer.key = [(colour_text(style.KEPT), "kept"), (colour_text(style.REMOVED), "removed")]
    layer.note = "in the generation selected below the map"
    return layer


def draw_route(sheet: Sheet, route: Route) -> Drawn:
    """The route, its stops, and what is in the way."""
    layer = Layer("route", view_of(Route).name, on=True)
    if route.found:
        path = polyline(sheet.world_points(route.point_m))
        layer.add_lines([path], colour_text(style.ROUTE), "route", tips=[described(route)], wide_px=3)
    stops = route.stop_m[np.isfinite(route.stop_m).all(axis=1)]
    layer.add_dots(sheet.world_points(stops), colour_text(style.STOP), "stops", wide_px=8)
    tips = [obstacle_text(route, row) for row in range(len(route.obstacle))]
    places = sheet.world_points(route.obstacle_m)
    layer.add_dots(places, colour_text(style.IN_THE_WAY), "in the way", tips=tips, wide_px=10)
    layer.note = described(route)
    yield layer


def draw_coverage(sheet: Sheet, found: Coverage) -> Drawn:
    """The path by what it is for, over the floor that it sweeps."""
    layer = Layer("coverage", view_of(Coverage).name, on=True)
    swept = (found.swept > 0).astype(np.uint8)
    layer.picture = sheet.picture(swept, {1: style.SWEPT}, found.frame) | {"above": True}
    layer.key.append((colour_text(style.SWEPT), "swept floor"))
    cell = found.frame.cell_from_world(found.point_m)
    for code, purpose in enumerate(PURPOSES):
        own = np.flatnonzero(found.purpose[1:] == code)
        lines = sheet.segments(cell[own], cell[own + 1], found.frame)
        layer.add_lines(["".join(lines)] if lines else [], colour_text(style.OF_PURPOSE[purpose]), purpose)
    layer.note = coverage.described(found)
    yield layer


def draw_any(sheet: Sheet, record: Record) -> Drawn:
    """A record without a function of its own: its rasters as pictures, table rows with cells as dots."""
    frame = getattr(record, "frame", None)
    if not isinstance(frame, Frame):
        return
    title = view_of(type(record)).name
    for name, (spec, _) in specs(type(record)).items():
        if spec.kind in RASTERS:
            codes, colours = room_codes(np.asarray(getattr(record, name), np.int32))
            picture = sheet.picture(codes, colours, frame)
            yield Layer(f"{record.topic}-{name}", f"{title}: {name}", picture=picture)
    for table, columns in tables(type(record)).items():
        places = [name for name in columns if specs(type(record))[name][0].kind == "cell"]
        if places and len(getattr(record, places[0])):
            layer = Layer(f"{record.topic}-{table}", f"{title}: {table}")
            points = sheet.points(getattr(record, places[0]), frame)
            layer.add_dots(points, colour_text(OTHER), f"{table} ({len(points)})", tips=_rows(record, table), wide_px=7)
            yield layer


def _rows(record: Record, table: str) -> list[str]:
    """Text of each row of a table, with all columns of one value per row."""
    columns = [name for name in tables(type(record))[table] if getattr(record, name).ndim == 1]
    units = [specs(type(record))[name][0].unit for name in columns]
    texts = [
        [f"{name} {text} {unit}".rstrip() for text in texts_of(record, name)]
        for name, unit in zip(columns, units, strict=True)
    ]
    return [f"{table} {row}: {', '.join(values)}" for row, values in enumerate(zip(*texts, strict=True))]


def _cells(sheet: Sheet, grid: OccupancyGrid | SimplifiedGrid, layer: Layer) -> Layer:
    """The layer, with a picture of a grid's cells by their state."""
    codes = np.full(grid.cells.shape, BETWEEN, np.uint8)
    unsigned = grid.cells.view(np.uint8)  # unknown, -1, is 255 here
    codes[unsigned > np.iinfo(np.int8).max] = 0
    codes[unsigned <= FREE_TO] = FREE
    codes[grid.cells >= OCCUPIED_FROM] = OCCUPIED
    layer.picture = sheet.picture(codes, {code: colour for code, (colour, _) in CELLS.items()}, grid.frame)
    there = np.unique(codes).tolist()
    layer.key = [(colour_text(CELLS[code][0]), CELLS[code][1]) for code in there]
    return layer


DRAW: Mapping[type[Record], Callable[[Sheet, Any], Drawn]] = {
    OccupancyGrid: draw_input,
    SimplifiedGrid: draw_simplified,
    BoundaryPath: draw_path,
    Curvature: draw_curvature,
    Candidates: draw_bends,
    Corners: draw_bends,
    VirtualDoors: draw_doors,
    InitialMap: draw_initial,
    Route: draw_route,
    Coverage: draw_coverage,
}
