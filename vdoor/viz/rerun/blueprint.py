"""The view that a recording opens with: an overview, then a tab for each stage."""

from __future__ import annotations

import functools
from collections.abc import Callable, Iterable, Mapping
from typing import Any

import rerun.blueprint as rrb

from vdoor.emit import RunInfo
from vdoor.explain.stages import STAGE_VIEWS, StageView, view_of
from vdoor.pipeline import RECORDS, emitted
from vdoor.record import Record

DESCRIPTION = """# vdoor: from a map to rooms and doors

Each tab is one stage of the method, in order. **Drag along the timeline `step`** to pass from stage to stage and,
in the search, from generation to generation. Choose another timeline at the bottom left to look closer:

- `sample`: the walker goes along the boundary, wall on its left; red and violet arrows are f and b of eq. 3 and 4.
  The curvature plot is drawn along this timeline.
- `corner`: one row of the corners' table after the other.
- `generation`: the search; red lines are the doors that the best string keeps.

| tab | what is seen |
|---|---|
{tabs}

Lengths in the views are cells; hover over an element for its numbers.
"""

WORKING = "map/simplified"
OVERVIEW = "Overview"

Settings = Mapping[str, Any]
"""Of a run, as nested tables."""


def tabs_of(records: Iterable[type[Record]], settings: Settings) -> tuple[str, ...]:
    """The tabs in which a run that emits these records with these settings has something to show."""
    shown = [
        view for view in map(view_of, in_order(records)) if not (view.needs and settings) or view.needs in settings
    ]
    return tuple(dict.fromkeys([OVERVIEW, *(view.tab for view in shown)]))


def every_tab() -> tuple[str, ...]:
    """All tabs that runs can have."""
    return tuple(dict.fromkeys([OVERVIEW, *(view.tab for view in map(view_of, in_order(RECORDS)))]))


def in_order(records: Iterable[type[Record]]) -> list[type[Record]]:
    """The records in the order of the rows of `STAGE_VIEWS`, those without a row last."""
    there = list(records)
    own = [view.record for view in STAGE_VIEWS if view.record in there]
    return [*own, *(record for record in there if record not in own)]


def does(settings: Settings, stage: str) -> bool:
    """Whether a run has a stage that can be left out."""
    return bool(settings.get(stage, {}).get("method", "none") != "none")


def description(info: RunInfo) -> str:
    """What the tabs of a run show, as Markdown."""
    meaning = {view.tab: view.meaning for view in map(view_of, emitted(info)) if view.meaning}
    tabs = tabs_of(emitted(info), info.settings)
    return DESCRIPTION.format(tabs="\n".join(f"| {tab} | {meaning[tab]} |" for tab in tabs if tab in meaning))


def blueprint(info: RunInfo) -> rrb.Blueprint:
    """The default blueprint for a run."""
    names = tabs_of(emitted(info), info.settings)
    made = VIEWS | {
        OVERVIEW: lambda: overview(names, info.settings),
        "Search": lambda: search(info.settings),
    }
    plain = {
        view.tab: functools.partial(plain_stage, view) for view in map(view_of, emitted(info)) if view.tab not in made
    }
    panel = rrb.TimePanel(state="collapsed", timeline="step", play_state="following")  # at the end, where all is drawn
    return rrb.Blueprint(
        rrb.Tabs(*((made | plain)[name]() for name in names), active_tab=0),
        rrb.BlueprintPanel(state="collapsed"),
        rrb.SelectionPanel(state="collapsed"),
        panel,
        auto_views=False,
        auto_layout=False,
    )


def plain_stage(view: StageView) -> rrb.Container:
    """A stage that has no tab made for it: its rasters and its table."""
    topic = view.record.topic
    seen = flat(view.name, WORKING, f"other/{topic}/**", origin="/")
    rows = rrb.archetypes.DataframeQuery(timeline="row")
    table = rrb.DataframeView(origin=f"tables/{topic}", name="Rows", query=rows)
    return rrb.Horizontal(seen, table, column_shares=[3, 2], name=view.tab)


def flat(name: str, *contents: str, origin: str = "map") -> rrb.Spatial2DView:
    """A view of some entities of one frame."""
    return rrb.Spatial2DView(name=name, origin=origin, contents=[f"+ /{path}" for path in contents])


def overview(tabs: tuple[str, ...], settings: Settings) -> rrb.Container:
    """The result beside the plots that led to it."""
    plots = [*([curve()] if "Curvature" in tabs else []), *([cost(settings)] if "Search" in tabs else [])]
    notes = rrb.Tabs(
        rrb.TextDocumentView(origin="description", name="Read me"), rrb.TextLogView(origin="log", name="Log"), stages()
    )
    beside = rrb.Vertical(rrb.Vertical(*plots), notes, row_shares=[3, 2]) if plots else notes
    return rrb.Horizontal(final_map(), beside, column_shares=[3, 2], name="Overview")


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


def scores() -> rrb.Container:
    """Doors by what speaks for them."""
    likely = flat("Likely doors, orange doubtful to green sure", WORKING, "map/scores/likely", "map/scores/rivals")
    others = flat("Unlikely and outdone", WORKING, "map/scores/unlikely", "map/scores/outdone")
    rows = rrb.archetypes.DataframeQuery(timeline="row")
    tables = [
        rrb.DataframeView(origin=f"tables/{table}", name=name, query=rows)
        for table, name in (("door_scores", "Scores"), ("door_features", "Features"))
    ]
    return rrb.Vertical(rrb.Horizontal(likely, others), rrb.Horizontal(*tables), row_shares=[3, 1], name="Scores")


def narrow_places() -> rrb.Container:
    """The skeleton, and where it is narrow."""
    skeleton = flat("Skeleton", WORKING, "map/skeleton")
    return rrb.Horizontal(skeleton, flat("Narrow places", WORKING, "map/narrows/**"), name="Narrow places")


def cores() -> rrb.Container:
    """What is left of the free space, and what grows back from it."""
    left = flat("Far from walls", WORKING, "map/eroded")
    return rrb.Horizontal(left, flat("Grown back", WORKING, "map/grown"), name="Cores")


def initial_map() -> rrb.Container:
    """The initial topological map over the grid, and as a graph."""
    over = flat("Over the map", WORKING, "map/regions", "map/doors/proposed", "map/initial/**")
    return rrb.Horizontal(over, rrb.GraphView(origin="graph/initial", name="Rooms and doors"), name="Initial map")


def search(settings: Settings) -> rrb.Container:
    """Cost by generation, and the doors kept; what was proven of them, where that was asked."""
    kept = flat("Doors kept by the best string", WORKING, "map/search/**")
    terms = rrb.TimeSeriesView(
        origin="plots/terms", name="Terms of eq. 7 (best string)", plot_legend=rrb.Corner2D.RightTop
    )
    proven = [rrb.TextDocumentView(origin="certificate", name="Proven")] if does(settings, "certify") else []
    return rrb.Horizontal(kept, rrb.Vertical(cost(settings), terms, *proven), name="Search")


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


def cost(settings: Settings) -> rrb.TimeSeriesView:
    """Best, mean and worst cost."""
    formula = "energy of scored doors" if does(settings, "score") else "eq. 7"
    return rrb.TimeSeriesView(
        origin="plots/search", name=f"Cost by generation ({formula})", plot_legend=rrb.Corner2D.RightTop
    )


def stages() -> rrb.StateTimelineView:
    """When each stage ran."""
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
}
"""Tabs that are the same in every run."""
