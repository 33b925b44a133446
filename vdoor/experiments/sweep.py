"""Sweeps: the effect of one setting on the results, on the same maps and with all other settings fixed."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import Any, NamedTuple, TypeVar

import numpy as np

from vdoor.engines import Over
from vdoor.errors import VdoorError
from vdoor.evaluate import Evaluation, Tally, evaluate, marked_doors, match_doors, pooled
from vdoor.evaluate.door_places import TOLERANCES_M
from vdoor.experiments.cases import Trial
from vdoor.experiments.measure import measured
from vdoor.experiments.steps import Setting, Step
from vdoor.method.corners import Corners
from vdoor.method.doors import PROPOSED, VirtualDoors
from vdoor.method.search.generation import Generation
from vdoor.pipeline import AnyPipeline
from vdoor.record import Record
from vdoor.topology import TopologicalMap

R = TypeVar("R", bound=Record)

TOTALS = (
    "doors_true",
    "doors_found",
    "doors_hit",
    "doors_false",
    "virtual",
    "matched",
    "rooms_true",
    "rooms_found",
    "corners",
    "proposed",
)
"""Figures of a map that are summed over the maps.

Found, hit and false doors are contacts between rooms, as measured by `vdoor evaluate`; `virtual` is the number of doors
in the result's list, and `matched` the number of those at the place of a true door, as counted in Table I.
"""


@dataclass(frozen=True, kw_only=True)
class Point:
    """Results for one value of a setting."""

    setting: Setting
    value: Any
    own: bool
    figures: dict[str, float]
    """Means over the maps that have them, `pooled_` figures over all doors, and `accuracy`: matched / virtual."""
    totals: dict[str, int]
    maps: dict[str, dict[str, float]]
    """Figures of each map."""
    failed: dict[str, str] = field(default_factory=dict)
    """Errors by map; a failed map counts as one without found doors."""


class Spread(NamedTuple):
    """Mean and spread of a figure over maps."""

    mean: float
    deviation: float
    """Standard deviation; 0 for a single map."""


class Seen(NamedTuple):
    """Outcome of a run on one map."""

    evaluation: Evaluation
    figures: dict[str, float]
    error: str = ""


def swept(steps: Sequence[Step], trials: Sequence[Trial], *, over: Over = map) -> Iterator[Point]:
    """One point per step; equal runs are only done once."""
    known: dict[tuple[AnyPipeline, int], list[Seen]] = {}
    for step in steps:
        run = step.pipeline, step.seed
        if run not in known:
            known[run] = list(over(partial(seen, pipeline=step.pipeline, seed=step.seed), trials))
        yield point(step, known[run])


def point(step: Step, found: Sequence[Seen]) -> Point:
    """Results of one step over all maps."""
    evaluations = [one.evaluation for one in found]
    maps = {one.evaluation.name: one.figures for one in found}
    totals = {
        name: int(sum(figures.get(name, 0) for figures in maps.values()))
        for name in TOTALS
        if any(name in figures for figures in maps.values())
    }
    own_names = dict.fromkeys(name for figures in maps.values() for name in figures)
    figures = {name: spread(maps, name).mean for name in own_names} | pooled(evaluations)
    if totals["virtual"]:
        figures["accuracy"] = totals["matched"] / totals["virtual"]
    return Point(
        setting=step.setting,
        value=step.value,
        own=step.own,
        figures=figures,
        totals=totals,
        maps=maps,
        failed={one.evaluation.name: one.error for one in found if one.error},
    )


def spread(maps: dict[str, dict[str, float]], name: str) -> Spread:
    """Mean and standard deviation of a figure over the maps that have it; nan if none has."""
    values = [figures[name] for figures in maps.values() if name in figures]
    return Spread(float(np.mean(values)), float(np.std(values))) if values else Spread(np.nan, np.nan)


def by_setting(points: Sequence[Point]) -> dict[Setting, list[Point]]:
    """Points of each sweep, by setting."""
    return {setting: list(own) for setting, own in itertools.groupby(points, key=lambda point: point.setting)}


def seen(trial: Trial, pipeline: AnyPipeline, seed: int) -> Seen:
    """One run on one map, evaluated; a failed run counts as one that found nothing."""
    kept: dict[type[Record], Record] = {}

    def keep(record: R, /) -> R:
        kept[type(record)] = record
        return record

    try:
        evaluation = measured(trial, pipeline, seed=seed, emit=keep).evaluation
    except VdoorError as error:
        nothing = evaluate(trial.division, trial.reference)
        return Seen(nothing, doors_counted(nothing, Tally()), str(error))
    return Seen(evaluation, doors_counted(evaluation, listed(kept, trial)) | stages_counted(kept))


def doors_counted(evaluation: Evaluation, listed: Tally) -> dict[str, float]:
    """Figures of an evaluation, and numbers of doors by outcome; `listed` counts the doors in the result's list."""
    tally = evaluation.matches[TOLERANCES_M[0]].tally
    figures = {"rooms_found": int(evaluation.division.rooms.max(initial=0))} | evaluation.figures()
    figures |= {
        "doors_hit": tally.hits,
        "doors_false": tally.false,
        "virtual": listed.hits + listed.false,
        "matched": listed.hits,
    }
    pairs = {"rooms_excess": ("rooms_found", "rooms_true"), "doors_excess": ("doors_found", "doors_true")}
    return figures | {name: figures[a] - figures[b] for name, (a, b) in pairs.items() if b in figures}


def listed(kept: dict[type[Record], Record], trial: Trial) -> Tally:
    """Doors in the result's list matched with the true ones, as counted in Table I."""
    topology = kept[TopologicalMap]
    assert isinstance(topology, TopologicalMap)
    frame, reference = topology.frame, trial.reference
    # A door that borders more than two rooms has several rows.
    ends_m = np.unique(np.concatenate([topology.start_m, topology.end_m], axis=1).round(9), axis=0)
    virtual = marked_doors(frame.cell_from_world(ends_m.reshape(-1, 2)), frame.resolution_m)
    return match_doors(reference.doors, virtual, TOLERANCES_M[0], unsure=reference.unsure).tally


def stages_counted(kept: dict[type[Record], Record]) -> dict[str, float]:
    """Numbers of corners and proposed doors, and the cost, from those of these stages that the method has."""
    found: dict[str, float] = {}
    for record in kept.values():
        match record:
            case Corners():
                found["corners"] = len(record.convex)
            case VirtualDoors():
                found["proposed"] = int((record.verdict == PROPOSED).sum())
            case Generation():
                found["cost"] = record.best_cost
    return found
