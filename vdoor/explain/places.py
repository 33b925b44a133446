"""Where an element of a run lies that is given by its number."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from vdoor.editing.lookup import find_door
from vdoor.errors import SettingError
from vdoor.explain.distances import Point
from vdoor.history import History


def place_of(run: History, kind: str, word: str) -> Point:
    """The middle of a door, edge or candidate (a virtual door), x, y in the map frame.

    Raises `SettingError` for a number that the run does not have, and `RecordingError` if the stage is not recorded.
    """
    return PLACES[kind](run, word)


def _door(run: History, word: str) -> Point:
    return find_door(run.topology, word, what="--door").place_m


def _edge(run: History, word: str) -> Point:
    return _middle(run, int(run.initial.door[_row(word, run.initial.door, "--edge")]))


def _candidate(run: History, word: str) -> Point:
    return _middle(run, _row(word, run.doors.kind, "--candidate"))


PLACES: dict[str, Callable[[History, str], Point]] = {"door": _door, "edge": _edge, "candidate": _candidate}
"""What is given by a number, and the function that finds it."""


def _row(word: str, rows: np.ndarray[Any, Any], what: str) -> int:
    if not 0 <= int(word) < len(rows):
        raise SettingError(f"{what}: wanted 0 to {len(rows) - 1}, found {word}")
    return int(word)


def _middle(run: History, door: int) -> Point:
    ends_m = run.doors.frame.world_from_cell(np.stack([run.doors.start[door], run.doors.end[door]]))
    x_m, y_m = ends_m.mean(axis=0).tolist()
    return x_m, y_m
