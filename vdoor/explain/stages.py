"""How each stage of a run is shown: one row per stage, read by the viewer, the terminal, the report and `vdoor why`.

A stage without a row is shown by the fields of its record.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from vdoor.baselines import CriticalLines, ErodedSpace, GrownRooms, Skeleton
from vdoor.baselines.critical_lines import FATES
from vdoor.editing.apply import VERDICTS as EDIT_VERDICTS
from vdoor.editing.apply import Edits
from vdoor.explain import coverage, routes
from vdoor.grid import OccupancyGrid
from vdoor.history import History
from vdoor.method.boundary import BoundaryPath
from vdoor.method.corners import Candidates, Corners
from vdoor.method.curvature import Curvature
from vdoor.method.doors import VERDICTS, VirtualDoors
from vdoor.method.initial_map import InitialMap
from vdoor.method.scoring.score import JUDGEMENTS, DoorScores
from vdoor.method.search.certificate import Certificate
from vdoor.method.search.generation import Generation
from vdoor.method.simplify import REASONS, SimplifiedGrid
from vdoor.navigate.cover_floor import Coverage
from vdoor.navigate.find_route import Route
from vdoor.record import Record, sizes
from vdoor.topology import TopologicalMap

Numbers = NDArray[np.integer]


@dataclass(frozen=True, kw_only=True)
class StageView:
    """Texts and elements that show one stage."""

    record: type[Record]
    name: str
    """Name of the stage's layer in the report."""
    title: str
    """Heading in the terminal."""
    summary: Callable[[History], str]
    """Result of the stage in one line."""
    tab: str
    """Tab of the viewer that shows the stage."""
    meaning: str = ""
    """What the tab shows, in words for people who have not read the paper; empty if another stage of the tab has it."""
    element: str = ""
    """What the stepper visits in this stage: samples, virtual doors, generations or doors of the final map."""
    stops: Callable[[History], Numbers] = lambda _: np.zeros(0, np.int64)
    """Sorted numbers of the elements that the stepper visits."""
    words: Mapping[str, str] = field(default_factory=dict)
    """Meaning of each code."""
    needs: str = ""
    """Table of the settings that a run must have for the stage to be shown; empty for any run."""


def percent(share: float) -> str:
    """A share as whole percent; 0 % and 100 % only if exact."""
    rounded = round(100 * share)
    if rounded == 0 < share:
        return "under 1 %"
    return "over 99 %" if rounded == 100 > 100 * share else f"{rounded} %"  # noqa: PLR2004  # percent


def _counted(codes: NDArray[np.uint8], words: Sequence[str], *, zeros: bool = False) -> str:
    """How often each word occurs among the codes; words that do not occur only with `zeros`."""
    count = np.bincount(codes.ravel(), minlength=len(words)).tolist()
    return ", ".join(f"{number} {word}" for number, word in zip(count, words, strict=True) if number or zeros)


def _input_summary(run: History) -> str:
    frame = run.input.frame
    size = f"{frame.width * frame.resolution_m:.1f} x {frame.height * frame.resolution_m:.1f} m"
    return f"{frame.width} x {frame.height} cells of {frame.resolution_m:g} m: {size}"


def _simplified_summary(run: History) -> str:
    frame, reason = run.simplified.frame, run.simplified.reason
    changed = _counted(reason[reason > 0], REASONS)
    return f"{frame.width} x {frame.height} cells of {frame.resolution_m:g} m; changed: {changed or 'nothing'}"


def _path_summary(run: History) -> str:
    path = run.path
    where = "cracks" if path.on_cracks else "obstacle cells"
    contours = f"{len(path.first)} contour{'s' * (len(path.first) != 1)}"
    return f"{len(path.cell)} samples on {where}, {contours}, {path.length_m.sum():.1f} m"


def _curvature_summary(run: History) -> str:
    sharp = int((run.curvature.angle_rad < np.radians(run.pipeline.candidates.angle_deg)).sum())
    return f"{sharp} samples below {run.pipeline.candidates.angle_deg:g} deg"


def _convex_summary(convex: NDArray[np.bool_]) -> str:
    return f"{len(convex)}: {int(convex.sum())} convex, {int((~convex).sum())} concave"


def _doors_summary(run: History) -> str:
    return _counted(run.doors.verdict, VERDICTS) or "none"


def _scores_summary(run: History) -> str:
    scores = run.scores
    judged = _counted(scores.judgement, JUDGEMENTS, zeros=True)
    sure = f"{int(scores.sure.sum())} closed in pass 2"
    return f"{judged}; {len(scores.rival_a)} pairs in conflict; {sure}; map {percent(scores.share_rough)} rough"


