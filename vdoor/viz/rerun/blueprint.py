"""The blueprint of a recording: an overview, then one tab per stage."""

from __future__ import annotations

import functools
from collections.abc import Callable, Iterable, Mapping
from typing import Any

import rerun.blueprint as rrb

from vdoor.emit import RunInfo
from vdoor.explain.stages import OVERVIEW, StageView, sentence_of, tabs_of, view_of
from vdoor.method.doors import PROPOSED, VERDICTS
from vdoor.method.scoring.score import JUDGEMENTS, LIKELY
from vdoor.pipeline import emitted
from vdoor.viz.marks.kinds import path_name
from vdoor.viz.rerun.chart import view_of_chart
from vdoor.viz.rerun.graphs import SIDE

DESCRIPTION = """# vdoor: from a map to rooms and doors

Each tab shows one stage of the method, in order. **Drag along the timeline `step`** to go from stage to stage and, in
the search, from generation to generation. Other timelines, selected at the bottom left, show details:

- `sample`: the walk along the boundary, with the wall on the left; red and violet arrows are f and b of eq. 3 and 4.
- `corner`: the rows of the table of corners.
- `generation`: the search; red lines are the doors kept by the best string.
- `drive`: the robot on its way, by centimetres.

| tab | what it shows |
|---|---|
{tabs}

Lengths in the views are in cells; hover over an element for its numbers. Layers that are off at first, such as
rejected doors, are switched on in the panel at the left.
"""

WORKING = "map/simplified"
FORBIDDEN = "Where a vacuum's map forbids it to go: violet walls, orange no-go areas, blue no-mop areas."
COLOURS = {
    OVERVIEW: f"Red: doors and links of the graph. Yellow: rooms. {FORBIDDEN}",
    "Simplified": (
        "Pink: unreachable, now unknown. Orange: a bump, yellow: furniture, violet: a thin unknown line, red: unseen "
        "floor of a doorway; all now free. Light blue: a dent, filled. Teal: a slit, closed."
    ),
    "Path": "Arrows show the way. The red dot is the walker; the timeline `sample` moves it.",
    "Curvature": (
        "Blue: nearly straight; from yellow over orange to red: ever sharper. At the red dot, a red arrow ahead and a "
        "violet one back have the angle between them."
    ),
    "Corners": "Blue: convex. Green: concave.",
    "Doors": (
        "Blue: proposed. Off at first: orange, blocked by a wall; olive, both ends on one wall; light blue, duplicate; "
        "violet, too narrow; dark, no gap."
    ),
    "Scores": "Pink lines join doors of which only one can be kept.",
    "Initial map": "Blue: doors. Yellow: the regions' nodes. Red: the graph's links.",
    "Search": "Red: kept. Greyish blue: removed.",
    "Route": "Blue: the route. Dark blue: its start, stops and goal. Red: doors, and what is in the way.",
    "Coverage": "Light blue: swept. Violet: along walls. Blue: in lanes. Red: on the way to the next, and doors.",
    "Rooms": (
        "Red: doors with their numbers, and the links of the graph. Yellow: rooms with their numbers and areas. "
        f"{FORBIDDEN}"
    ),
}
"""What colours mean in the viewer, which has no legend."""
ANGLES = "Angle in degrees, by metres of boundary; threshold red"
COSTS = "Cost by generation: best green, mean blue, worst grey, bound pink"
TERMS = "Terms of eq. 7 by generation: small rooms green, spread of areas blue, tilt grey"
MARGIN = 45.0
"""Around the graph, for the labels at its edge."""
SENTENCE_SHARE = 9.0
"""Height of a tab's view over that of its sentence."""

Settings = Mapping[str, Any]
"""Settings of a run, as nested tables."""
Content = rrb.View | rrb.Container


def includes(settings: Settings, stage: str) -> bool:
    """Whether a run includes an optional stage."""
    return bool(settings.get(stage, {}).get("method", "none") != "none")


def description(info: RunInfo) -> str:
    """Guide to the tabs of a run, as Markdown."""
    tabs = tabs_of(emitted(info), info.settings)
    return DESCRIPTION.format(tabs="\n".join(f"| {tab} | {sentence_of(tab)} |" for tab in tabs))


