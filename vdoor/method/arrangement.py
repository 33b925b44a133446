"""The arrangement of virtual doors on the free space: the pieces it is cut into, and the doors that separate them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy
from numpy.typing import NDArray

from vdoor.method.doors import VirtualDoors
from vdoor.raster.components import components
from vdoor.raster.runs import Runs, neighbours, overlaid, parts_of_mask

Ints = NDArray[np.int32]
Mask = NDArray[np.bool_]

HOPS = 3
"""Number of adjacent doors across which the regions beside a door are searched."""


@dataclass(frozen=True)
class Pieces:
    """The free space cut along doors, which are numbered 0 to k - 1 here.

    Its pieces are regions between the doors, and atoms: groups of door cells that are on the same set of doors.
    """

    region: Runs
    """The cells of region r have label r + 1."""
    regions: int
    """The number of regions."""
    cell: NDArray[np.int64]
    """(k,) flat indices of the door cells, sorted."""
    atom: NDArray[np.intp]
    """(k,) the atom of each of them."""
    cells: NDArray[np.int64]
    """(pieces,) number of cells of each piece."""
    cover: Ints
    """(m, 2) atom, door: the doors that each atom is on, sorted."""
    touch: Ints
    """(t, 2) pieces a < b with 4-adjacent cells, sorted."""

    def at(self, cell: NDArray[np.int64]) -> Ints:
        """Piece + 1 at cells given by flat index, 0 where not free; regions first, then atoms."""
        return overlaid(self.region, self.cell, self.regions + 1 + self.atom, cell)

    def image(self) -> Ints:
        """The same for all cells (h, w)."""
        label = self.region.image()
        label.reshape(-1)[self.cell] = self.regions + 1 + self.atom
        return label


def cut(free: Mask, doors: VirtualDoors, chosen: Ints) -> Pieces:
    """The free space cut along the chosen doors (rows of `doors`)."""
    number = np.full(len(doors.verdict), -1, np.int32)
    number[chosen] = np.arange(len(chosen), dtype=np.int32)
    on = number[doors.line_door] >= 0
    flat = doors.line_cell[on, 0].astype(np.int64) * free.shape[1] + doors.line_cell[on, 1]
    cell, atom_of_cell, cover = atoms(flat, number[doors.line_door[on]], free.shape[1])

    region_space = free.copy()
    region_space.reshape(-1)[cell] = False
    region = parts_of_mask(region_space)
    own = region.most + 1 + atom_of_cell
    # Only door cells need checking for adjacency: regions never touch each other.
    near, source = neighbours(cell, free.shape)
    other = overlaid(region, cell, own, near)
    beside = (other > 0) & (other != own[source])
    pairs = np.stack([own[source[beside]], other[beside]], axis=1)
    touch = np.unique(np.sort(pairs, axis=1), axis=0) - 1
    cells = np.append(region.cells(region.most), np.bincount(atom_of_cell))
    return Pieces(region, region.most, cell, atom_of_cell, cells, cover, touch.astype(np.int32))


def atoms(flat: NDArray[np.int64], door: Ints, width: int) -> tuple[NDArray[np.int64], NDArray[np.intp], Ints]:
    """Door cells (k,) as sorted flat indices, the atom (k,) of each, and rows (m, 2) of atom and door, sorted.

    An atom is a 4-connected group of cells that are on the same set of doors.
    """
    order = np.lexsort((door, flat))
    flat, door = flat[order], door[order]
    cell, begin, count = np.unique(flat, return_index=True, return_counts=True)
    same_set = sets_of_doors(door, begin)
    links = []
    for step in (1, width):
        beside = np.searchsorted(cell, cell + step)
        beside[beside == len(cell)] = 0
        linked = (cell[beside] == cell + step) & (same_set[beside] == same_set) if len(cell) else np.zeros(0, np.bool_)
        linked &= (step != 1) | (cell % width != width - 1)
        links.append(np.stack([np.flatnonzero(linked), beside[linked]]))
    atom = components(np.concatenate(links, axis=1), len(cell))
    cover = np.unique(np.stack([np.repeat(atom, count), door], axis=1), axis=0)
    return cell, atom, cover.astype(np.int32)


def sets_of_doors(door: Ints, begin: NDArray[np.intp]) -> NDArray[np.int64]:
    """A number (cells,) for each cell's set of doors, equal only for equal sets; `door` must be sorted in each cell."""
    count = np.diff(np.append(begin, len(door)))
    number = np.zeros(len(begin), np.int64)
    for place in range(count.max(initial=0)):
        longer = np.flatnonzero(count > place)
        _, found = np.unique(np.stack([number[longer], door[begin[longer] + place]]), axis=1, return_inverse=True)
        number[longer] = number.max() + 1 + found
    return number


def borders(pieces: Pieces, doors: int) -> Ints:
    """Rows (k, 2) of each door and the regions it borders, sorted.

    A door borders the regions that its atoms touch. If those are fewer than two, another door runs along or across it
    on one side; the regions beyond that door count as well, up to `HOPS` doors away.
    """
    to_region = pieces.touch[pieces.touch[:, 0] < pieces.regions][:, ::-1] - np.array([pieces.regions, 0], np.int32)
    between = pieces.touch[pieces.touch[:, 0] >= pieces.regions] - np.int32(pieces.regions)
    to_atom = np.concatenate([between, between[:, ::-1]])
    atom_and_door = pieces.cover
    found = _join(atom_and_door, to_region)
    for _ in range(HOPS):
        short = np.bincount(found[:, 0], minlength=doors) < 2  # noqa: PLR2004  # two sides
        atom_and_door = atom_and_door[short[atom_and_door[:, 1]]]
        if not len(atom_and_door):
            break
        reached = _join(atom_and_door, to_atom)[:, ::-1]
        atom_and_door = np.unique(np.concatenate([atom_and_door, reached]), axis=0)
        found = np.unique(np.concatenate([found, _join(atom_and_door, to_region)]), axis=0)
    return found.astype(np.int32)


def _join(key_left: NDArray[np.integer], key_right: NDArray[np.integer]) -> Ints:
    """The join of the relations (key, left) and (key, right): unique sorted rows (left, right), by a matrix product."""
    keys = int(max(key_left[:, 0].max(initial=-1), key_right[:, 0].max(initial=-1))) + 1
    left, right = (
        scipy.sparse.coo_array(
            (np.ones(len(rows), np.int32), (rows[:, 0], rows[:, 1])), shape=(keys, int(rows[:, 1].max(initial=-1)) + 1)
        )
        for rows in (key_left, key_right)
    )
    found = (left.tocsr().T @ right.tocsr()).tocsr()
    found.sort_indices()
    return np.stack(found.nonzero(), axis=1).astype(np.int32)
