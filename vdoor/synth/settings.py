"""All that one can set for apartments, homes and offices; values that cannot be drawn are refused."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from vdoor.errors import SettingError
from vdoor.synth.bounds import APARTMENT_BOUNDS, HOME_BOUNDS, OFFICE_BOUNDS, check, check_order
from vdoor.synth.canvas import FINE_M, LATTICE_M, lattice_range


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
        check(self, APARTMENT_BOUNDS)
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


@dataclass(frozen=True, kw_only=True)
class Dwelling:
    """What all homes have: a plan, what stands in it, how it lies; what comes as `_min` and `_max` is drawn between."""

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
    left_out_chance: float = 0.2
    """Chance of a home in which a room was not visited."""
    rotated_chance: float = 0.35
    """Chance of a home that does not lie straight: by up to 6 degrees, two in five of them by up to 45."""
    cell_m: float = 0.05

    def __post_init__(self) -> None:
        """Check every value against what can be drawn."""
        check(self, HOME_BOUNDS)
        check_order(self)


@dataclass(frozen=True, kw_only=True)
class Home(Dwelling):
    """Settings of one home as a robot vacuum maps it.

    Raises `SettingError` for values that no home can have.
    """

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


@dataclass(frozen=True, kw_only=True)
class LaserHome(Dwelling):
    """Settings of one home as a robot with a laser scanner maps it by SLAM.

    Raises `SettingError` for values that no home can have.
    """

    area_min_m2: float = 24.0
    area_max_m2: float = 150.0
    clutter_min_per_m2: float = 0.3
    clutter_max_per_m2: float = 2.0
    rotated_chance: float = 0.9
    scans_min_per_m2: float = 0.4
    """Places that the robot scans from: drawn per home, from here to `scans_max_per_m2`."""
    scans_max_per_m2: float = 1.2
    rays: int = 360
    """Of one scan."""
    range_min_m: float = 3.5
    """As far as the scanner sees: drawn per home, on a logarithmic scale, from here to `range_max_m`."""
    range_max_m: float = 12.0
    noise_max_m: float = 0.04
    """Standard deviation of a range: drawn per home from 0 to this."""
    drift_max_m: float = 0.08
    """Standard deviation of a room's place: drawn per home from 0 to this. Walls seen from two rooms are double."""
    drift_max_deg: float = 0.8
    hit_share_min: float = 0.05
    """A cell is occupied if this share of the rays that reach it end in it: drawn per home, up to `hit_share_max`."""
    hit_share_max: float = 0.25
    glass: float = 1.2
    """Mean number of windows down to the floor: most rays go through, and some of those come back from outside."""
    people: float = 0.7
    """Mean number of walks past the scanner."""
    unvisited_chance: float = 0.25
    """Chance of a home with a room that is seen through its doors only."""


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
        check(self, OFFICE_BOUNDS)
        check_order(self)


def chance(share: float, rng: np.random.Generator) -> bool:
    """Whether something happens that does in that share of cases."""
    return bool(rng.random() < share)


def log_uniform(low: float, high: float, rng: np.random.Generator) -> float:
    """Draw a value between the two, evenly on a logarithmic scale."""
    return math.exp(rng.uniform(math.log(low), math.log(high)))
