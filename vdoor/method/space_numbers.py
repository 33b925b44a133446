"""The numbers of spaces: which parts of the room for a robot cover each free cell.

Most cells are covered by the largest part nearby only. So parts are looked up by run, and cell by cell only near the
smaller ones.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from vdoor.raster.morphology import covered, steps_to_middle
from vdoor.raster.runs import Runs, neighbours, overlaid, parts_of_mask

Ints = NDArray[np.int32]
Cells = NDArray[np.int64]
Mask = NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class SpaceNumbers:
    """The number of the part that covers each cell, where it is only one."""

    mask: Mask
    """Cells (h, w) that one part covers."""
    reached: Runs
    """The connected parts of the cells that any part covers, labelled with the largest of these."""
    cell: Cells
    """Cells (k,) near smaller parts, as sorted flat indices."""
    number: Ints
    """The part that covers each of them; 0 if several do."""

    @classmethod
    def of(cls, room: Mask, element: Mask) -> SpaceNumbers:
        """The numbers for where an element fits; see `room_for`."""
        parts, mask = parts_of_mask(room), covered(room, element)
        reached = parts_of_mask(mask)
        largest = largest_in(reached, parts)
        smaller = np.append(False, np.ones(parts.most, np.bool_))
        smaller[largest] = False
        cell = np.flatnonzero(covered(parts.chosen(smaller).mask(), element))
        number = only_one(parts, element, cell)
        mask.reshape(-1)[cell[number == 0]] = False
        return cls(mask, reached.labelled(largest[reached.label]), cell, number)

    def at(self, cell: Cells) -> Ints:
        """The numbers (k,) at cells, 0 where no part or several cover one."""
        return overlaid(self.reached, self.cell, self.number, cell)

    def gap(self) -> Mask:
        """The cells (h, w) that several parts cover, and those beside a cell of another part."""
        found = np.zeros_like(self.mask)
        flat = found.reshape(-1)
        flat[self.cell[self.number == 0]] = True
        own, number = self.cell[self.number > 0], self.number[self.number > 0]
        near, source = neighbours(own, found.shape)
        other = self.at(near)
        differs = (other > 0) & (other != number[source])
        flat[own[source[differs]]] = True
        flat[near[differs]] = True
        return found


def largest_in(reached: Runs, parts: Runs) -> Ints:
    """The largest of the `parts` in each connected part (count + 1,) of the cells that these cover."""
    own = reached.at(parts.first_cells(parts.most))
    order = np.argsort(parts.cells(parts.most), kind="stable")
    found = np.zeros(reached.most + 1, np.int32)
    found[own[order]] = order + 1
    return found


def only_one(parts: Runs, element: Mask, cell: Cells) -> Ints:
    """The part (k,) of which elements cover each cell, given by flat index; 0 if several do."""
    least, most = np.full(len(cell), parts.most + 1, np.int32), np.zeros(len(cell), np.int32)
    for step in steps_to_middle(element, parts.shape[1]).tolist():
        found = parts.at(cell + step)
        np.maximum(most, found, out=most)
        np.minimum(least, found, out=least, where=found > 0)
    return np.where(least == most, most, 0).astype(np.int32)
