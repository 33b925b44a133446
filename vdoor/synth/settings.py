"""What kind of apartment to draw. The defaults are the paper's kind: orthogonal, sparsely cluttered, 20 cm cells."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import TYPE_CHECKING

from vdoor.errors import SettingError

if TYPE_CHECKING:
    from _typeshed import DataclassInstance

FINE_M = 0.025
"""Side of a cell of the raster that everything is drawn on."""
LATTICE_M = 0.05
"""Walls, doors and furniture begin and end on multiples of this, so that 5 cm cells show them exactly."""


def snap(value_m: float) -> float:
    """Return the nearest multiple of `LATTICE_M`."""
    return round(value_m / LATTICE_M) / round(1 / LATTICE_M)


def lattice_range(low_m: float, high_m: float) -> range:
    """Return which multiples of `LATTICE_M` lie between the two, both included."""
    return range(math.ceil(low_m / LATTICE_M - 1e-6), math.floor(high_m / LATTICE_M + 1e-6) + 1)


def check_bounds(settings: DataclassInstance, bounds: Mapping[str, tuple[float, float]]) -> None:
    """Raise `SettingError` unless every value lies within its bounds, both included; from 0 to 1e4 where none are."""
    for field in dataclasses.fields(settings):
        value, (low, high) = getattr(settings, field.name), bounds.get(field.name, (0.0, 1e4))
        if not low <= value <= high:  # nan is not in any range
            place = f"{type(settings).__name__}.{field.name}"
            raise SettingError(f"{place}: wanted {low:g} to {high:g}, found {value}")


@dataclass(frozen=True, kw_only=True)
class Apartment:
    """Settings of one apartment; lengths that come as `_min_m` and `_max_m` are drawn evenly in between.

    Raises `SettingError` for values that no apartment can have.
    """

    area_m2: float = 55.0
    """Between the outer walls."""
    aspect_max: float = 1.6
    """The longer side over the shorter one is drawn from 1 to this."""
    rooms: int = 5
    """Corridor included."""
    rooms_spread: int = 0
    """The number of rooms is drawn from `rooms` minus this to `rooms` plus this."""
    room_side_min_m: float = 1.8
    corridor_chance: float = 0.5
    """Chance of a corridor along the whole apartment, where it has at least four rooms."""
    corridor_min_m: float = 1.4
    """Narrower ones have virtual doors across them: the paper joins what is up to 1.2 m away."""
    corridor_max_m: float = 1.8
    wall_min_m: float = 0.1
    wall_max_m: float = 0.25
    door_min_m: float = 0.7
    """Between the faces of the jambs."""
    door_max_m: float = 0.9
    jamb_m: float = 0.3
    """Wall that is left on either side of a door, at least."""
    door_corner_chance: float = 0.75
    """Chance of a door within 0.2 m of the place nearest to a corner that `jamb_m` allows."""
    extra_door_chance: float = 0.12
    """Chance of a door between two neighbours who do not need it to reach each other."""
    furniture: bool = False
    wall_pieces_per_m2: float = 0.2
    free_pieces_per_m2: float = 0.08
    aisle_m: float = 1.4
    """Left free in front of what stands against a wall."""
    door_clear_m: float = 0.7
    """Left free by furniture in front of both sides of a door."""
    juts_per_room: float = 1.0
    """Mean number of juts, 5 cm deep and 5 to 15 cm long."""
    wall_noise: float = 0.01
    """Share of the length of all wall faces that is covered by bumps of 5 cm."""
    windows: float = 1.0
    """Mean number of windows through which scan rays leave, at most one in each outer wall of a room."""
    speckles: float = 12.0
    """Mean number of free or occupied blots outside, out of reach."""
    rotation_deg: float = 0.0
    """Counter-clockwise."""
    margin_m: float = 1.0
    """Unknown space around the outer walls."""
    cell_m: float = 0.2

    def __post_init__(self) -> None:
        """Check every value against what can be drawn."""
        check_bounds(self, BOUNDS)
        for name in ("wall", "door", "corridor"):
            low, high = getattr(self, f"{name}_min_m"), getattr(self, f"{name}_max_m")
            if not lattice_range(low, high):
                raise SettingError(
                    f"Apartment.{name}_max_m: wanted a multiple of {LATTICE_M} from {name}_min_m = "
                    f"{low:g} on, found {high:g}"
                )
        if self.rooms <= self.rooms_spread:
            raise SettingError(
                f"Apartment.rooms_spread: wanted less than rooms = {self.rooms}, found {self.rooms_spread}"
            )
        if not math.isclose(self.cell_m, round(self.cell_m / FINE_M) * FINE_M):
            raise SettingError(f"Apartment.cell_m: wanted a whole multiple of {FINE_M}, found {self.cell_m}")


CHANCE = (0.0, 1.0)
BOUNDS: Mapping[str, tuple[float, float]] = MappingProxyType(
    {
        "area_m2": (4.0, 2000.0),
        "aspect_max": (1.0, 4.0),
        "rooms": (1, 200),
        "rooms_spread": (0, 100),
        "room_side_min_m": (1.6, 10.0),  # a shared wall must hold the widest door and two jambs
        "corridor_chance": CHANCE,
        "corridor_min_m": (0.95, 3.0),
        "corridor_max_m": (0.95, 3.0),
        "wall_min_m": (0.1, 0.4),  # thinner walls would leak when they are turned
        "wall_max_m": (0.1, 0.4),
        "door_min_m": (0.7, 1.2),  # narrower doors may vanish at 20 cm
        "door_max_m": (0.7, 1.2),
        "jamb_m": (0.1, 1.0),
        "door_corner_chance": CHANCE,
        "extra_door_chance": CHANCE,
        "wall_pieces_per_m2": CHANCE,
        "free_pieces_per_m2": CHANCE,
        "aisle_m": (0.5, 4.0),
        "door_clear_m": (0.7, 2.0),
        "juts_per_room": (0.0, 20.0),
        "wall_noise": (0.0, 0.5),
        "windows": (0.0, 20.0),
        "speckles": (0.0, 1000.0),
        "rotation_deg": (-360.0, 360.0),
        "margin_m": (0.4, 10.0),
        "cell_m": (FINE_M, 0.2),
    }
)
