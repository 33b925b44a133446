"""One run of the paper's method walked through, with what every stage found counted; figure 5 beside our counts."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from vdoor.grid import FREE, OccupancyGrid
from vdoor.history.records import RunRecords
from vdoor.method.corners import Candidates, Corners
from vdoor.method.doors import PROPOSED, VirtualDoors
from vdoor.method.initial_map import InitialMap
from vdoor.method.simplify import REASONS, SimplifiedGrid
from vdoor.pipeline import PRESETS, Pipeline
from vdoor.raster.contours import follow
from vdoor.synth import PRESETS as SYNTHETIC
from vdoor.synth import Apartment, SyntheticMap, synthesize
from vdoor.topology import KINDS, TopologicalMap

Progress = Callable[[str], None]
"""Takes a line about how far a long computation is."""

SAME_COST = 1e-9
"""Costs that differ by less are equal."""
PRINTED_EDGES, PRINTED_GENERATION = 16, 9
"""Edges of the paper's initial map, and the generation in which its search has the optimum."""


@dataclass(frozen=True, kw_only=True)
class StageCounts:
    """How much each stage of a run found."""

    unreachable_cells: int
    jut_cells: int
    notch_cells: int
    islands: int
    concave_turns: int
    """Right-angled turns of the simplified map's boundary; concave less convex is 4 - 4 x islands."""
    convex_turns: int
    concave_candidates: int
    convex_candidates: int
    concave_corners: int
    convex_corners: int
    virtual_doors: int
    """All that were proposed: pairs and singles."""
    pairs: int
    """Virtual doors between two convex corners."""
    singles: int
    """Virtual doors between one convex corner and the closest boundary."""
    nodes: int
    """Nodes of the initial map."""
    edges: int
    """Edges of the initial map."""
    edges_of_many: int
    """Edges of the initial map that border more than two nodes."""
    best_generation: int
    """The first generation with the least cost of the whole search."""
    evaluations: int
    """Strings evaluated up to that generation."""
    final_nodes: int
    final_edges: int


class MethodRun(RunRecords):
    """The records of one run, collected by passing this to the method as its `Emit`."""

    @property
    def counts(self) -> StageCounts:
        """How much each stage found."""
        simplified, doors = self.get(SimplifiedGrid), self.get(VirtualDoors)
        initial, final = self.get(InitialMap), self.get(TopologicalMap)
        candidates, corners = self.get(Candidates).convex, self.get(Corners).convex
        reasons = _number_of_each(simplified.reason, REASONS)
        proposed = _number_of_each(doors.kind[doors.verdict == PROPOSED], KINDS)
        contours = follow(simplified.cells == FREE)
        best = self.search[first_at_best(self.search.numbers("best_cost").tolist())]
        return StageCounts(
            unreachable_cells=reasons["unreachable"],
            jut_cells=reasons["jut"],
            notch_cells=reasons["notch"],
            islands=int((~contours.outer).sum()),
            concave_turns=int((contours.turn < 0).sum()),
            convex_turns=int((contours.turn > 0).sum()),
            concave_candidates=int((~candidates).sum()),
            convex_candidates=int(candidates.sum()),
            concave_corners=int((~corners).sum()),
            convex_corners=int(corners.sum()),
            virtual_doors=sum(proposed.values()),
            pairs=proposed["pair"],
            singles=proposed["single"],
            nodes=len(initial.area_m2),
            edges=len(initial.door),
            edges_of_many=int((np.bincount(initial.border_edge) > 2).sum()),  # noqa: PLR2004  # a door has two sides
            best_generation=best.number,
            evaluations=best.evaluations,
            final_nodes=len(final.area_m2),
            final_edges=len(final.kind),
        )


def _number_of_each(codes: NDArray[Any], names: Sequence[str]) -> dict[str, int]:
    """How often each code occurs, by the name that it stands for."""
    return dict(zip(names, np.bincount(codes.ravel(), minlength=len(names)).tolist(), strict=True))


def first_at_best(costs: Sequence[float]) -> int:
    """The first generation whose best cost is that of the last one."""
    return next(number for number, cost in enumerate(costs) if cost <= costs[-1] + SAME_COST)


def paper_pipeline() -> Pipeline:
    """The method as the paper prints it: preset `paper`."""
    preset = PRESETS["paper"]
    assert isinstance(preset, Pipeline)
    return preset


