"""Files that say where rooms or doors are, checked as they are read."""

from __future__ import annotations

import json
import warnings
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from vdoor.errors import VdoorError
from vdoor.evaluate.label_images import labels_of_blobs
from vdoor.formats import MAX_CELLS, images
from vdoor.formats.occupancy import GreyImage

LABEL_SUFFIXES = (".png", ".npy")


def read_labels(path: Path) -> NDArray[Any]:
    """Whole numbers (h, w), 0 = no room, of a PNG of 16 bits or a .npy; `VdoorError` where it is neither."""
    if path.suffix.lower() == ".npy":
        return _array(path)
    image = read_image(path)
    if image.samples.dtype != np.uint16:
        raise VdoorError(f"labels: wanted a PNG of 16 bits grey, found one of 8: {path}")
    return image.samples


def read_true_rooms(path: Path) -> NDArray[Any]:
    """Labels as `read_labels` gives them; images of 8 bits are taken as rooms drawn white."""
    if path.suffix.lower() == ".npy":
        return _array(path)
    image = read_image(path)
    return image.samples if image.samples.dtype == np.uint16 else labels_of_blobs(image.greys())


def read_image(path: Path) -> GreyImage:
    """An image as grey, alpha left aside; `VdoorError` where it is none."""
    try:
        return images.decode(read_bytes(path), max_cells=MAX_CELLS)
    except VdoorError as error:
        raise error if str(path) in str(error) else VdoorError(f"{error}: {path}") from error


def read_bytes(path: Path) -> bytes:
    """All of a file; `VdoorError` where it cannot be read."""
    try:
        if path.exists() and not path.is_file():
            raise VdoorError(f"file: wanted a regular one, found something else: {path}")
        return path.read_bytes()
    except (OSError, ValueError) as error:
        if isinstance(error, VdoorError):
            raise
        reason = getattr(error, "strerror", None) or str(error)
        raise VdoorError(f"file: cannot be read ({reason}): {path}") from error


def read_table(path: Path) -> dict[str, Any]:
    """The object in a JSON file; `VdoorError` where there is none."""
    try:
        table = json.loads(read_bytes(path))
    except (UnicodeDecodeError, json.JSONDecodeError, RecursionError) as error:
        raise VdoorError(f"JSON: wanted a whole file, found a damaged one: {path}") from error
    if not isinstance(table, dict):
        raise VdoorError(f"JSON: wanted an object, found a {type(table).__name__}: {path}")
    return table


def _array(path: Path) -> NDArray[Any]:
    """Whole numbers (h, w) of a .npy; nothing is unpickled, and nothing read beyond the file's own size."""
    no_labels = f"labels: wanted a .npy of whole numbers in 2 dimensions, found {{}}: {path}"
    if not path.is_file():
        raise VdoorError(f"file: wanted a .npy, found {'a folder' if path.is_dir() else 'none'}: {path}")
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            array = np.load(path, mmap_mode="r", allow_pickle=False)
    except Exception as error:  # damaged headers raise whatever Python's parser does
        raise VdoorError(no_labels.format("another or a damaged file")) from error
    dimensions = 2
    if not isinstance(array, np.ndarray) or array.dtype.kind not in "iub" or array.ndim != dimensions:
        raise VdoorError(no_labels.format("other contents"))
    return np.array(array)