def says(tab: str) -> str:
    """The entity of a tab's sentence."""
    return f"says/{tab.lower().replace(' ', '_')}"


def blueprint(info: RunInfo) -> rrb.Blueprint:
    """The default blueprint for a run."""
    records = emitted(info)
    names = tabs_of(records, info.settings)
    plain = {view.tab: functools.partial(plain_stage, view) for view in map(view_of, records)}
    made = plain | VIEWS | {OVERVIEW: lambda: overview(names), "Search": lambda: search(info.settings)}
    # At the end, with everything drawn.
    panel = rrb.TimePanel(state="collapsed", timeline="step", play_state="following")
    return rrb.Blueprint(
        rrb.Tabs(*(explained(name, made[name]()) for name in names), active_tab=0),
        rrb.BlueprintPanel(state="collapsed"),
        rrb.SelectionPanel(state="collapsed"),
        panel,
        auto_views=False,
        auto_layout=False,
    )


def told(tab: str) -> str:
    """What is seen in a tab, and what its colours mean."""
    return f"{sentence_of(tab)} {COLOURS.get(tab, '')}".rstrip()


def explained(tab: str, content: Content) -> rrb.Container:
    """A tab: what is seen in a sentence, and below it what there is to see."""
    sentence = rrb.TextDocumentView(origin=says(tab), name="What is seen here")
    return rrb.Vertical(sentence, content, row_shares=[1, SENTENCE_SHARE], name=tab)


def plain_stage(view: StageView) -> Content:
    """Tab of a stage without a function of its own: its rasters and its table."""
    topic = view.record.topic
    seen = flat(view.name, WORKING, f"other/{topic}/**", origin="/")
    return rrb.Horizontal(seen, rows(f"tables/{topic}", "Rows"), column_shares=[3, 2])


def flat(name: str, *contents: str, origin: str = "map", off: Iterable[str] = ()) -> rrb.Spatial2DView:
    """A 2D view of some entities, relative to `origin`; some of them are switched off at first."""
    hidden: dict[Any, Any] = {f"/{path}": rrb.EntityBehavior(visible=False) for path in off}
    return rrb.Spatial2DView(name=name, origin=origin, contents=[f"+ /{path}" for path in contents], overrides=hidden)


def rows(origin: str, name: str, *columns: str, timeline: str = "row") -> rrb.DataframeView:
    """A table: some of its columns, or all of them, without the timelines that all rows share."""
    select: list[Any] | None = [timeline, *(f"/{origin}:{column}" for column in columns)] if columns else None
    query = rrb.archetypes.DataframeQuery(timeline=timeline, select=select)
    return rrb.DataframeView(origin=origin, name=name, query=query)


def overview(tabs: tuple[str, ...]) -> Content:
    """Tab with the final map beside the charts of curvature and cost."""
    charts = [*([curve()] if "Curvature" in tabs else []), *([cost()] if "Search" in tabs else [])]
    notes = rrb.Tabs(
        rrb.TextDocumentView(origin="description", name="Read me"), rrb.TextLogView(origin="log", name="Log"), stages()
    )
    beside = rrb.Vertical(*charts, notes, row_shares=[3] * len(charts) + [4]) if charts else notes
    return rrb.Horizontal(final_map(), beside, column_shares=[3, 2])


def simplified() -> Content:
    """Tab with the input, and the working grid with its changed cells."""
    working = flat("Simplified, changed cells in colour", WORKING, "map/simplified/changed")
    return rrb.Horizontal(flat("As it was read", "input/map/**", origin="input"), working)


def path() -> Content:
    """Tab with the walk along the boundary."""
    return flat("Boundary, and the way it is walked", WORKING, "map/path/**", "map/walker", "map/heading")


def curvature() -> Content:
    """Tab with the boundary in colours of its angle, and the chart of the angle."""
    walk = flat("Sharp bends are red", WORKING, "map/curvature/**", "map/walker", "map/vectors")
    return rrb.Horizontal(walk, curve(), column_shares=[3, 2])


