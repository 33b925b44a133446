"""Why there are the doors that there are: the score of each, and the life of virtual doors, stage by stage."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from vdoor.errors import SettingError
from vdoor.explain.doors import door_fate
from vdoor.explain.scores import Reason, score_fate
from vdoor.explain.stages import percent
from vdoor.explain.text import door_lines
from vdoor.history import History
from vdoor.history.provenance import Provenance
from vdoor.method.corners import Corners
from vdoor.method.doors import PROPOSED, VirtualDoors
from vdoor.method.initial_map import InitialMap
from vdoor.pipeline import Pipeline, recorded
from vdoor.topology import TopologicalMap

MOST_LIVES = 400
"""Maximum number of virtual doors whose lives are told, since each takes some milliseconds."""


class Tip(NamedTuple):
    """The virtual door that a door of the final map was, and the lines on its score."""

    candidate: int
    lines: tuple[str, ...]


def door_tips(topology: TopologicalMap, provenance: Provenance | None) -> dict[int, Tip]:
    """Tips by the ids of doors; none for doors that were not virtual doors, and for runs that are not known."""
    run = _history(topology, provenance)
    if run is None or not run.has(InitialMap):
        return {}
    edges = np.where(topology.edge < len(run.initial.door), topology.edge, -1).tolist()
    candidates = {row + 1: int(run.initial.door[edge]) for row, edge in enumerate(edges) if edge >= 0}
    return {door: Tip(candidate, tuple(_score_lines(run, candidate))) for door, candidate in candidates.items()}


def lives_of(topology: TopologicalMap, provenance: Provenance | None) -> dict[int, list[str]]:
    """The lives of virtual doors by their numbers: the decision of each stage, as `vdoor why` tells it.

    If there are too many, those of the doors that went furthest are told.
    """
    run = _history(topology, provenance)
    if run is None or not run.has(Corners):
        return {}
    return {door: _life(run, door) for door in _furthest_first(run)[:MOST_LIVES].tolist()}


def _history(topology: TopologicalMap, provenance: Provenance | None) -> History | None:
    """The run of the method with its virtual doors; None if they are not known or its settings are invalid."""
    if provenance is None or provenance.info is None or not provenance.run.has(VirtualDoors):
        return None
    try:
        method = recorded(provenance.info)
    except SettingError:
        return None
    if not isinstance(method, Pipeline):
        return None
    run = provenance.run
    records = {**run.records, topology.topic: topology}
    steps = {**run.steps, topology.topic: 0}
    file = Path(provenance.name)
    return History(records=records, steps=steps, search=run.search, file=file, info=provenance.info, method=method)


def _furthest_first(run: History) -> NDArray[np.intp]:
    """The numbers of the virtual doors: those of the final map, other edges, other proposed ones, rejected ones."""
    reached = (run.doors.verdict == PROPOSED).astype(np.int64)
    if run.has(InitialMap):
        reached[run.initial.door] = 2
        if len(run.search):
            reached[run.initial.door[~run.search[-1].removed]] = 3
    return np.argsort(-reached, kind="stable")


def _life(run: History, door: int) -> list[str]:
    fate = door_fate(run, door)
    head, *lines = door_lines(fate)
    del head  # it says how far the door is from a place that was asked for
    corners = " and ".join(map(str, fate.corners))
    return [f"{fate.kind}, corner{'s' * (len(fate.corners) > 1)} {corners}", *(line.strip() for line in lines)]


def _score_lines(run: History, candidate: int) -> Iterator[str]:
    score = score_fate(run, candidate)
    if score is None:
        return
    yield f"score {score.log_odds:+.1f}: {percent(1 / (1 + math.exp(-score.log_odds)))} likely"
    for word, reasons in (("for", score.reasons_for), ("against", score.reasons_against)):
        if reasons:
            yield f"{word}: {', '.join(map(_reason, reasons))}"


def _reason(reason: Reason) -> str:
    return f"{reason.feature} {reason.value:.2f} ({reason.log_odds:+.1f})"
