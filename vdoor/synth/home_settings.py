"""What kind of home to draw: as a robot vacuum maps it, lived in and seen in part."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType

from vdoor.errors import SettingError
from vdoor.synth.settings import CHANCE, check_bounds


@dataclass(frozen=True, kw_only=True)
class Home:
    """Settings of one home; what comes as `_min` and `_max` is drawn in between.

    Raises `SettingError` for values that no home can have.
    """

    area_min_m2: float = 16.0
    """Between the outer walls; drawn evenly on a logarithmic scale."""
    area_max_m2: float = 110.0
    aspect_max: float = 2.2
    """The longer side over the shorter one is drawn from 1 to this."""
    room_min_m2: float = 6.0
    """Rooms are divided until they are below a size drawn from here to `room_max_m2`, times 0.5 to 1 each."""
    room_max_m2: float = 20.0
    room_side_min_m: float = 1.3
    corridor_chance: float = 0.6
    """Chance of a corridor, in homes of over 45 m2."""
    corridor_min_m: float = 0.85
    corridor_max_m: float = 1.5
    wall_min_m: float = 0.075
    wall_max_m: float = 0.25
    door_min_m: float = 0.55
    door_max_m: float = 1.0
    door_corner_chance: float = 0.75
    """Chance of a door within 0.05 to 0.3 m of a corner."""
    flush_chance: float = 0.05
    """Chance of a door without a jamb where it stands in a corner."""
    extra_door_chance: float = 0.12
    """Chance of a door between two neighbours who do not need it to reach each other."""
    open_chance_min: float = 0.05
    """Share of doors that are openings of 1.2 to 3 m: drawn per home, from here to `open_chance_max`."""
    open_chance_max: float = 0.3
    merge_chance_max: float = 0.18
    """Share of neighbours with no wall between them, which are one room: drawn per home from 0 to this."""
    unsure_from_m: float = 1.5
    """Openings from this width on are marked as unsure."""
    jog_chance: float = 0.3
    """Chance that the wall is set back on one side of a door next to a corner, so that the door lies aslant."""
    outside_chance: float = 0.08
    """Share of rooms that belong to the neighbours: homes are not boxes."""
    leaf_chance: float = 0.55
    """Chance of a door's open leaf in the map."""
    niche_chance: float = 0.6
    """Chance of something beside a door, 0.1 to 0.6 m deep and long."""
    furniture: bool = True
    wall_pieces_per_m2: float = 0.4
    """Against walls, at most six a room on average."""
    free_pieces_per_m2: float = 0.09
    """Free-standing, at most two and a half a room on average."""
    clutter_min_per_m2: float = 0.2
    """Legs and small things: drawn per home, on a logarithmic scale, from here to `clutter_max_per_m2`."""
    clutter_max_per_m2: float = 1.5
    wall_piece_clear_m: float = 0.6
    """Left free before both sides of a door by large furniture."""
    clutter_clear_m: float = 0.25
    """Left free before both sides of a door by small things."""
    shafts: float = 0.5
    """Mean number of chimneys and shafts in the corners of rooms."""
    windows: float = 0.7
    """Mean number of windows through which scan rays leave."""
    holes_chance: float = 0.5
    """Chance of a home with small holes in its walls."""
    rough_chance: float = 0.75
    """Chance of a home with rough walls."""
    rough_max: float = 0.3
    """Share of a rough home's wall that is a cell off: drawn from 0 to this."""
    corners_chance: float = 0.4
    """Chance of a home with corners that were not explored."""
    unknown_max: float = 0.15
    """Share of wall cells that are unknown: drawn per home from 0 to this."""
    pockets_chance: float = 0.25
    """Chance of a home with thin lines of unknown cells in its rooms."""
    specks: float = 0.7
    """Mean number of free or occupied blots out of reach."""
    hollow_chance: float = 0.02
    """Chance of a home whose walls, all or some, are outlines with free or unknown cells inside."""
    hollow_wall_min_m: float = 0.15
    """Where walls are hollow they are this thick or more, and three and a half cells where that is more."""
    hollow_wall_max_m: float = 0.6
    dashed_chance: float = 0.05
    """Chance of a home whose walls, all or some, are pieces of 0.3 to 1.5 m with gaps between."""
    dash_gap_max_m: float = 0.2
    """Gaps in dashed walls have one to three cells, and not more than this unless a cell is larger."""
    antialiased_chance: float = 0.05
    """Chance of a home whose walls, all or some, have grey edges, which are unknown, around an occupied core."""
    left_out_chance: float = 0.2
    """Chance of a home in which a room was not visited."""
    rotated_chance: float = 0.35
    """Chance of a home that does not lie straight: by up to 6 degrees, two in five of them by up to 45."""
    cell_m: float = 0.05

    def __post_init__(self) -> None:
        """Check every value against what can be drawn."""
        check_bounds(self, BOUNDS)
        for low, high in PAIRS:
            if getattr(self, low) > getattr(self, high):
                found = f"{low} = {getattr(self, low):g}"
                raise SettingError(f"Home.{high}: wanted at least {found}, found {getattr(self, high):g}")


