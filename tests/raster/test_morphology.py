"""Morphology and components by OpenCV give what SciPy gives, to the last bit."""

from __future__ import annotations

import numpy as np
import pytest
from masks import masks
from scipy import ndimage

from vdoor.raster.morphology import (
    covered,
    dilated,
    distances,
    eroded,
    exact,
    opened,
    room_for,
    square,
)


@pytest.mark.parametrize("outside", [False, True])
def test_openings_are_those_of_scipy_for_sides_of_either_parity(outside: bool) -> None:
    for mask in masks():
        for element in (square(1), square(2), square(3), square(4)[:1], np.tri(3, dtype=np.bool_)):
            room = ndimage.binary_erosion(mask, element, border_value=outside)
            assert (room_for(mask, element, outside=outside) == room).all()
            assert (covered(room, element) == ndimage.binary_dilation(room, element)).all()
            assert (opened(mask, element, outside=outside) == ndimage.binary_dilation(room, element)).all()


def test_neighbours_are_those_of_scipy() -> None:
    for mask in masks():
        assert (eroded(mask) == ndimage.binary_erosion(mask)).all()
        assert (dilated(mask) == ndimage.binary_dilation(mask)).all()


def test_distances_are_those_of_scipy_to_the_last_bit() -> None:
    wide = np.ones((150, 1900), np.bool_)
    wide[70, 3] = False
    for mask in (*(mask for mask in masks() if not mask.all()), wide):
        found = exact(distances(mask))
        assert (found == ndimage.distance_transform_edt(mask)).all()