def _certificate_summary(run: History) -> str:
    found = run.certificate
    if found.optimal:
        return f"proven optimal: no choice costs less than {found.cost:.4f}"
    return f"not proven optimal: cost {found.cost:.4f}, bound {found.lower_bound:.4f}, gap {found.gap:.4f}"


def _narrows_summary(run: History) -> str:
    return _counted(run.critical_lines.fate, FATES) or "none"


def _initial_summary(run: History) -> str:
    idle = f", {len(run.initial.idle_door)} idle" if len(run.initial.idle_door) else ""
    return f"{len(run.initial.area_m2)} regions, {len(run.initial.door)} doors{idle}"


def _search_summary(run: History) -> str:
    first, last = run.search[0], run.search[-1]
    kept = int((~last.removed).sum())
    return f"cost {first.best_cost:.4f} to {last.best_cost:.4f}; {kept} doors kept, {int(last.removed.sum())} removed"


def _edits_summary(run: History) -> str:
    return _counted(run.edits.verdict, EDIT_VERDICTS)


def _map_summary(run: History) -> str:
    return f"{len(run.topology.area_m2)} rooms, {len(run.topology.kind)} doors, {run.topology.total_m2:.1f} m2"


STAGE_VIEWS = (
    StageView(record=OccupancyGrid, name="Input map", title="input map", summary=_input_summary, tab="Simplified"),
    StageView(
        record=SimplifiedGrid,
        name="Simplified grid",
        title="simplified grid: changed cells and reasons",
        summary=_simplified_summary,
        tab="Simplified",
        meaning=(
            "Left the map as it was read, right the grid on which all further stages work: coloured cells were "
            "changed, each colour for a reason of its own."
        ),
        words={
            "unreachable": "not reachable by the robot and not next to reachable space; set to unknown",
            "jut": "a short bump on a wall; set to free",
            "notch": "a short dent in a wall; set to occupied",
            "island": "a free-standing obstacle, small enough to be furniture; set to free",
            "thin unknown": "a thin line of unknown cells with free space around it; set to free",
            "slit": "free space too narrow for the robot; closed",
            "sill": "the floor of a doorway that no ray saw; set to free",
        },
    ),
    StageView(
        record=BoundaryPath,
        name="Boundary path",
        title="left-hand path along the boundary",
        summary=_path_summary,
        tab="Path",
        meaning=(
            "The line between floor and walls, walked with the wall on the left. All later stages measure along "
            "this line."
        ),
        element="sample",
        stops=lambda run: np.arange(len(run.path.cell)),
    ),
    StageView(
        record=Curvature,
        name="Curvature: angle along the boundary",
        title="curvature along the path",
        summary=_curvature_summary,
        tab="Curvature",
        meaning=(
            "How sharply the wall bends: at each sample of the line, the angle between the way ahead and the way "
            "back. It is 180° where the wall is straight; where it is under the threshold, there may be a corner."
        ),
        element="sample",
        stops=lambda run: np.arange(len(run.path.cell)),
    ),
    StageView(
        record=Candidates,
        name="Corner candidates",
        title="candidates: samples with an angle below the threshold",
        summary=lambda run: _convex_summary(run.candidates.convex),
        tab="Corners",
        element="sample",
        stops=lambda run: run.candidates.sample,
    ),
    StageView(
        record=Corners,
        name="Corner features",
        title="corners: the sharpest candidates in their neighbourhood",
        summary=lambda run: _convex_summary(run.corners.convex),
        tab="Corners",
        meaning=(
            "Where the wall bends: candidates (small dots), and the corners chosen among them (large dots). "
            "Convex corners stick out into the floor, as door jambs do; concave ones are those of a room."
        ),
        element="sample",
        stops=lambda run: np.sort(run.corners.sample),
    ),
    StageView(
        record=Skeleton,
        name="Skeleton",
        title="skeleton of the free space",
        summary=lambda run: f"{len(run.skeleton.cell)} points",
        tab="Narrow places",
    ),
    StageView(
        record=CriticalLines,
        name="Narrow places",
        title="narrow places of the skeleton",
        summary=_narrows_summary,
        tab="Narrow places",
        meaning=(
            "Points that are as far from the walls on either side as they can be, and where that is least: a line"
            " from wall to wall there is a door (blue), unless it is ruled out (grey)."
        ),
    ),
    StageView(
        record=ErodedSpace,
        name="Cores",
        title="cores: eroded free space",
        summary=lambda run: f"{len(run.eroded.kept)} parts, {int(run.eroded.kept.sum())} of them cores of rooms",
        tab="Cores",
        meaning=(
            "The floor that is left when walls are made much thicker: each part that is large enough (coloured) "
            "is the core of a room, and grows back until it meets the others."
        ),
    ),
    StageView(
        record=GrownRooms,
        name="Rooms grown back",
        title="rooms grown back from the cores",
        summary=lambda run: f"{run.grown.room.max()} rooms",
        tab="Cores",
    ),
    StageView(
        record=VirtualDoors,
        name="Virtual doors",
        title="virtual doors, proposed and rejected",
        summary=_doors_summary,
        tab="Doors",
        meaning=(
            "Virtual doors: straight lines over free floor, from a convex corner to another corner or wall, where"
            " a door may be. Rejected ones are drawn by reason."
        ),
        element="door",
        stops=lambda run: np.arange(len(run.doors.verdict)),
    ),
    StageView(
        record=DoorScores,
        name="Door scores",
        title="door scores: evidence for and against each proposed door",
        summary=_scores_summary,
        tab="Scores",
        meaning=(
            "How likely each proposed door is a real one, from doubtful (orange) to sure (green). Thin lines are "
            "left out of the search."
        ),
        element="door",
        stops=lambda run: run.scores.door,
    ),
    StageView(
        record=InitialMap,
        name="Initial map",
        title="initial map: regions between the doors",
        summary=_initial_summary,
        tab="Initial map",
        meaning=(
            "All doors that are left cut the floor into regions, each in a colour; cells that a door covers stay "
            "white. The graph joins each region with the doors on its border. The search then decides which to keep."
        ),
        element="door",
        stops=lambda run: np.sort(run.initial.door),
    ),
    StageView(
        record=Generation,
        name="Search: doors kept and removed",
        title="search: which doors to remove",
        summary=_search_summary,
        tab="Search",
        meaning=(
            "Which doors are kept: the search tries many choices at a time, a generation. The lower the cost of a "
            "choice, the better; one at the lower bound, where that is known, is proven to be the best."
        ),
        element="generation",
        stops=lambda run: np.arange(len(run.search)),
        needs="search",
    ),
    StageView(
        record=Certificate,
        name="Certificate",
        title="certificate: optimality of the search result",
        summary=_certificate_summary,
        tab="Search",
    ),
    StageView(
        record=Edits,
        name="Edits",
        title="edits and their results",
        summary=_edits_summary,
        tab="Rooms",
    ),
    StageView(
        record=TopologicalMap,
        name="Rooms and doors",
        title="rooms and doors",
        summary=_map_summary,
        tab="Rooms",
        meaning="The result: rooms in colour, the doors between them, and the graph of rooms and doors.",
        element="final",
        stops=lambda run: np.arange(len(run.topology.kind)),
    ),
    StageView(
        record=Route,
        name="Route",
        title="route on the final map",
        summary=lambda run: routes.described(run.route),
        tab="Route",
        meaning="The robot's path over the rooms, or what is in its way.",
    ),
    StageView(
        record=Coverage,
        name="Coverage",
        title="path that covers the floor",
        summary=lambda run: coverage.described(run.coverage),
        tab="Coverage",
        meaning="The path whose tool sweeps the floor, room after room.",
    ),
)
"""All stages that have a row, in the order in which they are shown."""


