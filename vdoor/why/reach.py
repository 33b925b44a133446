"""How far virtual doors reach: what the settings say of each kind, whichever way doors are proposed."""

from __future__ import annotations

from dataclasses import dataclass

from vdoor.stages.doors import ProposeDoors
from vdoor.stages.wide import ProposeWideDoors


@dataclass(frozen=True)
class Reach:
    """The limits of one kind of virtual doors."""

    max_length_m: float
    detour: float | None
    """The path between the ends must be so many times longer than the door; None where it is not asked."""
    least_width_m: float = 0.0
    """Narrower gaps are no doors."""


def reach(settings: ProposeDoors | ProposeWideDoors, kind: str) -> Reach:
    """The limits of pairs, singles or extensions."""
    if isinstance(settings, ProposeDoors):
        return Reach(settings.max_length_m, settings.pair_detour if kind == "pair" else settings.single_detour)
    return {
        "pair": Reach(settings.pair_m, settings.pair_detour, settings.least_m),
        "single": Reach(settings.single_m, settings.single_detour, settings.least_m),
        "extension": Reach(settings.extension_m, None, settings.least_m),
    }[kind]


def longest_m(settings: ProposeDoors | ProposeWideDoors) -> float:
    """The longest door of any kind."""
    if isinstance(settings, ProposeDoors):
        return settings.max_length_m
    return max(settings.pair_m, settings.single_m, settings.extension_m)