def corners() -> Content:
    """Tab with candidates, corners and the table of corners."""
    seen = flat("Candidates small, corners large", WORKING, "map/candidates/**", "map/corners/**")
    table = rows("tables/corners", "Corners", "sample", "angle_deg", "convex", "cell_row_col", timeline="corner")
    return rrb.Horizontal(seen, table, column_shares=[3, 2])


def doors() -> Content:
    """Tab with proposed doors, rejected ones switched off at first, and their table."""
    reasons = [f"map/doors/{path_name(word)}" for word in VERDICTS if word != VERDICTS[PROPOSED]]
    seen = flat(
        "Proposed; rejected ones can be switched on", WORKING, "map/corners/convex", "map/doors/**", off=reasons
    )
    table = rows("tables/doors", "Doors", "verdict_in_words", "kind_in_words", "width_m", "tilt_deg")
    return rrb.Horizontal(seen, table, column_shares=[3, 2])


def scores() -> Content:
    """Tab with scored doors, their scores and features."""
    out = [f"map/scores/{word}" for word in JUDGEMENTS if word != JUDGEMENTS[LIKELY]]
    seen = flat("Doubtful (orange) to sure (green)", WORKING, "map/scores/**", off=out)
    tables = rrb.Tabs(
        rows("tables/door_scores", "Scores", "door", "log_odds", "judgement_in_words", "sure"),
        rows("tables/door_features", "Features"),
        active_tab=0,
    )
    return rrb.Horizontal(seen, tables, column_shares=[3, 2])


def narrow_places() -> Content:
    """Tab with the skeleton and its narrow places."""
    skeleton = flat("Skeleton", WORKING, "map/skeleton/**")
    return rrb.Horizontal(skeleton, flat("Narrow places", WORKING, "map/narrows/**"))


def cores() -> Content:
    """Tab with the eroded free space, and the rooms grown back from it."""
    left = flat("Eroded free space", WORKING, "map/eroded/**")
    return rrb.Horizontal(left, flat("Rooms grown back", WORKING, "map/grown/**"))


def initial_map() -> Content:
    """Tab with the initial topological map over the grid."""
    return flat("Regions and the doors on their borders", WORKING, "map/initial/**")


def search(settings: Settings) -> Content:
    """Tab with the kept doors, the cost by generation, and the certificate or the terms of the cost."""
    kept = flat("Doors kept and removed", WORKING, "map/search/**")
    scored = includes(settings, "score") or not settings
    terms = [] if scored else [view_of_chart("charts/terms", TERMS)]
    proof = [rrb.TextDocumentView(origin="certificate", name="Certificate")] if includes(settings, "certify") else []
    return rrb.Horizontal(kept, rrb.Vertical(cost(), *terms, *proof), column_shares=[3, 2])


def rooms() -> Content:
    """Tab with the final map over the input, and as a graph."""
    bounds = rrb.VisualBounds2D(x_range=[-MARGIN, SIDE + MARGIN], y_range=[-MARGIN, SIDE + MARGIN])
    graph = rrb.GraphView(origin="graph/final", name="Graph of rooms, by number", visual_bounds=bounds)
    return rrb.Horizontal(final_map(), graph, column_shares=[2, 1])


def route() -> Content:
    """Tab with the route over the rooms."""
    return flat("Route", "input/map", "rooms/rooms", "rooms/doors", "rooms/labels", "route/**", origin="/")


def coverage() -> Content:
    """Tab with the path that covers the floor, and what it sweeps."""
    parts = ("input/map", "rooms/doors", "coverage/floor", "coverage/path/**", "coverage/robot")
    return flat("Coverage", *parts, origin="/")


def final_map() -> rrb.Spatial2DView:
    """View of rooms, doors and graph over the input."""
    return flat("Rooms and doors", "input/map/**", "rooms/**", origin="/")


def curve() -> rrb.Spatial2DView:
    """Chart of the angle along the boundary."""
    return view_of_chart("charts/curvature", ANGLES)


def cost() -> rrb.Spatial2DView:
    """Chart of best, mean and worst cost by generation."""
    return view_of_chart("charts/cost", COSTS)


def stages() -> rrb.StateTimelineView:
    """View of the stage at each step."""
    return rrb.StateTimelineView(origin="state", name="Stages")


VIEWS: dict[str, Callable[[], Content]] = {
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