def view_of(record: type[Record]) -> StageView:
    """The row of a stage, or a default made from its topic and the sizes of its record."""
    own = next((view for view in STAGE_VIEWS if view.record is record), None)
    if own is not None:
        return own
    name = record.topic.replace("_", " ").capitalize()
    return StageView(
        record=record, name=name, title=name.lower(), summary=lambda run: sizes(run.get(record)), tab=name, meaning=name
    )


OVERVIEW = "Overview"
OVERVIEW_MEANING = (
    "The rooms and doors that were found, and two curves on the way there: how sharply the wall bends, along the wall, "
    "and the cost of the chosen doors while the search went on."
)


def tabs_of(records: Iterable[type[Record]], settings: Mapping[str, Any]) -> tuple[str, ...]:
    """Tabs that a run with these records and settings has content for; without settings, with any."""
    shown = [
        view for view in map(view_of, in_order(records)) if not (view.needs and settings) or view.needs in settings
    ]
    return tuple(dict.fromkeys([OVERVIEW, *(view.tab for view in shown)]))


def in_order(records: Iterable[type[Record]]) -> list[type[Record]]:
    """The records in the order of the rows of `STAGE_VIEWS`; those without a row come last."""
    given = list(records)
    own = [view.record for view in STAGE_VIEWS if view.record in given]
    return [*own, *(record for record in given if record not in own)]


def sentence_of(tab: str) -> str:
    """What a tab shows; for a tab without a row, its name."""
    if tab == OVERVIEW:
        return OVERVIEW_MEANING
    return next((view.meaning for view in STAGE_VIEWS if view.tab == tab and view.meaning), tab)