def run_method(grid: OccupancyGrid, pipeline: Pipeline | None = None, *, seed: int = 0) -> MethodRun:
    """A run on `grid` of preset `paper`, or of the same method with other settings."""
    run = MethodRun()
    (pipeline or paper_pipeline())(grid, np.random.default_rng(seed), run)
    return run


def no_progress(_: str) -> None:
    """Report nothing."""


def paper_apartment(seed: int, **settings: Any) -> SyntheticMap:
    """An apartment of the paper's kind with some settings changed, drawn at 20 cm from `seed`."""
    kind: Apartment = dataclasses.replace(SYNTHETIC["paper"], **settings)
    return synthesize(kind, np.random.default_rng(seed))


MAP_SEED = 0
MAP_SETTINGS = {"rooms": 4, "rooms_spread": 0, "furniture": True, "area_m2": 90.0, "free_pieces_per_m2": 0.02}
"""Chosen so that the number of corners comes near the printed one."""
CANDIDATES_NOTE = (
    "Cannot be met with the corners: at a convex corner only its own cell bends, at a concave one up to four do "
    "(Fig. 3c). That makes {convex_each:.1f} and {concave_each:.1f} a corner here, against 2.3 and 3.5 in print; how "
    "the boundary is sampled, from which it follows, is not printed."
)
CORNERS_NOTE = (
    "Cannot both be all corners: on a connected right-angled map concave less convex is 4 - 4 x islands, at most 4. 43 "
    "less 35 says that convex ones were missed or concave ones found twice. Here the boundary turns {concave_turns} "
    "times concave and {convex_turns} times convex, around {islands} islands."
)
NODES_NOTE = (
    "Cannot be met by doors with two sides each: nodes are 1 + doors + crossings - islands tied in, at most 17 of 16 "
    "doors that do not cross. It takes doors that cross, or a map in two parts."
)
GENERATION_NOTE = "By chance: another seed gives another generation (section III below)."
PRINTED_COUNTS = (
    ("concave candidates", "concave_candidates", 150, CANDIDATES_NOTE),
    ("convex candidates", "convex_candidates", 82, CANDIDATES_NOTE),
    ("concave corners", "concave_corners", 43, CORNERS_NOTE),
    ("convex corners", "convex_corners", 35, CORNERS_NOTE),
    ("virtual doors", "virtual_doors", PRINTED_EDGES, ""),
    ("nodes of the initial map", "nodes", 18, NODES_NOTE),
    ("edges of the initial map", "edges", PRINTED_EDGES, ""),
    ("generation of the optimum", "best_generation", PRINTED_GENERATION, GENERATION_NOTE),
    ("nodes of the final map", "final_nodes", 4, ""),
    ("edges of the final map", "final_edges", 3, ""),
)
"""What is counted, which of `StageCounts` it is, the printed count, and why ours differs."""


@dataclass(frozen=True, kw_only=True)
class ComparedCount:
    """A printed count, ours, and why the two differ."""

    what: str
    printed: int
    ours: int
    note: str = ""


@dataclass(frozen=True, kw_only=True)
class WalkThrough:
    """Figure 5 in numbers."""

    counts: StageCounts
    lines: tuple[ComparedCount, ...]


def figure_5_map() -> OccupancyGrid:
    """The stand-in for the figure's map: four rooms and three doors, furnished."""
    return paper_apartment(MAP_SEED, **MAP_SETTINGS).grid


def figure_5_run(*, seed: int = 0) -> MethodRun:
    """The paper's method on that map; the search draws from `seed`."""
    return run_method(figure_5_map(), seed=seed)


def walk_through(run: MethodRun) -> WalkThrough:
    """The counts of a run on the figure's map beside the printed ones."""
    counts = run.counts
    ours = dataclasses.asdict(counts)
    per_corner = {
        "convex_each": counts.convex_candidates / counts.convex_corners,
        "concave_each": counts.concave_candidates / counts.concave_corners,
    }
    lines = (
        ComparedCount(what=what, printed=printed, ours=ours[name], note=note.format(**per_corner, **ours))
        for what, name, printed, note in PRINTED_COUNTS
    )
    return WalkThrough(counts=counts, lines=tuple(lines))
