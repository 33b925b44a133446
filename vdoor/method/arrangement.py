"""The arrangement of doors on the free space: the pieces it is cut into, and which doors keep them apart."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from skimage.measure import label as label_cells

from vdoor.method.doors import VirtualDoors
from vdoor.raster.runs import runs_of

Ints = NDArray[np.int32]
Mask = NDArray[np.bool_]

HOPS = 3
"""How many doors a door is looked through for the regions at its sides."""


@dataclass(frozen=True)
class Pieces:
    """The free space cut along doors, which are numbered 0 to k - 1 here."""

    label: Ints
    """(h, w) piece + 1, 0 where not free; regions first, then atoms."""
    regions: int
    cells: NDArray[np.int64]
    """(pieces,) how many cells each has."""
    cover: Ints
    """(m, 2) atom, door: which doors the atom lies on, sorted."""
    touch: Ints
    """(t, 2) pieces a < b with 4-adjacent cells, sorted."""


def cut(free: Mask, doors: VirtualDoors, chosen: Ints) -> Pieces:
    """Cut the free space along the chosen doors (rows of `doors`)."""
    number = np.full(len(doors.verdict), -1, np.int32)
    number[chosen] = np.arange(len(chosen), dtype=np.int32)
    on = number[doors.line_door] >= 0
    flat = doors.line_cell[on, 0].astype(np.int64) * free.shape[1] + doors.line_cell[on, 1]
    cell, atom_of_cell, cover = atoms(flat, number[doors.line_door[on]], free.shape[1])

    region_space = free.copy()
    region_space.reshape(-1)[cell] = False
    label, regions = label_cells(region_space, connectivity=1, return_num=True)
    label.reshape(-1)[cell] = regions + 1 + atom_of_cell
    # Adjacency is asked of the door cells only: regions never touch each other.
    padded = np.pad(label, 1)
    row, col = np.divmod(cell, free.shape[1])
    pairs = [
        np.stack([label.reshape(-1)[cell], padded[row + 1 + down, col + 1 + right]], axis=1)
        for down, right in ((0, 1), (1, 0), (0, -1), (-1, 0))
    ]
    touch = np.sort(np.concatenate(pairs), axis=1)
    touch = np.unique(touch[(touch[:, 0] > 0) & (touch[:, 0] != touch[:, 1])], axis=0) - 1
    piece: Ints = label.astype(np.int32, copy=False)
    cells = runs_of(piece).cells(regions + int(atom_of_cell.max(initial=-1)) + 1)
    return Pieces(piece, regions, cells, cover, touch.astype(np.int32))


def atoms(flat: NDArray[np.int64], door: Ints, width: int) -> tuple[NDArray[np.int64], NDArray[np.intp], Ints]:
    """Door cells (k,) as sorted flat indices, the atom of each, and rows (m, 2) of atom and door, sorted.

    An atom is a 4-connected group of cells that lie on the same set of doors.
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
    """A number (cells,) for each cell's set of doors, which are sorted: equal for equal sets, and for no others."""
    count = np.diff(np.append(begin, len(door)))
    number = np.zeros(len(begin), np.int64)
    for place in range(count.max(initial=0)):
        longer = np.flatnonzero(count > place)
        _, found = np.unique(np.stack([number[longer], door[begin[longer] + place]]), axis=1, return_inverse=True)
        number[longer] = number.max() + 1 + found
    return number


def components(links: NDArray[np.intp], count: int) -> NDArray[np.intp]:
    """Component (count,) of each node under links (2, k), numbered by their first member."""
    if not count:
        return np.zeros(0, np.intp)
    graph = coo_array((np.ones(links.shape[1], np.bool_), (links[0], links[1])), shape=(count, count))
    _, label = connected_components(graph, directed=False)
    _, first, inverse = np.unique(label, return_index=True, return_inverse=True)
    return np.argsort(np.argsort(first))[inverse]


def borders(pieces: Pieces, doors: int) -> Ints:
    """Rows (k, 2) of door and region it borders, sorted.

    A door borders the regions its own atoms touch. Where those are fewer than two, a door beside or across it takes
    their place on one side, and the regions behind that one count as well, up to `HOPS` doors away.
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
    """Rows (left, right), unique and sorted, of two relations (key, left) and (key, right): a product of matrices."""
    keys = int(max(key_left[:, 0].max(initial=-1), key_right[:, 0].max(initial=-1))) + 1
    left, right = (
        coo_array(
            (np.ones(len(rows), np.int32), (rows[:, 0], rows[:, 1])), shape=(keys, int(rows[:, 1].max(initial=-1)) + 1)
        )
        for rows in (key_left, key_right)
    )
    found = (left.tocsr().T @ right.tocsr()).tocsr()
    found.sort_indices()
    return np.stack(found.nonzero(), axis=1).astype(np.int32)
