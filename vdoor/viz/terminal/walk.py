"""Where a walk through a recording stands, and where each key takes it: no screen, no keyboard."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from vdoor.explain.stages import view_of
from vdoor.history import SEARCH, History
from vdoor.history.records import RECORD_OF
from vdoor.method.doors import PROPOSED

Ints = NDArray[np.int64]

NAMES = {"sample": "sample", "door": "door", "generation": "generation", "final": "door", "": ""}
FOUND_IN = {
    "candidate": ("candidates", "sample"),
    "corner": ("corners", "sample"),
    "rejected door": ("doors", "door"),
}
LEAP = 10
MOST_ZOOM = 6
MOST_DIGITS = 9


@dataclass(frozen=True)
class Walk:
    """A place in a recording."""

    stage: str
    sample: int = 0
    door: int = 0
    generation: int = 0
    final: int = 0
    """Row of the final map's doors."""
    zoom: int | None = None
    """Pixels to a cell around the walker; 0 shows the whole map, None what suits the stage."""
    typing: str | None = None
    """What has been typed of a number to jump to: g or s, then digits."""
    said: str = ""
    """What the last key could not do."""
    help: bool = False
    done: bool = False

    @property
    def element(self) -> str:
        """What is walked along here."""
        return view_of(RECORD_OF[self.stage]).element

    @property
    def at(self) -> int:
        """Its number."""
        return int(getattr(self, self.element)) if self.element else 0

    @property
    def pixels(self) -> int:
        """Pixels to a cell around the walker, 0 for the whole map: samples are looked at from nearby."""
        return self.zoom if self.zoom is not None else 2 * (self.element == "sample")

    def to(self, element: str, number: int) -> Walk:
        """The same place with another sample, door or generation."""
        moved: dict[str, Any] = {element: int(number)}
        return replace(self, **moved)


def stops(run: History, stage: str) -> Ints:
    """Numbers that the walker stops at in a stage, sorted."""
    return view_of(RECORD_OF[stage]).stops(run).astype(np.int64)


def entered(run: History, walk: Walk, stage: str) -> Walk:
    """The walk in another stage, at the stop there that is nearest to where it stood."""
    walk = replace(walk, stage=stage)
    if stage == SEARCH and walk.generation == 0:
        return walk.to("generation", len(run.search) - 1)
    here = stops(run, stage)
    return walk.to(walk.element, here[np.argmin(np.abs(here - walk.at))]) if len(here) else walk


def pressed(run: History, walk: Walk, key: str) -> Walk:
    """Where a key leads: a letter, or a key's name in prompt_toolkit, such as left or c-m for Enter."""
    if walk.typing is not None:
        return _typed(run, walk, key)
    if key == "?" or walk.help:
        return replace(walk, help=not walk.help, said="")
    walk = replace(walk, said="")
    return KEYS[key](run, walk) if key in KEYS else walk


def _stage_by(run: History, walk: Walk, by: int) -> Walk:
    at = run.stages.index(walk.stage) + by
    if 0 <= at < len(run.stages):
        return entered(run, walk, run.stages[at])
    return replace(walk, said=f"this is the {'last' if by > 0 else 'first'} stage recorded")


def _go(run: History, walk: Walk, by: int) -> Walk:
    """So many stops on, or as far as there are any."""
    here = stops(run, walk.stage)
    if not len(here):
        return replace(walk, said=f"nothing to walk along in {walk.stage}; n and p lead to other stages")
    at = int(np.searchsorted(here, walk.at)) + by
    held = min(max(at, 0), len(here) - 1)
    said = "" if held == at or abs(by) > 1 else f"this is the {'last' if by > 0 else 'first'} one"
    return replace(walk.to(walk.element, here[held]), said=said)


def _to_end(run: History, walk: Walk, end: int) -> Walk:
    here = stops(run, walk.stage)
    return walk.to(walk.element, here[end]) if len(here) else walk


def _find(run: History, walk: Walk, *, what: str, forward: bool) -> Walk:
    """The next candidate, corner or rejected door, in the stage that shows it."""
    stage, element = FOUND_IN[what]
    if stage not in run.stages:
        return replace(walk, said=f"the recording ends before {stage}")
    rejected = run.doors.verdict != PROPOSED if stage == "doors" else None
    there = stops(run, stage) if rejected is None else np.flatnonzero(rejected)
    at = getattr(walk, element)
    ahead = there[there > at] if forward else there[there < at][::-1]
    if walk.element != element:
        ahead = there[there >= at] if forward else there[there <= at][::-1]
    if not len(ahead):
        return replace(walk, said=f"no {what} {'after' if forward else 'before'} {element} {at}")
    stays = what == "candidate" and walk.stage in ("path", "curvature", "candidates")
    return replace(walk, stage=walk.stage if stays else stage).to(element, ahead[0])