PAIRS = (
    ("area_min_m2", "area_max_m2"),
    ("room_min_m2", "room_max_m2"),
    ("corridor_min_m", "corridor_max_m"),
    ("wall_min_m", "wall_max_m"),
    ("hollow_wall_min_m", "hollow_wall_max_m"),
    ("door_min_m", "door_max_m"),
    ("open_chance_min", "open_chance_max"),
    ("clutter_min_per_m2", "clutter_max_per_m2"),
)
BOUNDS: Mapping[str, tuple[float, float]] = MappingProxyType(
    {
        "area_min_m2": (8.0, 1000.0),
        "area_max_m2": (8.0, 1000.0),
        "aspect_max": (1.0, 4.0),
        "room_min_m2": (4.0, 200.0),
        "room_max_m2": (4.0, 200.0),
        "room_side_min_m": (1.0, 5.0),
        "corridor_min_m": (0.8, 3.0),
        "corridor_max_m": (0.8, 3.0),
        "wall_min_m": (0.075, 0.6),  # thinner walls would leak when they are turned
        "wall_max_m": (0.075, 0.6),
        "door_min_m": (0.5, 1.2),
        "door_max_m": (0.5, 1.2),
        "unsure_from_m": (1.2, 10.0),
        "wall_pieces_per_m2": CHANCE,
        "free_pieces_per_m2": CHANCE,
        "clutter_min_per_m2": (0.001, 3.0),
        "clutter_max_per_m2": (0.001, 3.0),
        "wall_piece_clear_m": (0.0, 2.0),
        "clutter_clear_m": (0.0, 2.0),
        "shafts": (0.0, 20.0),
        "windows": (0.0, 20.0),
        "specks": (0.0, 100.0),
        "hollow_wall_min_m": (0.15, 0.6),
        "hollow_wall_max_m": (0.15, 0.6),
        "dash_gap_max_m": (0.0, 0.3),
        "rough_max": (0.0, 0.5),
        "unknown_max": (0.0, 0.9),
        "cell_m": (0.025, 0.05),  # walls are drawn for cells no larger
        **dict.fromkeys(
            (
                "corridor_chance",
                "door_corner_chance",
                "flush_chance",
                "extra_door_chance",
                "open_chance_min",
                "open_chance_max",
                "merge_chance_max",
                "jog_chance",
                "outside_chance",
                "leaf_chance",
                "niche_chance",
                "holes_chance",
                "rough_chance",
                "corners_chance",
                "pockets_chance",
                "left_out_chance",
                "rotated_chance",
                "hollow_chance",
                "dashed_chance",
                "antialiased_chance",
            ),
            CHANCE,
        ),
    }
)
