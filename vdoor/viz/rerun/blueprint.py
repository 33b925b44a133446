"""The blueprint of a recording: an overview, then one tab per stage."""

from __future__ import annotations

import functools
from collections.abc import Callable, Mapping
from typing import Any

import rerun.blueprint as rrb

from vdoor.emit import RunInfo
from vdoor.explain.stages import OVERVIEW, StageView, tabs_of, view_of
from vdoor.pipeline import emitted

DESCRIPTION = """# vdoor: from a map to rooms and doors

Each tab shows one stage of the method, in order. **Drag along the timeline `step`** to go from stage to stage and, in
the search, from generation to generation. Other timelines, selected at the bottom left, show details:

- `sample`: the walk along the boundary, with the wall on the left; red and violet arrows are f and b of eq. 3 and 4.
  The curvature plot runs along this timeline.
- `corner`: the rows of the table of corners.
- `generation`: the search; red lines are the doors kept by the best string.
- `drive`: the robot on its way, by centimetres.

| tab | content |
|---|---|
{tabs}

Lengths in the views are in cells; hover over an element for its numbers.
"""

WORKING = "map/simplified"

Settings = Mapping[str, Any]
"""Settings of a run, as nested tables."""


def includes(settings: Settings, stage: str) -> bool:
    """Whether a run includes an optional stage."""
    return bool(settings.get(stage, {}).get("method", "none") != "none")


def description(info: RunInfo) -> str:
    """Guide to the tabs of a run, as Markdown."""
    records = emitted(info)
    meaning = {view.tab: view.meaning for view in map(view_of, records) if view.meaning}
    tabs = tabs_of(records, info.settings)
    return DESCRIPTION.format(tabs="\n".join(f"| {tab} | {meaning[tab]} |" for tab in tabs if tab in meaning))


def blueprint(info: RunInfo) -> rrb.Blueprint:
    """The default blueprint for a run."""
    records = emitted(info)
    names = tabs_of(records, info.settings)
    plain = {view.tab: functools.partial(plain_stage, view) for view in map(view_of, records)}
    made = plain | VIEWS | {OVERVIEW: lambda: overview(names, info.settings), "Search": lambda: search(info.settings)}
    # At the end, with everything drawn.
    panel = rrb.TimePanel(state="collapsed", timeline="step", play_state="following")
    return rrb.Blueprint(
        rrb.Tabs(*(made[name]() for name in names), active_tab=0),
        rrb.BlueprintPanel(state="collapsed"),
        rrb.SelectionPanel(state="collapsed"),
        panel,
        auto_views=False,
        auto_layout=False,
    )


def plain_stage(view: StageView) -> rrb.Container:
    """Tab of a stage without a function of its own: its rasters and its table."""
    topic = view.record.topic
    seen = flat(view.name, WORKING, f"other/{topic}/**", origin="/")
    rows = rrb.archetypes.DataframeQuery(timeline="row")
    table = rrb.DataframeView(origin=f"tables/{topic}", name="Rows", query=rows)
    return rrb.Horizontal(seen, table, column_shares=[3, 2], name=view.tab)


def flat(name: str, *contents: str, origin: str = "map") -> rrb.Spatial2DView:
    """A 2D view of some entities, relative to `origin`."""
    return rrb.Spatial2DView(name=name, origin=origin, contents=[f"+ /{path}" for path in contents])


def overview(tabs: tuple[str, ...], settings: Settings) -> rrb.Container:
    """Tab with the final map beside the plots of curvature and cost."""
    plots = [*([curve()] if "Curvature" in tabs else []), *([cost(settings)] if "Search" in tabs else [])]
    notes = rrb.Tabs(
        rrb.TextDocumentView(origin="description", name="Read me"), rrb.TextLogView(origin="log", name="Log"), stages()
    )
    beside = rrb.Vertical(rrb.Vertical(*plots), notes, row_shares=[3, 2]) if plots else notes
    return rrb.Horizontal(final_map(), beside, column_shares=[3, 2], name="Overview")


def simplified() -> rrb.Container:
    """Tab with the input, and the working grid with its changed cells."""
    working = flat("Simplified, changed cells in colour", WORKING, "map/removed")
    return rrb.Horizontal(flat("Input", "input/map", origin="input"), working, name="Simplified")


def path() -> rrb.Container:
    """Tab with the walk along the boundary."""
    return rrb.Horizontal(flat("Left-hand path", WORKING, "map/path", "map/walker", "map/heading"), name="Path")


def curvature() -> rrb.Container:
    """Tab with the curvature plot, and the vectors f and b at the walker."""
    walk = flat("f and b at the walker", WORKING, "map/path", "map/walker", "map/vectors")
    lines = rrb.TimeSeriesView(origin="plots/curvature", name="Angle by sample (select the timeline `sample`)")
    return rrb.Horizontal(walk, rrb.Vertical(curve(), lines), name="Curvature")


def corners() -> rrb.Container:
    """Tab with candidates, corners and the table of corners."""
    seen = flat("Candidates (small) and corners (large)", WORKING, "map/candidates/**", "map/corners/**")
    table = rrb.DataframeView(
        origin="tables/corners", name="Corners", query=rrb.archetypes.DataframeQuery(timeline="corner")
    )
    return rrb.Horizontal(seen, table, column_shares=[3, 2], name="Corners")


