"""The pictures of the page: figures 3 and 5, the search of section III, and the doors of Table I as in figure 6."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from vdoor.grid import OccupancyGrid
from vdoor.method.boundary import BoundaryPath
from vdoor.method.corners import Candidates, Corners
from vdoor.method.doors import PROPOSED, VirtualDoors
from vdoor.method.initial_map import InitialMap
from vdoor.method.simplify import REASONS, SimplifiedGrid
from vdoor.paper.claims import Evidence
from vdoor.paper.door_counts import METHOD_TITLES, Lines, detect_doors, environments, methods_for, real_doors_m
from vdoor.paper.figures import SUB_CASES, SubCase
from vdoor.paper.pictures_canvas import OCCUPIED, Canvas, LegendEntry, Places, Window, known_window, legend
from vdoor.paper.search import SearchStudy
from vdoor.paper.walkthrough import PRINTED_GENERATION, MethodRun, figure_5_run, run_method
from vdoor.topology import TopologicalMap
from vdoor.viz.charts import drawing, rgb, to_png
from vdoor.viz.rerun import style

if TYPE_CHECKING:
    from matplotlib.axes import Axes

FIGURE_5, SEARCH, TABLE_1 = "figure_5.png", "search.png", "table_1.png"
SUB_CASE_CELL_PT, FIGURE_5_CELL_PT, TABLE_1_CELL_PT = 14.0, 5.4, 3.6
"""How large a cell is drawn."""


def picture_of(case: SubCase) -> str:
    """The file name of a sub-case's picture."""
    return f"{case.file_stem}.png"


NAMES = (*map(picture_of, SUB_CASES), FIGURE_5, SEARCH, TABLE_1)
"""The file names of all pictures."""


def pictures(evidence: Evidence) -> Iterator[tuple[str, bytes]]:
    """Name and PNG of each, in the order of `NAMES`."""
    seed = evidence.size.seed
    for case in SUB_CASES:
        yield picture_of(case), sub_case_picture(case)
    yield FIGURE_5, figure_5_picture(figure_5_run(seed=seed))
    yield SEARCH, search_picture(evidence.search)
    yield TABLE_1, table_1_picture(seed)


REMOVED = {
    "unreachable": style.UNREACHABLE,
    "jut": style.JUT,
    "notch": style.NOTCH,
    "island": style.ISLAND,
}
CORNER_LEGEND: tuple[LegendEntry, ...] = (("o", style.CONCAVE, "concave"), ("o", style.CONVEX, "convex"))
BOUNDARY_LEGEND: tuple[LegendEntry, ...] = (("-", style.BOUNDARY, "boundary"),)
DOOR_LEGEND: tuple[LegendEntry, ...] = (
    ("-", style.DOOR, "virtual door"),
    ("o", style.NODE, "node"),
    ("o", style.EDGE_MIDDLE, "edge"),
)
LIGHTER = 0.55
"""How far the colours of rooms go towards white."""


def draw_map(canvas: Canvas, run: MethodRun) -> None:
    """The map as given."""
    canvas.cells(run.get(OccupancyGrid).cells)


def draw_simplified(canvas: Canvas, run: MethodRun) -> None:
    """The simplified map and its boundary."""
    canvas.cells(run.get(SimplifiedGrid).cells)
    _draw_boundary(canvas, run)


def draw_removed(canvas: Canvas, run: MethodRun) -> None:
    """The simplified map, with the cells that were removed or flattened in colours of their own."""
    simplified = run.get(SimplifiedGrid)
    canvas.cells(simplified.cells)
    for name, colour in REMOVED.items():
        canvas.marked(simplified.reason == REASONS.index(name), colour)
    _draw_boundary(canvas, run)


def draw_candidates(canvas: Canvas, run: MethodRun) -> None:
    """The samples of the boundary that bend."""
    candidates = run.get(Candidates)
    draw_simplified(canvas, run)
    _draw_by_kind(canvas, candidates.cell, candidates.convex)


def draw_corners(canvas: Canvas, run: MethodRun) -> None:
    """The corner features."""
    corners = run.get(Corners)
    draw_simplified(canvas, run)
    _draw_by_kind(canvas, corners.quarter / 4 - 0.5, corners.convex)


def draw_virtual_doors(canvas: Canvas, run: MethodRun) -> None:
    """Corners and the virtual doors between them."""
    doors = run.get(VirtualDoors)
    proposed = doors.verdict == PROPOSED
    draw_corners(canvas, run)
    canvas.lines(doors.start[proposed], doors.end[proposed], style.DOOR)


def draw_initial_map(canvas: Canvas, run: MethodRun) -> None:
    """All virtual doors as edges, and the nodes that they separate."""
    initial = run.get(InitialMap)
    draw_simplified(canvas, run)
    links = [(initial.border_edge, initial.border_region)]
    _draw_graph(canvas, (initial.start, initial.end), initial.centre, links)


