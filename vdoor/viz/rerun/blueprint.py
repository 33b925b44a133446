"""The view that a recording opens with: an overview, then a tab for each stage."""

from __future__ import annotations

import rerun.blueprint as rrb

DESCRIPTION = """# vdoor: from a map to rooms and doors

Each tab is one stage of the method, in order. **Drag along the timeline `step`** to pass from stage to stage and,
in the search, from generation to generation. Choose another timeline at the bottom left to look closer:

- `sample`: the walker goes along the boundary, wall on its left; red and violet arrows are f and b of eq. 3 and 4.
  The curvature plot is drawn along this timeline.
- `corner`: one row of the corners' table after the other.
- `generation`: the search; red lines are the doors that the best string keeps.

| tab | what is seen |
|---|---|
| Simplified | the working grid; coloured cells were removed: unreachable, jut, notch, island |
| Path | boundary (yellow), walker and heading |
| Curvature | angle between f and b; below the threshold a sample is a candidate |
| Corners | candidates (small) and corner features (large); blue convex, green concave |
| Doors | proposed doors (blue), rejected ones in a layer for each reason |
| Initial map | regions, rooms (yellow) and doors (red) as a graph |
| Search | cost, its three terms, kept doors |
| Rooms | the result |

Lengths in the views are cells; hover over an element for its numbers.
"""

WORKING = "map/simplified"


TABS = ("Overview", "Simplified", "Path", "Curvature", "Corners", "Doors", "Initial map", "Search", "Rooms")


def blueprint(active_tab: str = TABS[0]) -> rrb.Blueprint:
    """The default blueprint, opened at one of its tabs."""
    tabs = (overview(), simplified(), path(), curvature(), corners(), doors(), initial_map(), search(), rooms())
    panel = rrb.TimePanel(state="collapsed", timeline="step", play_state="following")  # at the end, where all is drawn
    return rrb.Blueprint(
        rrb.Tabs(*tabs, active_tab=TABS.index(active_tab)),
        rrb.BlueprintPanel(state="collapsed"),
        rrb.SelectionPanel(state="collapsed"),
        panel,
        auto_views=False,
        auto_layout=False,
    )


def flat(name: str, *contents: str, origin: str = "map") -> rrb.Spatial2DView:
    """A view of some entities of one frame."""
    return rrb.Spatial2DView(name=name, origin=origin, contents=[f"+ /{path}" for path in contents])


def overview() -> rrb.Container:
    """The result beside the two plots that led to it."""
    plots = rrb.Vertical(curve(), cost(), row_shares=[1, 1])
    notes = rrb.Tabs(
        rrb.TextDocumentView(origin="description", name="Read me"), rrb.TextLogView(origin="log", name="Log"), stages()
    )
    return rrb.Horizontal(
        final_map(), rrb.Vertical(plots, notes, row_shares=[3, 2]), column_shares=[3, 2], name="Overview"
    )


def simplified() -> rrb.Container:
    """Input, and the working grid with what was removed."""
    working = flat("Simplified, what was removed in colour", WORKING, "map/removed")
    return rrb.Horizontal(flat("Input", "input/map", origin="input"), working, name="Simplified")


def path() -> rrb.Container:
    """The walk."""
    return rrb.Horizontal(flat("Left-hand path", WORKING, "map/path", "map/walker", "map/heading"), name="Path")


def curvature() -> rrb.Container:
    """The plot, and the vectors at the walker."""
    walk = flat("f and b at the walker", WORKING, "map/path", "map/walker", "map/vectors")
    lines = rrb.TimeSeriesView(origin="plots/curvature", name="Angle by sample (choose the timeline `sample`)")
    return rrb.Horizontal(walk, rrb.Vertical(curve(), lines), name="Curvature")


def corners() -> rrb.Container:
    """Candidates, corners and their table."""
    seen = flat("Candidates (small) and corners (large)", WORKING, "map/candidates/**", "map/corners/**")
    table = rrb.DataframeView(
        origin="tables/corners", name="Corners", query=rrb.archetypes.DataframeQuery(timeline="corner")
    )
    return rrb.Horizontal(seen, table, column_shares=[3, 2], name="Corners")


def doors() -> rrb.Container:
    """Proposed and rejected doors."""
    proposed = flat("Proposed", WORKING, "map/corners/convex", "map/doors/proposed")
    rejected = flat("Rejected, a layer for each reason", WORKING, "map/doors/rejected/**")
    table = rrb.DataframeView(
        origin="tables/doors", name="All doors", query=rrb.archetypes.DataframeQuery(timeline="row")
    )
    return rrb.Vertical(rrb.Horizontal(proposed, rejected), table, row_shares=[3, 1], name="Doors")


def initial_map() -> rrb.Container:
    """The initial topological map over the grid, and as a graph."""
    over = flat("Over the map", WORKING, "map/regions", "map/doors/proposed", "map/initial/**")
    return rrb.Horizontal(over, rrb.GraphView(origin="graph/initial", name="Rooms and doors"), name="Initial map")


def search() -> rrb.Container:
    """Cost by generation, and the doors kept."""
    kept = flat("Doors kept by the best string", WORKING, "map/search/**")
    terms = rrb.TimeSeriesView(
        origin="plots/terms", name="Terms of eq. 7 (best string)", plot_legend=rrb.Corner2D.RightTop
    )
    return rrb.Horizontal(kept, rrb.Vertical(cost(), terms), name="Search")


def rooms() -> rrb.Container:
    """The result over the map, and as a graph."""
    return rrb.Horizontal(
        final_map(), rrb.GraphView(origin="graph/final", name="Graph"), column_shares=[2, 1], name="Rooms"
    )


def final_map() -> rrb.Spatial2DView:
    """Rooms, doors and graph over the input."""
    return rrb.Spatial2DView(name="Rooms and doors", origin="/", contents=["+ /input/map", "+ /rooms/**"])


def curve() -> rrb.Spatial2DView:
    """The angle at each sample, readable on every timeline."""
    return rrb.Spatial2DView(origin="curve", name="Angle between f and b by sample, degrees (eq. 5)")


def cost() -> rrb.TimeSeriesView:
    """Best, mean and worst cost."""
    return rrb.TimeSeriesView(
        origin="plots/search", name="Cost by generation (eq. 7)", plot_legend=rrb.Corner2D.RightTop
    )


def stages() -> rrb.StateTimelineView:
    """When each stage ran."""
    return rrb.StateTimelineView(origin="state", name="Stages")
