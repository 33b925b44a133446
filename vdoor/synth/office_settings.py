"""What kind of office floor to draw: corridors with rooms on both sides, halls, cubicles, as in architects' plans."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

from vdoor.errors import SettingError
from vdoor.synth.settings import CHANCE, check_bounds


@dataclass(frozen=True, kw_only=True)
class Office:
    """Settings of one office floor; what comes as `_min` and `_max` is drawn in between.

    Raises `SettingError` for values that no office can have.
    """

    length_min_m: float = 18.0
    """Along the main corridors."""
    length_max_m: float = 48.0
    corridors_max: int = 3
    """Main corridors, from 1 to this; cross corridors join them."""
    corridor_min_m: float = 1.2
    corridor_max_m: float = 3.0
    room_depth_min_m: float = 3.2
    room_depth_max_m: float = 7.0
    room_width_min_m: float = 2.2
    room_width_max_m: float = 6.5
    wall_min_m: float = 0.1
    wall_max_m: float = 0.3
    door_min_m: float = 0.8
    """One width is drawn for the floor, a few doors differ."""
    door_max_m: float = 1.1
    double_chance: float = 0.12
    """Chance of a double door of 1.4 to 2 m; halls have them more often."""
    open_chance: float = 0.12
    """Chance of an opening of 1.2 to 2.6 m in place of a door."""
    unsure_from_m: float = 2.4
    """Openings from this width on are marked as unsure."""
    door_corner_chance: float = 0.7
    flush_chance: float = 0.2
    """Chance of a floor whose doors in corners have no jamb there: they end at the wall across."""
    extra_door_chance: float = 0.08
    """Chance of a door between neighbours, and of a second one to a corridor."""
    corridor_door_chance: float = 0.35
    """Chance of a door across a corridor, for each of its spans."""
    mouth_chance: float = 0.4
    """Chance of a floor whose cross corridors are parted from the main ones where they meet."""
    end_hall_chance: float = 0.5
    """Chance that what lies beyond the corridors' end is a hall they run into, not a column of rooms."""
    open_hall_chance: float = 0.5
    """Chance that a hall between corridors takes one in, or both, as where a corridor widens."""
    divided_hall_chance: float = 0.4
    """Chance that a hall is parted by a row of blocks with openings between them."""
    screen_chance: float = 0.3
    """Chance that a large room has a short wall in it, free or from a wall on, that parts nothing."""
    anteroom_chance: float = 0.08
    """Chance that a room is divided in two, one behind the other."""
    notch_chance: float = 0.45
    """Chance for each outer row of rooms that part of it is missing."""
    furnished_chance: float = 0.6
    furniture: bool = True
    """False: none, whatever the chance."""
    faded_chance: float = 0.25
    """Chance of a floor of whose walls a share, from none to all, is unknown."""
    hollow_chance: float = 0.12
    """Chance of a floor whose walls, all or some, are outlines with free or unknown cells inside."""
    hollow_wall_min_m: float = 0.15
    """Where walls are hollow they are this thick or more, and three and a half cells where that is more."""
    hollow_wall_max_m: float = 0.6
    dashed_chance: float = 0.08
    """Chance of a floor whose walls, all or some, are pieces of 0.3 to 1.5 m with gaps between."""
    dash_gap_max_m: float = 0.2
    """Gaps in dashed walls have one to three cells, and not more than this unless a cell is larger."""
    antialiased_chance: float = 0.12
    """Chance of a floor whose walls, all or some, have grey edges, which are unknown, around an occupied core."""
    rough_chance: float = 0.4
    """Chance of a floor that was scanned, not drawn: rough walls, a few rays."""
    rough_max: float = 0.2
    rotated_chance: float = 0.75
    """Chance of a floor that does not lie straight: by up to 6 degrees, two in five of them by up to 45."""
    cell_m: float = 0.05

    def __post_init__(self) -> None:
        """Check every value against what can be drawn."""
        check_bounds(self, BOUNDS)
        for name in ("length", "corridor", "room_depth", "room_width", "wall", "hollow_wall", "door"):
            low, high = getattr(self, f"{name}_min_m"), getattr(self, f"{name}_max_m")
            if low > high:
                raise SettingError(f"Office.{name}_max_m: wanted at least {name}_min_m = {low:g}, found {high:g}")


BOUNDS: Mapping[str, tuple[float, float]] = MappingProxyType(
    {
        "length_min_m": (8.0, 200.0),
        "length_max_m": (8.0, 200.0),
        "corridors_max": (1, 12),
        "corridor_min_m": (1.0, 8.0),
        "corridor_max_m": (1.0, 8.0),
        "room_depth_min_m": (2.0, 20.0),
        "room_depth_max_m": (2.0, 20.0),
        "room_width_min_m": (1.8, 20.0),
        "room_width_max_m": (1.8, 20.0),
        "wall_min_m": (0.1, 0.6),
        "wall_max_m": (0.1, 0.6),
        "door_min_m": (0.7, 1.3),
        "door_max_m": (0.7, 1.3),
        "unsure_from_m": (1.2, 10.0),
        "hollow_wall_min_m": (0.15, 0.6),
        "hollow_wall_max_m": (0.15, 0.6),
        "dash_gap_max_m": (0.0, 0.3),
        "rough_max": (0.0, 0.5),
        "cell_m": (0.025, 0.1),
        **dict.fromkeys(
            (
                "double_chance",
                "open_chance",
                "door_corner_chance",
                "extra_door_chance",
                "corridor_door_chance",
                "anteroom_chance",
                "end_hall_chance",
                "divided_hall_chance",
                "screen_chance",
                "open_hall_chance",
                "notch_chance",
                "flush_chance",
                "mouth_chance",
                "faded_chance",
                "furnished_chance",
                "rough_chance",
                "rotated_chance",
                "hollow_chance",
                "dashed_chance",
                "antialiased_chance",
            ),
            CHANCE,
        ),
    }
)