def _typed(run: History, walk: Walk, key: str) -> Walk:
    """A number being typed; Enter jumps, Escape does not."""
    assert walk.typing is not None
    if key.isdigit() and key.isascii():
        if len(walk.typing) > MOST_DIGITS:
            return walk
        return replace(walk, typing=walk.typing + key)
    if key in ("c-h", "delete") and len(walk.typing) > 1:
        return replace(walk, typing=walk.typing[:-1])
    if key != "c-m":
        return replace(walk, typing=None) if key in ("escape", "q") else walk
    digits, what, walk = walk.typing[1:], walk.typing[0], replace(walk, typing=None)
    if not digits:
        return walk
    return _to_step(run, walk, int(digits)) if what == "s" else _to_number(run, walk, int(digits))


def _to_step(run: History, walk: Walk, step: int) -> Walk:
    if not 0 <= step <= run.last_step:
        return replace(walk, said=f"steps go from 0 to {run.last_step}")
    topic, index = run.stage_of(step)
    return replace(walk, stage=topic, generation=index) if topic == SEARCH else entered(run, walk, topic)


def _to_number(run: History, walk: Walk, number: int) -> Walk:
    here = stops(run, walk.stage)
    if number in here:
        return walk.to(walk.element, number)
    if walk.element == "sample" and number < len(run.path.cell):
        return replace(walk, stage="curvature" if "curvature" in run.stages else "path", sample=number)
    span = f"from {here[0]} to {here[-1]}" if len(here) else "in other stages only"
    return replace(walk, said=f"{NAMES[walk.element]} {number} is not here; there are some {span}")


def _zoomed(walk: Walk, by: int) -> Walk:
    return replace(walk, zoom=min(max(walk.pixels + by, 0), MOST_ZOOM))


Move = Callable[[History, Walk], Walk]

HELP = (
    ("n, Tab / p", "next / previous stage"),
    ("right / left", "next / previous sample, door or generation"),
    ("down / up", f"{LEAP} of them"),
    ("Home / End", "the first / the last one"),
    ("c / C", "next / previous candidate"),
    ("k / K", "next / previous corner"),
    ("r / R", "next / previous rejected door"),
    ("g 12 Enter", "jump to a sample, door or generation"),
    ("s 12 Enter", "jump to a step"),
    ("+ / -", "closer / further; the whole map at the end"),
    ("q", "quit"),
)
HELP_LINE = "n/p stage  arrows walk  c candidate  k corner  r rejected door  g/s jump  +/- zoom  ? help  q quit"

KEYS: dict[str, Move] = {
    "q": lambda _, walk: replace(walk, done=True),
    "c-c": lambda _, walk: replace(walk, done=True),
    "n": lambda run, walk: _stage_by(run, walk, 1),
    "c-i": lambda run, walk: _stage_by(run, walk, 1),
    "p": lambda run, walk: _stage_by(run, walk, -1),
    "s-tab": lambda run, walk: _stage_by(run, walk, -1),
    "right": lambda run, walk: _go(run, walk, 1),
    "left": lambda run, walk: _go(run, walk, -1),
    "down": lambda run, walk: _go(run, walk, LEAP),
    "up": lambda run, walk: _go(run, walk, -LEAP),
    "home": lambda run, walk: _to_end(run, walk, 0),
    "end": lambda run, walk: _to_end(run, walk, -1),
    "c": lambda run, walk: _find(run, walk, what="candidate", forward=True),
    "C": lambda run, walk: _find(run, walk, what="candidate", forward=False),
    "k": lambda run, walk: _find(run, walk, what="corner", forward=True),
    "K": lambda run, walk: _find(run, walk, what="corner", forward=False),
    "r": lambda run, walk: _find(run, walk, what="rejected door", forward=True),
    "R": lambda run, walk: _find(run, walk, what="rejected door", forward=False),
    "g": lambda _, walk: replace(walk, typing="g"),
    "s": lambda _, walk: replace(walk, typing="s"),
    "+": lambda _, walk: _zoomed(walk, 1),
    "=": lambda _, walk: _zoomed(walk, 1),
    "-": lambda _, walk: _zoomed(walk, -1),
}