def doors() -> rrb.Container:
    """Tab with proposed and rejected doors, and their table."""
    proposed = flat("Proposed", WORKING, "map/corners/convex", "map/doors/proposed")
    rejected = flat("Rejected, one layer per reason", WORKING, "map/doors/rejected/**")
    table = rrb.DataframeView(
        origin="tables/doors", name="All doors", query=rrb.archetypes.DataframeQuery(timeline="row")
    )
    return rrb.Vertical(rrb.Horizontal(proposed, rejected), table, row_shares=[3, 1], name="Doors")


def scores() -> rrb.Container:
    """Tab with scored doors, their scores and features."""
    likely = flat(
        "Likely doors, doubtful (orange) to sure (green)", WORKING, "map/scores/likely", "map/scores/conflicts"
    )
    others = flat("Unlikely and outdone", WORKING, "map/scores/unlikely", "map/scores/outdone")
    rows = rrb.archetypes.DataframeQuery(timeline="row")
    tables = [
        rrb.DataframeView(origin=f"tables/{table}", name=name, query=rows)
        for table, name in (("door_scores", "Scores"), ("door_features", "Features"))
    ]
    return rrb.Vertical(rrb.Horizontal(likely, others), rrb.Horizontal(*tables), row_shares=[3, 1], name="Scores")


def narrow_places() -> rrb.Container:
    """Tab with the skeleton and its narrow places."""
    skeleton = flat("Skeleton", WORKING, "map/skeleton")
    return rrb.Horizontal(skeleton, flat("Narrow places", WORKING, "map/narrows/**"), name="Narrow places")


def cores() -> rrb.Container:
    """Tab with the eroded free space, and the rooms grown back from it."""
    left = flat("Eroded free space", WORKING, "map/eroded")
    return rrb.Horizontal(left, flat("Rooms grown back", WORKING, "map/grown"), name="Cores")


def initial_map() -> rrb.Container:
    """Tab with the initial topological map over the grid, and as a graph."""
    over = flat("Over the map", WORKING, "map/regions", "map/doors/proposed", "map/initial/**")
    return rrb.Horizontal(over, rrb.GraphView(origin="graph/initial", name="Rooms and doors"), name="Initial map")


def search(settings: Settings) -> rrb.Container:
    """Tab with the kept doors, the cost by generation, and the certificate if there is one."""
    kept = flat("Doors kept by the best string", WORKING, "map/search/**")
    terms = rrb.TimeSeriesView(
        origin="plots/terms", name="Terms of eq. 7 (best string)", plot_legend=rrb.Corner2D.RightTop
    )
    proof = [rrb.TextDocumentView(origin="certificate", name="Certificate")] if includes(settings, "certify") else []
    return rrb.Horizontal(kept, rrb.Vertical(cost(settings), terms, *proof), name="Search")


def rooms() -> rrb.Container:
    """Tab with the final map over the input, and as a graph."""
    return rrb.Horizontal(
        final_map(), rrb.GraphView(origin="graph/final", name="Graph"), column_shares=[2, 1], name="Rooms"
    )


def route() -> rrb.Container:
    """Tab with the route over the rooms."""
    seen = flat("Route", "input/map", "rooms/labels", "rooms/doors", "route/**", origin="/")
    return rrb.Horizontal(seen, name="Route")


def coverage() -> rrb.Container:
    """Tab with the path that covers the floor, and what it sweeps."""
    seen = flat("Coverage", "input/map", "rooms/doors", "coverage/**", origin="/")
    return rrb.Horizontal(seen, name="Coverage")


def final_map() -> rrb.Spatial2DView:
    """View of rooms, doors and graph over the input."""
    return rrb.Spatial2DView(name="Rooms and doors", origin="/", contents=["+ /input/map", "+ /rooms/**"])


def curve() -> rrb.Spatial2DView:
    """View of the angle at each sample, shown on every timeline."""
    return rrb.Spatial2DView(origin="curve", name="Angle between f and b by sample, degrees (eq. 5)")


def cost(settings: Settings) -> rrb.TimeSeriesView:
    """Plot of best, mean and worst cost by generation."""
    formula = "energy of scored doors" if includes(settings, "score") else "eq. 7"
    return rrb.TimeSeriesView(
        origin="plots/search", name=f"Cost by generation ({formula})", plot_legend=rrb.Corner2D.RightTop
    )


def stages() -> rrb.StateTimelineView:
    """View of the stage at each step."""
    return rrb.StateTimelineView(origin="state", name="Stages")


VIEWS: dict[str, Callable[[], rrb.Container]] = {
    "Simplified": simplified,
    "Path": path,
    "Curvature": curvature,
    "Corners": corners,
    "Narrow places": narrow_places,
    "Cores": cores,
    "Doors": doors,
    "Scores": scores,
    "Initial map": initial_map,
    "Rooms": rooms,
    "Route": route,
    "Coverage": coverage,
}
"""Tabs that do not depend on the settings."""
