"""What each picture shows: maps with their marks, and charts. A picture is named like the viewer's tab."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import NamedTuple

from vdoor.baselines import ErodedSpace, GrownRooms
from vdoor.editing.apply import Edits
from vdoor.explain.stages import OVERVIEW, sentence_of, tabs_of, view_of
from vdoor.history import History
from vdoor.method.corners import Corners
from vdoor.method.curvature import Curvature
from vdoor.method.doors import VirtualDoors
from vdoor.method.search.generation import Generation
from vdoor.navigate.cover_floor import Coverage
from vdoor.navigate.find_route import Route
from vdoor.pipeline import RECORDS, Pipeline
from vdoor.record import Record
from vdoor.topology import TopologicalMap
from vdoor.viz.marks import boundary, maps, plots
from vdoor.viz.marks.kinds import Cells, Chart, Mark
from vdoor.viz.marks.table import marks_of

PROPOSED = "proposed"


class Plan(NamedTuple):
    """A map with marks, the last on top."""

    title: str
    marks: list[Mark]


class View(NamedTuple):
    """A picture's name, its sentence, and what it shows."""

    tab: str
    sentence: str
    panels: list[Plan | Chart]


def tabs_in(run: History) -> tuple[str, ...]:
    """The tabs that the recorded stages have something for; the overview only of a whole run."""
    tabs = tabs_of(_recorded(run), run.info.settings)
    return tabs if run.has(TopologicalMap) else tabs[1:]


def view_of_tab(run: History, tab: str) -> View:
    """What the picture of a tab shows."""
    return View(tab, sentence_of(tab), [*(PANELS[tab](run) if tab in PANELS else _plain(run, tab))])


def _recorded(run: History) -> list[type[Record]]:
    return [record for record in RECORDS if run.has(record)]


Panels = Iterator[Plan | Chart]


def _overview(run: History) -> Panels:
    yield from _rooms(run)
    yield from _angles(run)
    yield from _cost(run)


def _simplified(run: History) -> Panels:
    yield Plan("As it was read", [*boundary.input_map(run)])
    if "simplified" in run.records:
        yield Plan("Simplified", [*boundary.simplified(run)])


def _curvature(run: History) -> Panels:
    yield _over_ground(run, "", Curvature)
    yield from _angles(run)


def _angles(run: History) -> Panels:
    if run.has(Curvature) and isinstance(run.method, Pipeline):
        yield plots.angle_chart(run, run.method.candidates.angle_deg)


def _doors(run: History) -> Panels:
    proposed, rejected = (
        [mark for mark in marks_of(run, VirtualDoors) if (mark.name == PROPOSED) == own] for own in (True, False)
    )
    convex = [mark for mark in boundary.corners(run) if mark.name == "convex"] if run.has(Corners) else []
    yield Plan("Proposed", [*boundary.ground(run), *proposed, *convex])
    if rejected:
        yield Plan("Rejected", [*boundary.ground(run), *rejected])


def _search(run: History) -> Panels:
    yield _over_ground(run, "", Generation)
    yield from _cost(run)


def _cost(run: History) -> Panels:
    if len(run.search):
        yield plots.cost_chart(run)


def _cores(run: History) -> Panels:
    yield _over_ground(run, "Eroded", ErodedSpace)
    if run.has(GrownRooms):
        yield _over_ground(run, "Grown back", GrownRooms)


def _rooms(run: History) -> Panels:
    marks = [*boundary.input_map(run), *maps.final_map(run)] if run.has(TopologicalMap) else [*boundary.ground(run)]
    # What the robot must not cross or enter lies over the rooms.
    marks.sort(key=lambda mark: not isinstance(mark, Cells))
    yield Plan("", [*marks, *(maps.edits(run) if run.has(Edits) else [])])


def _over_rooms(run: History, record: type[Record]) -> Plan:
    """The marks of a stage over the rooms, its cells below the walls."""
    below, above = ([mark for mark in marks_of(run, record) if isinstance(mark, Cells) == own] for own in (True, False))
    rooms, *others = (mark for mark in maps.final_map(run) if mark.name != "links")
    return Plan("", [*boundary.input_map(run), rooms, *below, *others, *above])


def _over_ground(run: History, title: str, *records: type[Record]) -> Plan:
    return Plan(
        title, [*boundary.ground(run), *(mark for own in records if run.has(own) for mark in marks_of(run, own))]
    )


def _plain(run: History, tab: str) -> Panels:
    """Tabs without a function of their own: the marks of their stages over the working grid."""
    yield _over_ground(run, "", *(record for record in _recorded(run) if view_of(record).tab == tab))


PANELS: dict[str, Callable[[History], Panels]] = {
    OVERVIEW: _overview,
    "Simplified": _simplified,
    "Curvature": _curvature,
    "Doors": _doors,
    "Cores": _cores,
    "Search": _search,
    "Rooms": _rooms,
    "Route": lambda run: iter([_over_rooms(run, Route)]),
    "Coverage": lambda run: iter([_over_rooms(run, Coverage)]),
}
