"""Morphology and components by OpenCV give what SciPy gives, to the last bit."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy import ndimage

from vdoor.raster.morphology import (
    components_of,
    covered,
    dilated,
    distances,
    eroded,
    exact,
    greatest,
    labelled,
    opened,
    room_for,
    square,
)

Mask = NDArray[np.bool_]
EIGHT = np.ones((3, 3), np.bool_)


def masks() -> list[Mask]:
    rng = np.random.default_rng(3)
    shapes = [(1, 1), (1, 9), (9, 1), (17, 23), (40, 31)]
    found = [rng.random(shape) < share for shape in shapes for share in (0.3, 0.6, 0.9)]
    return [*found, np.zeros((4, 5), np.bool_), np.ones((4, 5), np.bool_), found[-1].T]


@pytest.mark.parametrize("connectivity", [1, 2])
def test_components_are_those_of_scipy_in_reading_order(connectivity: int) -> None:
    for mask in masks():
        wanted, count = ndimage.label(mask, EIGHT if connectivity == 2 else None)
        found = components_of(mask, connectivity)
        assert (found.label == labelled(mask, connectivity)).all()
        assert found.count == count
        first = [int(np.flatnonzero(found.label == number)[0]) for number in range(1, count + 1)]
        assert first == sorted(first)
        assert len(np.unique(np.stack([found.label, wanted]).reshape(2, -1), axis=1).T) == count + (not mask.all())
        assert found.cells.tolist() == [0, *np.bincount(found.label[mask], minlength=count + 1)[1:].tolist()]
        boxes = ndimage.find_objects(found.label)
        assert [found.box(number) for number in range(1, count + 1)] == boxes
        assert found.sides[1:].tolist() == [max(side.stop - side.start for side in box) for box in boxes]


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


@pytest.mark.parametrize("most", [200, 60_000, 1_000_000])
def test_the_greatest_value_is_exact_whatever_its_size(most: int) -> None:
    value = np.random.default_rng(1).integers(0, most, (20, 30)).astype(np.int32)
    value[3, 4] = most
    element = np.array([[1, 1, 0], [0, 1, 1], [0, 0, 1]], np.bool_)
    wanted = ndimage.grey_dilation(value, footprint=element, mode="constant", cval=0)
    assert (greatest(value, element, most) == wanted).all()
    assert (greatest(value, np.zeros((3, 3), np.bool_), most) == 0).all()


def test_distances_are_those_of_scipy_to_the_last_bit() -> None:
    wide = np.ones((150, 1900), np.bool_)
    wide[70, 3] = False
    for mask in (*(mask for mask in masks() if not mask.all()), wide):
        found = exact(distances(mask))
        assert (found == ndimage.distance_transform_edt(mask)).all()
