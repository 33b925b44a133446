"""Label images: reading and checking them, selecting labels that count as rooms, growing labels into free cells."""

from __future__ import annotations

import json
import warnings
from pathlib import Path
from typing import Any

import numpy as np
import scipy
from numpy.typing import NDArray

from vdoor.errors import VdoorError
from vdoor.files import read_regular
from vdoor.formats import MAX_CELLS, images
from vdoor.formats.occupancy import GreyImage

LABEL_SUFFIXES = (".png", ".npy")


MIN_ROOM_M2 = 0.25
"""Rooms of at most this area are ignored: 100 cells of 5 cm."""
MOST_BYTES = 1 << 31
"""Largest size of a file."""
MOST_ROOMS = 5_000
"""All pairs of rooms are compared; an image with more is noise."""
WHITE_FROM = 251
"""Lowest grey value of a cell in a room drawn as a white blob."""
Labels = NDArray[np.int32]


def read_labels(path: Path) -> NDArray[Any]:
    """The labels (h, w), 0 = no room, of a 16-bit PNG or a .npy; raises `VdoorError` for anything else."""
    if path.suffix.lower() == ".npy":
        return _array(path)
    image = read_image(path)
    if image.samples.dtype != np.uint16:
        raise VdoorError(f"labels: wanted a 16-bit grey PNG, found an 8-bit one: {path}")
    return image.samples


def read_true_rooms(path: Path) -> NDArray[Any]:
    """The labels (h, w) like `read_labels`; in 8-bit images, white blobs are the rooms."""
    if path.suffix.lower() == ".npy":
        return _array(path)
    image = read_image(path)
    return image.samples if image.samples.dtype == np.uint16 else labels_of_blobs(image.greys())


def read_image(path: Path) -> GreyImage:
    """An image as grey values, ignoring alpha; raises `VdoorError` if it is not an image."""
    try:
        return images.decode(read_bytes(path), max_cells=MAX_CELLS)
    except VdoorError as error:
        raise error if str(path) in str(error) else VdoorError(f"{error}: {path}") from error


def read_bytes(path: Path) -> bytes:
    """The content of a regular file; raises `VdoorError` if it cannot be read or is too large."""
    return read_regular(path, "a label image, array or table", limit=MOST_BYTES)


def read_table(path: Path) -> dict[str, Any]:
    """The object in a JSON file; raises `VdoorError` if there is none."""
    content = read_bytes(path)
    try:
        table = json.loads(content)
    except (ValueError, RecursionError) as error:
        raise VdoorError(f"JSON: wanted a complete file, found a damaged one: {path}") from error
    if not isinstance(table, dict):
        raise VdoorError(f"JSON: wanted an object, found a {type(table).__name__}: {path}")
    return table


def _array(path: Path) -> NDArray[Any]:
    """The integers (h, w) in a .npy file; nothing is unpickled, and memory is bounded by the file's size."""
    no_labels = f"labels: wanted a .npy file of integers in 2 dimensions, found {{}}: {path}"
    if not path.is_file():
        raise VdoorError(f"file: wanted a .npy, found {'a folder' if path.is_dir() else 'none'}: {path}")
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            array = np.load(path, mmap_mode="r", allow_pickle=False)
    except Exception as error:  # damaged headers raise whatever Python's parser does
        raise VdoorError(no_labels.format("a different or damaged file")) from error
    dimensions = 2
    if not isinstance(array, np.ndarray) or array.dtype.kind not in "iub" or array.ndim != dimensions:
        raise VdoorError(no_labels.format("other content"))
    return np.array(array)


def rooms_of(labels: NDArray[Any], resolution_m: float) -> Labels:
    """Rooms 1, 2, ... (h, w) in the order of their labels, without rooms that are too small; 0 stays no room.

    Raises `VdoorError` if more rooms are left than can be compared.
    """
    values, place, cells = np.unique(labels, return_inverse=True, return_counts=True)
    # Rounded: 0.25 m2 are 100 cells of 5 cm, not 99.99999999999999.
    counts = (values != 0) & (cells > round(MIN_ROOM_M2 / resolution_m**2, 6))
    rooms = int(counts.sum())
    if rooms > MOST_ROOMS:
        raise VdoorError(f"labels: wanted at most {MOST_ROOMS} rooms, found {rooms}")
    numbers = np.where(counts, np.cumsum(counts), 0).astype(np.int32)
    return numbers[place].reshape(labels.shape)


def labels_of_blobs(greys: NDArray[np.uint8]) -> Labels:
    """The labels (h, w) of rooms drawn white and separated by darker lines; diagonal neighbours are one room."""
    labels, _ = scipy.ndimage.label(greys >= WHITE_FROM, structure=np.ones((3, 3)))
    return np.asarray(labels, np.int32)


def flooded(labels: Labels, free: NDArray[np.bool_], steps: int) -> Labels:
    """The labels (h, w) grown `steps` times into unlabelled free cells among the four neighbours.

    If several labels reach a cell in the same step, the largest wins.
    """
    spread = np.pad(labels, 1)
    width = spread.shape[1]
    flat = spread.ravel()
    empty = np.flatnonzero(np.pad(free, 1) & (spread == 0))
    for _ in range(steps):
        arriving = np.max([flat[empty + step] for step in (-width, -1, 1, width)], axis=0, initial=0)
        flat[empty] = arriving
        empty = empty[arriving == 0]
    return spread[1:-1, 1:-1]