def draw_final_map(canvas: Canvas, run: MethodRun) -> None:
    """The rooms of the final map, and the doors between them."""
    simplified, final = run.get(SimplifiedGrid), run.get(TopologicalMap)
    canvas.cells(simplified.cells)
    canvas.marked(simplified.reason == REASONS.index("jut"), OCCUPIED)  # labels are of the map as it was given
    for room in range(1, len(final.area_m2) + 1):
        light = [round(part + LIGHTER * (255 - part)) for part in style.room(room)]
        canvas.marked(final.labels == room, light)
    _draw_boundary(canvas, run)
    frame = run.get(OccupancyGrid).frame
    every = np.arange(len(final.kind))
    links = [(every, rooms - 1) for rooms in (final.room_a, final.room_b)]
    doors = (frame.cell_from_world(final.start_m), frame.cell_from_world(final.end_m))
    _draw_graph(canvas, doors, final.centre, links)


def _draw_boundary(canvas: Canvas, run: MethodRun) -> None:
    """The path along the walls, closed around the free space and around each island."""
    path = run.get(BoundaryPath)
    for ring in np.split(path.cell, path.first[1:]):
        canvas.ring(ring, style.BOUNDARY)


def _draw_by_kind(canvas: Canvas, places: Places, convex: NDArray[np.bool_]) -> None:
    """Concave and convex places in their colours."""
    canvas.circles(places[~convex], style.CONCAVE)
    canvas.circles(places[convex], style.CONVEX)


def _draw_graph(
    canvas: Canvas, doors: tuple[Places, Places], nodes: Places, links: Sequence[tuple[NDArray[Any], NDArray[Any]]]
) -> None:
    """Doors by their ends, nodes, and lines between doors and nodes, which `links` has by number."""
    start, end = doors
    middle = (start + end) / 2
    for edge, node in links:
        canvas.lines(middle[edge], nodes[node], style.LINK, wide=1.0)
    canvas.lines(start, end, style.DOOR)
    canvas.circles(nodes, style.NODE, size=1.2)
    canvas.circles(middle, style.EDGE_MIDDLE)


Panel = tuple[str, Callable[[Canvas, MethodRun], None]]
"""A title and what is drawn."""
SUB_CASE_PANELS: Mapping[str, tuple[Panel, Panel]] = {
    "3a": (("map", draw_map), ("simplified: what cannot be reached is gone", draw_removed)),
    "3b": (("not flattened: corners at the jut", draw_corners), ("flattened", draw_corners)),
    "3c, 3d": (("c: candidates", draw_candidates), ("d: corners", draw_corners)),
    "3e": (("virtual door of a pair", draw_virtual_doors), ("final map", draw_final_map)),
    "3f": (("virtual door of a single corner", draw_virtual_doors), ("final map", draw_final_map)),
    "3g": (("virtual doors", draw_virtual_doors), ("final map: one is left", draw_final_map)),
}
"""Two panels for each part of figure 3."""
FIGURE_5_PANELS: tuple[Panel, ...] = (
    ("a: occupancy grid", draw_map),
    ("b: simplified", draw_removed),
    ("c: samples that bend: candidates", draw_candidates),
    ("d: corner features", draw_corners),
    ("e: initial topological map", draw_initial_map),
    ("f: final topological map", draw_final_map),
)


def sub_case_picture(case: SubCase) -> bytes:
    """Two panels side by side; the left one is of a run without the step in question, where it can be left out."""
    after = run_method(case.grid)
    before = run_method(case.grid, case.pipeline_undone) if case.pipeline_undone else after
    window = known_window(case.grid.cells, 0)
    width, height = window.inches(SUB_CASE_CELL_PT)
    with drawing(2 * (width + 0.25), height + 0.8) as figure:
        axes = figure.subplots(1, 2)
        for place, (title, draw), run in zip(axes, SUB_CASE_PANELS[case.part], (before, after), strict=True):
            draw(Canvas(place, title, window, cell_pt=SUB_CASE_CELL_PT), run)
        signs = _removed_legend(after) if case.part == "3a" else CORNER_LEGEND
        doors = DOOR_LEGEND if after.get(TopologicalMap).kind.size else ()
        legend(axes[0], [*signs, *BOUNDARY_LEGEND, *doors], columns=6)
        return to_png(figure)


def figure_5_picture(run: MethodRun) -> bytes:
    """The six stages of the walk-through."""
    window = known_window(run.get(SimplifiedGrid).cells, 2)
    width, height = window.inches(FIGURE_5_CELL_PT)
    with drawing(3 * (width + 0.15), 2 * (height + 0.3) + 0.45) as figure:
        axes = figure.subplots(2, 3).ravel()
        for place, (title, draw) in zip(axes, FIGURE_5_PANELS, strict=True):
            draw(Canvas(place, title, window, cell_pt=FIGURE_5_CELL_PT), run)
        legend(axes[0], [*_removed_legend(run), *CORNER_LEGEND, *BOUNDARY_LEGEND, *DOOR_LEGEND], columns=8)
        return to_png(figure)


def _removed_legend(run: MethodRun) -> Iterator[LegendEntry]:
    """The kinds of cells that were removed, as far as there are any."""
    reason = run.get(SimplifiedGrid).reason
    for name, colour in REMOVED.items():
        if (reason == REASONS.index(name)).any():
            yield "s", colour[:3], "unreachable, removed" if name == "unreachable" else f"{name}, flattened"


