"""Section II.A: the grid without what the robot cannot reach and without juts."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated, ClassVar

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage
from skimage.measure import block_reduce
from skimage.measure import label as label_cells

from vdoor.config import Within
from vdoor.errors import MapError, SettingError
from vdoor.frame import Frame
from vdoor.grid import FREE, OCCUPIED, UNKNOWN, OccupancyGrid
from vdoor.method.spaces import SHORTEST_DASH, Spaces, furniture, in_line, opened, square, with_neighbours
from vdoor.raster.runs import runs_of
from vdoor.record import Record, Spec

Mask = NDArray[np.bool_]

ROBOT_REACH_M = 0.5
THIN_LONG_M = 1.0
PART_WIDTH_M = 1.2
SURE_SHARE = 0.7
CHANNEL_LONG_M = 0.4
DASH_THICK_M, DASH_LONG_M = 0.3, 0.25
"""A wall drawn in dashes is no thicker, and one of two dashes in line is at least so long."""
SPACE_M2 = 0.2
"""Less free space than this, in a corner behind a bin, is none that a robot could be kept apart from."""
EPSILON = 1e-9
AROUND = ((0, 0), (0, 1), (0, 2), (1, 0), (1, 2), (2, 0), (2, 1), (2, 2))
REASONS = ("as it was", "unreachable", "jut", "notch", "island", "thin unknown", "slit")


class SimplifiedGrid(Record):
    """The grid at the working resolution: free is what can be reached, all that it does not touch is unknown."""

    topic: ClassVar[str] = "simplified"

    cells: Annotated[NDArray[np.int8], Spec("occupancy", "height width")]
    reason: Annotated[NDArray[np.uint8], Spec("codes", "height width", words=REASONS)]
    """Why a cell is not what resampling made it."""
    factor: Annotated[int, Spec("count")]
    """Input cells along one side of a working cell."""
    frame: Frame


@dataclass(frozen=True, kw_only=True)
class SimplifyGrid:
    """Resample, keep what the robot can reach, drop small islands, flatten juts and notches."""

    cell_m: Annotated[float, Within(0, 10)] = 0.20
    """Working resolution; 0 = the map's own. The nearest whole multiple of the map's cell is taken."""
    robot_m: tuple[float, ...] = ()
    """Where the robot is (x, y in the map frame); without it the largest free component is taken as reachable."""
    jut_m: Annotated[float, Within(0, 1)] = 0.15
    """Longest run that counts as a jut or notch; at least one cell."""
    passes: Annotated[int, Within(0, 100)] = 3
    """Flattening is repeated at most so often."""
    max_island_m: Annotated[float, Within(0, 100)] = 0.0
    """Obstacles standing free whose bounding box is at most this long are removed; 0 keeps all (paper)."""
    thin_unknown_m: Annotated[float, Within(0, 1)] = 0.0
    """Unknown lines up to this thick with free space around them become free; 0 keeps them (paper)."""
    slit_m: Annotated[float, Within(0, 1)] = 0.0
    """Free space up to this wide is closed: hollow walls, cracks in them, single rays; 0 keeps it (paper)."""
    channel_m: Annotated[float, Within(0, 1)] = 0.0
    """So is space up to this wide that goes on for more than 0.4 m, where no robot fits through; 0 keeps it (paper)."""
    gap_m: Annotated[float, Within(0, 1)] = 0.0
    """Gaps up to this wide are closed, since no robot fits through. Islands and thin unknown lines go only where this
    opens no way between spaces that are apart with such gaps closed. Less than a cell: no gap is closed, and all of
    them go (paper)."""
    around_m: Annotated[float, Within(0, 10)] = 1.0
    """Spaces on two sides of an obstacle are apart where no way leads around it within this distance of it."""
    least_part_m2: Annotated[float, Within(0, 1e6)] = 0.0
    """Free parts of at least this area, with room for 1.2 m by 1.2 m, are kept beside the largest, unless the robot's
    place is given; 0 = only one (paper)."""

    def __post_init__(self) -> None:
        """Refuse a place that is not x and y."""
        if len(self.robot_m) not in (0, 2):
            raise SettingError(f"simplify.robot_m: wanted x and y, or none, found {list(self.robot_m)}")

    def __call__(self, grid: OccupancyGrid) -> SimplifiedGrid:
        """Simplify `grid`; MapError where it has no free cell or the robot stands nowhere."""
        factor = max(1, round(self.cell_m / grid.frame.resolution_m))
        frame = working_frame(grid.frame, factor)
        before = resampled(grid, factor)
        reason = np.zeros(before.shape, np.uint8)

        known_free = before == FREE
        thin = np.zeros_like(known_free)
        if self.thin_unknown_m > 0:
            thin = thin_unknown(
                before, *(max(1, round(size / frame.resolution_m)) for size in (self.thin_unknown_m, THIN_LONG_M))
            )
        free = self._reachable(known_free | thin, frame)
        reason[(known_free | thin) & ~free] = REASONS.index("unreachable")
        free = self._without_furniture(free, thin & free, reason, frame)
        if gap := cells_in(self.gap_m, frame):
            free = self._closed(free, Spaces.of(free, gap).gap, reason, frame)
        free = self._without_slits(free, reason, frame)
        run = max(1, round(self.jut_m / frame.resolution_m))
        for name, changed in zip(("jut", "notch"), flatten(free, run, self.passes), strict=True):
            reason[changed] = REASONS.index(name)

        wall = touches(free) & ((before == OCCUPIED) | (reason == REASONS.index("notch")))
        reason[(before == OCCUPIED) & ~free & ~wall] = REASONS.index("unreachable")
        cells = np.full(before.shape, UNKNOWN, np.int8)
        cells[free] = FREE
        cells[wall] = OCCUPIED
        reason[cells == before] = 0
        return SimplifiedGrid(cells=cells, reason=reason, factor=factor, frame=frame)

    def _without_furniture(self, free: Mask, thin: Mask, reason: NDArray[np.uint8], frame: Frame) -> Mask:
        """The free cells, `thin` unknown ones among them, with small islands removed; but walls in pieces stay."""
        islands = np.zeros_like(free)
        gap = cells_in(self.gap_m, frame)
        if self.max_island_m > 0:
            line = np.zeros_like(free)
            if gap:
                thick, long = cells_in(DASH_THICK_M, frame), cells_in(DASH_LONG_M, frame)
                line = in_line(free, wide=gap, thick=thick, least=max(long, SHORTEST_DASH + 1))
            islands = small_islands(free & ~line, max(1, round(self.max_island_m / frame.resolution_m))) & ~free
        if gap:
            known = free & ~thin
            goes = furniture(
                known,
                islands | thin,
                gap=gap,
                around=cells_in(self.around_m, frame),
                least=SPACE_M2 / frame.resolution_m**2,
            )
            # What lay behind a thin line that stays is out of reach now.
            free = self._reachable(known | goes, frame)
            reason[known & ~free] = REASONS.index("unreachable")
            islands, thin = islands & free, thin & free
        reason[thin] = REASONS.index("thin unknown")
        reason[islands] = REASONS.index("island")
        return free | islands

    def _without_slits(self, free: Mask, reason: NDArray[np.uint8], frame: Frame) -> Mask:
        """The free cells that are left without the narrow ones, and can be reached so; all, where these are all."""
        slit, channel = (cells_in(width_m, frame) for width_m in (self.slit_m, self.channel_m))
        narrow = narrower(free, slit) | long_pieces(narrower(free, channel), CHANNEL_LONG_M / frame.resolution_m)
        return self._closed(free, narrow, reason, frame)

    def _closed(self, free: Mask, narrow: Mask, reason: NDArray[np.uint8], frame: Frame) -> Mask:
        """The free cells that are left without the narrow ones, and can be reached so; all, where these are all."""
        wide = free & ~narrow
        if not (narrow.any() and wide.any()):
            return free
        kept = self._reachable(wide, frame)
        reason[narrow] = REASONS.index("slit")
        reason[wide & ~kept] = REASONS.index("unreachable")
        return kept

    def _reachable(self, free: Mask, frame: Frame) -> Mask:
        """The 4-connected component of `free` that holds the robot, else the largest."""
        labels, count = label_cells(free, connectivity=1, return_num=True)
        if count == 0:
            raise MapError(
                f"the map has no free cell at {frame.resolution_m:g} m a cell, so there is nothing to divide into rooms"
            )
        if not self.robot_m:
            cells = runs_of(labels).cells(count)
            kept = np.zeros(count + 1, np.bool_)
            if self.least_part_m2 > 0:
                kept[1:] = cells * frame.resolution_m**2 >= self.least_part_m2
                kept &= wide_enough(labels, kept, PART_WIDTH_M / frame.resolution_m)
            kept[1 + np.argmax(cells)] = True
            return np.asarray(kept[labels])
        place = frame.cell_from_world(np.array([self.robot_m]))[0]
        cells = np.argwhere(free)
        nearest = cells[np.argmin(((cells - place) ** 2).sum(axis=1))]
        if math.dist(nearest, place) * frame.resolution_m > ROBOT_REACH_M:
            x_m, y_m = self.robot_m
            raise MapError(f"robot at {x_m:g},{y_m:g}: wanted a free cell within {ROBOT_REACH_M} m, found none")
        return np.asarray(labels == labels[tuple(nearest)])


def cells_in(length_m: float, frame: Frame) -> int:
    """How many whole cells a length holds."""
    return int(length_m / frame.resolution_m + EPSILON)


def working_frame(frame: Frame, factor: int) -> Frame:
    """The frame of cells `factor` times as large, their rows and columns counted from the same upper left corner."""
    height, width = -(-frame.height // factor), -(-frame.width // factor)
    corner_m = frame.world_from_cell(np.array([[height * factor - 0.5, -0.5]]))[0]
    return Frame(height, width, frame.resolution_m * factor, float(corner_m[0]), float(corner_m[1]), frame.yaw_rad)


def resampled(grid: OccupancyGrid, factor: int) -> NDArray[np.int8]:
    """Working cells: occupied if any of its input cells is, else free if any is, else unknown.

    Any-occupied keeps every wall closed; a majority would lose a third of the narrow doors with it.
    """
    occupied, free = grid.occupied, grid.free
    if factor > 1:
        occupied, free = (block_reduce(mask, factor, np.any) for mask in (occupied, free))
    cells = np.full(occupied.shape, UNKNOWN, np.int8)
    cells[free] = FREE
    cells[occupied] = OCCUPIED
    return cells


def wide_enough(labels: NDArray[np.int32], asked: Mask, width: float) -> Mask:
    """Which labels (count + 1,) have room for a square of `width` cells; hollow furniture has not. Others: False."""
    side = max(1, round(width))
    padded = np.pad(asked[labels], 1).view(np.uint8)
    inner = ndimage.minimum_filter(padded, side, mode="constant", cval=0)[1:-1, 1:-1] > 0
    found = np.zeros(len(asked), np.bool_)
    found[np.unique(labels[inner])] = True
    return found


def thin_unknown(cells: NDArray[np.int8], thick: int, longest: int) -> Mask:
    """Unknown cells in lines at most `thick` and `longest` cells large, whose neighbours are nearly all free.

    Longer ones are walls that were drawn or seen in part.
    """
    unknown = cells == UNKNOWN
    box = np.ones((thick + 1, thick + 1), np.bool_)
    thin = unknown & ~ndimage.binary_dilation(ndimage.binary_erosion(unknown, box, border_value=1), box)
    row, col = np.nonzero(thin)
    around = np.pad(cells, 1, constant_values=UNKNOWN)
    near = np.stack([around[row + down, col + right] for down, right in AROUND])
    free = (near == FREE).sum(axis=0)
    mended = np.zeros(cells.shape, np.bool_)
    enough = free >= SURE_SHARE * near.shape[0]
    mended[row[enough], col[enough]] = True
    return mended & ~long_pieces(mended, longest, connectivity=2)


def small_islands(free: Mask, size: int) -> Mask:
    """Cells of 8-connected obstacles that lie within the free space and in a box of `size` cells."""
    labels = label_cells(np.pad(~free, 1, constant_values=True), connectivity=2)
    outer = labels[0, 0]
    small = np.zeros(labels.max() + 1, np.bool_)
    for label, box in enumerate(ndimage.find_objects(labels), start=1):
        small[label] = label != outer and max(side.stop - side.start for side in box) <= size
    return np.asarray(small[labels][1:-1, 1:-1])


def narrower(free: Mask, thick: int) -> Mask:
    """Free cells where no free square of more than `thick` cells a side has room."""
    return free & ~opened(free, square(thick + 1))


def long_pieces(mask: Mask, least: float, connectivity: int = 1) -> Mask:
    """The connected pieces of `mask` (1: by sides, 2: by corners as well) in boxes more than `least` cells long."""
    labels = label_cells(mask, connectivity=connectivity)
    long = np.zeros(labels.max() + 1, np.bool_)
    for label, place in enumerate(ndimage.find_objects(labels), start=1):
        long[label] = max(side.stop - side.start for side in place) > least
    return np.asarray(long[labels])


def touches(free: Mask) -> Mask:
    """Cells that are not free and have a free cell among their eight neighbours."""
    return with_neighbours(free) & ~free


def flatten(free: Mask, run: int, passes: int) -> tuple[Mask, Mask]:
    """Flatten juts and notches of `free` in place; returns the cells that became free, and those that no longer are.

    A jut is a run of at most `run` cells, one deep, on a wall that goes on at least one cell past both ends. A notch
    is the same with free and obstacle exchanged. All four directions are judged on the same state, so that the result
    turns and mirrors with the map.
    """
    state = np.pad(free, 2)
    start = state.copy()
    near = np.flatnonzero(np.diff(state, axis=0, append=False) | np.diff(state, axis=1, append=False))
    near = spread(near, state, 1)
    for _ in range(passes):
        changed = np.concatenate([runs(state, near, run, value) for value in (False, True)])
        if not len(changed):
            break
        state.reshape(-1)[changed] ^= True
        near = spread(changed, state, run + 2)
    free[:] = state[2:-2, 2:-2]
    return (state & ~start)[2:-2, 2:-2], (start & ~state)[2:-2, 2:-2]


def spread(index: NDArray[np.intp], state: Mask, reach: int) -> NDArray[np.intp]:
    """Flat indices within `reach` cells (as a square) of any in `index`, away from the padding."""
    mask = np.zeros(state.size, np.bool_)
    step = np.arange(-reach, reach + 1)
    for offset in (step[:, None] * state.shape[1] + step).ravel():
        mask[np.clip(index + offset, 0, state.size - 1)] = True
    inner = np.zeros(state.shape, np.bool_)
    inner[2:-2, 2:-2] = True
    return np.flatnonzero(mask & inner.ravel())


def runs(state: Mask, near: NDArray[np.intp], longest: int, value: bool) -> NDArray[np.intp]:
    """Flat indices of all cells in runs of `value`, up to `longest` cells long and one deep, on a base of `value`."""
    flat = state.reshape(-1)
    found = []
    width = state.shape[1]
    for along, up in ((1, -width), (1, width), (width, -1), (width, 1)):
        # first cells of a run: the cell before is other, the tip side is other, the base goes on before
        at = near[flat[near] == value]
        for offset, wanted in (
            (-along, not value),
            (up, not value),
            (up - along, not value),
            (-up, value),
            (-up - along, value),
        ):
            at = at[flat[at + offset] == wanted]
        for length in range(1, longest + 1):
            end = at + length * along  # one past the run
            closed = flat[end] != value
            closed &= (flat[end + up] != value) & (flat[end - up] == value)
            found += [at[closed] + step * along for step in range(length)]
            goes_on = (flat[end] == value) & (flat[end + up] != value) & (flat[end - up] == value)
            at = at[goes_on]
    return np.concatenate(found)
