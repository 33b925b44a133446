"""One run of the paper's method with what every stage found, counted."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TypeVar

import numpy as np

from vdoor.grid import FREE, OccupancyGrid
from vdoor.method.corners import Candidates, Corners
from vdoor.method.doors import PROPOSED, VirtualDoors
from vdoor.method.initial_map import InitialMap
from vdoor.method.search.generation import Generation
from vdoor.method.simplify import REASONS, SimplifiedGrid
from vdoor.pipeline import PRESETS, Pipeline
from vdoor.raster.contours import follow
from vdoor.record import Record
from vdoor.topology import KINDS, TopologicalMap

R = TypeVar("R", bound=Record)

SAME_COST = 1e-9


@dataclass(frozen=True, kw_only=True)
class Counts:
    """What the stages of one run found."""

    unreachable_cells: int
    jut_cells: int
    notch_cells: int
    islands: int
    concave_turns: int
    convex_turns: int
    """Turns of the simplified map's boundary, its true corners; concave less convex is 4 - 4 x islands."""
    concave_candidates: int
    convex_candidates: int
    concave_corners: int
    convex_corners: int
    virtual_doors: int
    """Proposed ones,"""
    pairs: int
    """those between two convex corners,"""
    singles: int
    """and those between one and the closest boundary."""
    nodes: int
    edges: int
    """Of the initial map."""
    edges_of_many: int
    """Those that border more than two nodes."""
    best_generation: int
    """The first that had the best choice of the whole search."""
    evaluations: int
    """Choices evaluated up to that one."""
    final_nodes: int
    final_edges: int


@dataclass(frozen=True, eq=False)
class Walk:
    """The records of one run, as an `Emit` collects them."""

    records: dict[str, Record] = field(default_factory=dict)
    """By topic, but for the search."""
    generations: list[Generation] = field(default_factory=list)

    def __call__(self, record: R, /) -> R:
        """Keep a record and return it."""
        if isinstance(record, Generation):
            self.generations.append(record)
        else:
            self.records[record.topic] = record
        return record

    def get(self, kind: type[R]) -> R:
        """The record of one stage."""
        record = self.records[kind.topic]
        assert isinstance(record, kind)
        return record

    @property
    def counts(self) -> Counts:
        """What the stages found."""
        reason = np.bincount(self.get(SimplifiedGrid).reason.ravel(), minlength=len(REASONS)).tolist()
        candidates, corners = self.get(Candidates).convex, self.get(Corners).convex
        doors, initial, final = self.get(VirtualDoors), self.get(InitialMap), self.get(TopologicalMap)
        kind = np.bincount(doors.kind[doors.verdict == PROPOSED], minlength=len(KINDS)).tolist()
        last = self.generations[-1].best_cost
        best = next(found for found in self.generations if found.best_cost <= last + SAME_COST)
        contours = follow(self.get(SimplifiedGrid).cells == FREE)
        return Counts(
            unreachable_cells=reason[REASONS.index("unreachable")],
            jut_cells=reason[REASONS.index("jut")],
            notch_cells=reason[REASONS.index("notch")],
            islands=int((~contours.outer).sum()),
            concave_turns=int((contours.turn < 0).sum()),
            convex_turns=int((contours.turn > 0).sum()),
            concave_candidates=int((~candidates).sum()),
            convex_candidates=int(candidates.sum()),
            concave_corners=int((~corners).sum()),
            convex_corners=int(corners.sum()),
            virtual_doors=sum(kind),
            pairs=kind[KINDS.index("pair")],
            singles=kind[KINDS.index("single")],
            nodes=len(initial.area_m2),
            edges=len(initial.door),
            edges_of_many=int((np.bincount(initial.border_edge) > 2).sum()),  # noqa: PLR2004  # a door has two sides
            best_generation=best.number,
            evaluations=best.evaluations,
            final_nodes=len(final.area_m2),
            final_edges=len(final.kind),
        )


def walked(grid: OccupancyGrid, pipeline: Pipeline | None = None, *, seed: int = 0) -> Walk:
    """A run on `grid` of the paper's preset, or of another pipeline of the method."""
    walk = Walk()
    method = pipeline or paper()
    method(grid, np.random.default_rng(seed), walk)
    return walk


def paper() -> Pipeline:
    """The paper's preset."""
    preset = PRESETS["paper"]
    assert isinstance(preset, Pipeline)
    return preset