NEAR = 0.01
"""Costs that differ by less, as a share, cannot be told apart in the picture."""


def search_picture(search: SearchStudy) -> bytes:
    """Cost per generation beside the proven optimum, and the generations in which searches reached that."""
    with drawing(9.2, 3.3) as figure:
        left, right = figure.subplots(1, 2, width_ratios=(3, 2))
        _draw_costs(left, search)
        _draw_generations(right, search)
        return to_png(figure)


def _draw_costs(axes: Axes, search: SearchStudy) -> None:
    courses, optimum = search.courses, search.optimum
    numbers = [course.generation for course in courses]
    for name, colour in (("worst", style.WORST), ("mean", style.MEAN), ("best", style.BEST)):
        costs = [getattr(course, name) for course in courses]
        axes.plot(numbers, costs, color=rgb(colour), label=name, linewidth=1.6)
    axes.axhline(optimum, color="black", linewidth=0.8, linestyle=":", label=f"proven optimum, {optimum:.4f}")
    if search.proven:
        first = search.best_generation
        near = next(course.generation for course in courses if course.best <= courses[-1].best * (1 + NEAR))
        sooner = f", within {NEAR:.0%} from {near} on" if near < first else ""
        axes.plot([first], [optimum], "o", color="black", markersize=5)
        axes.annotate(f"reached in generation {first}{sooner}", (first, optimum), (8, 14), textcoords="offset points")
    axes.set(xlabel="generation", ylabel="cost (eq. 7)", xlim=(0, numbers[-1]), title="cost of the population")
    axes.legend()


def _draw_generations(axes: Axes, search: SearchStudy) -> None:
    reached = search.reached_in
    if reached:
        axes.hist(reached, bins=[at - 0.5 for at in range(max(reached) + 2)], color="0.45")
    axes.axvline(PRINTED_GENERATION, color="black", linewidth=0.8, linestyle=":")
    axes.annotate(
        f"printed: {PRINTED_GENERATION}",
        (PRINTED_GENERATION, 0.9),
        (5, 0),
        xycoords=("data", "axes fraction"),
        textcoords="offset points",
    )
    title = f"{len(reached)} of {len(search.reached)} searches reach it"
    axes.set(xlabel="generation of the optimum", ylabel="searches", title=title)


REAL: style.Colour = (20, 150, 70)
MATCHED: style.Colour = (36, 92, 230)
WRONG: style.Colour = (214, 50, 60)
TABLE_1_LEGEND = (("-", REAL, "real door"), ("-", MATCHED, "found, a real one"), ("-", WRONG, "found, no real one"))


def table_1_picture(seed: int) -> bytes:
    """A row for each furnished environment, a column for the real doors and for each method's."""
    maps = {environment.name: environment.made for environment in environments(furniture=True)}
    windows = [_home_window(made.grid.cells) for made in maps.values()]
    width, height = np.array([window.inches(TABLE_1_CELL_PT) for window in windows]).T
    columns = 1 + max(len(methods_for(made)) for made in maps.values())
    with drawing(columns * (width.max() + 0.15), height.sum() + 0.3 * len(maps) + 0.4) as figure:
        axes = figure.subplots(len(maps), columns, squeeze=False, height_ratios=height)
        for row, (name, made), window in zip(axes, maps.items(), windows, strict=True):
            canvas = Canvas(row[0], f"{name}: real doors", window, cell_pt=TABLE_1_CELL_PT)
            _draw_doors(canvas, made.grid, {REAL: real_doors_m(made)})
            for place, (method, pipeline) in zip(row[1:], methods_for(made).items(), strict=True):
                found = detect_doors(made, pipeline, seed=seed)
                title = f"{METHOD_TITLES[method]}: {found.count.matched} of {found.count.virtual}"
                doors = {MATCHED: found.virtual_m[found.is_matched], WRONG: found.virtual_m[~found.is_matched]}
                _draw_doors(Canvas(place, title, window, cell_pt=TABLE_1_CELL_PT), made.grid, doors)
        legend(axes[0, 0], TABLE_1_LEGEND, columns=3)
        return to_png(figure)


def _home_window(cells: NDArray[np.int8]) -> Window:
    """What is known, without the blots outside: rows and columns with many known cells are those of the home."""
    rows, columns = (np.flatnonzero((cells >= 0).sum(axis=axis) > cells.shape[axis] / 4) for axis in (1, 0))
    known = known_window(cells, 0)
    return Window(
        max(int(rows[0]) - 1, known.top),
        min(int(rows[-1]) + 1, known.bottom),
        max(int(columns[0]) - 1, known.left),
        min(int(columns[-1]) + 1, known.right),
    )


def _draw_doors(canvas: Canvas, grid: OccupancyGrid, doors: Mapping[style.Colour, Lines]) -> None:
    """The map and the doors of each colour."""
    canvas.cells(grid.cells)
    for colour, lines in doors.items():
        start, end = (grid.frame.cell_from_world(lines[:, at]) for at in (0, 1))
        canvas.lines(start, end, colour, wide=3.0)
