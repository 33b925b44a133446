"""Label images as runs: all that is done on runs is what SciPy and plain loops do on cells."""

from __future__ import annotations

import numpy as np
import pytest
from masks import masks
from scipy import ndimage

from vdoor.raster import contours
from vdoor.raster.contours import follow
from vdoor.raster.runs import beside, overlaid, parts_of_mask, parts_of_runs, runs_of

EIGHT = np.ones((3, 3), np.bool_)


@pytest.mark.parametrize("connectivity", [1, 2])
def test_parts_are_those_of_scipy_in_reading_order(connectivity: int) -> None:
    for mask in masks():
        wanted, count = ndimage.label(mask, EIGHT if connectivity == 2 else None)
        found = parts_of_mask(mask, connectivity)
        image = found.image()
        assert found.most == count
        assert (found.mask() == mask).all()
        assert len(np.unique(np.stack([image, wanted]).reshape(2, -1), axis=1).T) == count + (not mask.all())
        first = [int(np.flatnonzero(image == number)[0]) for number in range(1, count + 1)]
        assert first == sorted(first) == found.first_cells(count).tolist()
        assert found.cells(count).tolist() == np.bincount(image[mask], minlength=count + 1)[1:].tolist()
        boxes = [[rows.start, cols.start, rows.stop, cols.stop] for rows, cols in ndimage.find_objects(image)]
        assert found.boxes(count).tolist() == boxes


def test_parts_of_an_image_have_one_label_each() -> None:
    image = np.random.default_rng(1).integers(0, 3, (13, 17)).astype(np.int32)
    wanted = sum(ndimage.label(image == label)[1] for label in (1, 2))
    part = parts_of_runs(runs_of(image)).image()
    assert part.max() == wanted
    assert len(np.unique(np.stack([part, image]).reshape(2, -1), axis=1).T) == wanted + 1
    assert (runs_of(image).image() == image).all()


def test_labels_of_cells_and_windows_are_those_of_the_image() -> None:
    for mask in masks():
        found = parts_of_mask(mask)
        image, (height, width) = found.image(), mask.shape
        assert (found.at(np.arange(-2, mask.size + 2)) == np.pad(image.ravel(), 2)).all()
        assert (found.flat() == np.flatnonzero(mask)).all()
        box = slice(height // 3, height), slice(width // 4, width - width // 4)
        assert (found.inside(box).image() == image[box]).all()
        odd = np.arange(found.most + 1) % 2 == 1
        assert (found.chosen(odd).image() == np.where(odd[image], image, 0)).all()


def test_neighbours_and_overlaid_cells_are_those_of_the_image() -> None:
    for mask in masks():
        runs = parts_of_mask(mask)
        image, cell = np.pad(runs.image(), 1), np.arange(mask.size)
        label, own = beside(runs, cell)
        row, col = np.divmod(own, mask.shape[1])
        around = np.stack([image[row + down, col + right] for down, right in np.ndindex(3, 3)])
        assert (around == label).any(axis=0).all()
        neighbours = ndimage.convolve((image > 0).astype(int), EIGHT.astype(int), mode="constant")[1:-1, 1:-1] - mask
        assert (np.bincount(own, minlength=mask.size) == neighbours.ravel()).all()
        found = overlaid(runs, cell[::3], cell[::3] + 100, cell)
        assert (found == np.where(cell % 3 == 0, cell + 100, runs.image().ravel())).all()


@pytest.mark.parametrize("rows", [1, 2, 7])
def test_contours_found_in_bands_are_those_of_the_whole_raster(rows: int, monkeypatch: pytest.MonkeyPatch) -> None:
    for mask in masks():
        for raster, image in ((mask, mask), (parts_of_mask(mask), parts_of_mask(mask).image())):
            for cross_corners in (False, True):
                whole = follow(image, cross_corners=cross_corners)
                with monkeypatch.context() as patch:
                    patch.setattr(contours, "ROWS", rows)
                    banded = follow(raster, cross_corners=cross_corners)
                assert all((value == getattr(banded, name)).all() for name, value in vars(whole).items())
