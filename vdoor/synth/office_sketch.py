"""A floor of an office while it is drawn."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from vdoor.synth.canvas import Axis, Rect, fine
from vdoor.synth.layout import Gap
from vdoor.synth.settings import Office


@dataclass
class Sketch:
    """A floor while it is drawn."""

    settings: Office
    rng: np.random.Generator
    wall_m: float
    door_m: float
    jamb_m: tuple[float, float]
    """Wall left beside doors near a corner, least and most."""
    corridors: list[Rect] = field(default_factory=list)
    rooms: list[Rect] = field(default_factory=list)
    halls: list[Rect] = field(default_factory=list)
    """Rooms with wide doors."""
    solids: list[Rect] = field(default_factory=list)
    pits: list[Rect] = field(default_factory=list)
    gaps: list[Gap] = field(default_factory=list)

    def between(self, name: str) -> float:
        """Draw one of the settings that come as `_min_m` and `_max_m`, on the fine raster."""
        return fine(self.rng.uniform(getattr(self.settings, f"{name}_min_m"), getattr(self.settings, f"{name}_max_m")))

    def open_mouth(self, rect: Rect, axis: Axis) -> None:
        """Let a corridor end in an opening of all its width, unless it does so there; `axis` is the corridor's."""
        width_m = rect.sides[1 - axis]
        if any(gap.rect.grown(0.01, 0.01).holds(rect) for gap in self.gaps):
            return
        self.gaps.append(Gap(rect, axis, leaf=False, unsure=width_m >= self.settings.unsure_from_m))

    def chance(self, share: float) -> bool:
        """Whether something of that chance happens."""
        return bool(self.rng.random() < share)
