"""NumPy arrays: .npy files of int8 (h, w), row 0 = top, -1 unknown, 0 free to 100 occupied."""

from __future__ import annotations

import io
import struct
import tokenize
import warnings
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.lib import format as npy
from numpy.typing import NDArray

from vdoor.errors import MapError
from vdoor.formats.occupancy import decided
from vdoor.formats.source import Request, check_size, check_values
from vdoor.grid import OccupancyGrid

Shape = tuple[int, ...]
HEADERS: dict[tuple[int, int], Callable[[io.BytesIO], tuple[Shape, bool, np.dtype[Any]]]] = {
    (1, 0): npy.read_array_header_1_0,
    (2, 0): npy.read_array_header_2_0,
}
# Exceptions that NumPy's header parser raises for damaged files.
DAMAGE = (ValueError, TypeError, LookupError, AttributeError, SyntaxError, EOFError, MemoryError, RecursionError,
          OverflowError, struct.error, tokenize.TokenError)  # fmt: skip


def read(request: Request) -> OccupancyGrid:
    """The grid of a .npy file, its lower left corner at (0, 0); 0.05 m per cell unless the request sets another."""
    name = request.name
    with request.naming(name):
        request.refuse_unknown_value("an array")
        cells, source = decided(decode(request.data(name), max_cells=request.max_cells), request)
        return OccupancyGrid.from_array(cells, request.resolution_or_default_m(name), source=source)


def decode(data: bytes, *, max_cells: int) -> NDArray[np.int8]:
    """The cells (h, w) of a .npy file; raises MapError if it contains anything but occupancy. Nothing is unpickled."""
    stream = io.BytesIO(data)
    shape, fortran_order, dtype = _header(stream)
    dimensions = 2
    if dtype != np.int8 or len(shape) != dimensions:
        raise MapError(f"array: wanted int8 in 2 dimensions, found {dtype} in {len(shape)}")
    if not all(type(side) is int for side in shape):  # NumPy lets True pass
        raise MapError("array: wanted a shape of whole numbers, found others")
    height, width = shape
    check_size(height, width, max_cells=max_cells)
    found = len(data) - stream.tell()
    if found < height * width:
        raise MapError(f"array: wanted {height * width} cells, found {found}")
    flat = np.frombuffer(data, np.int8, height * width, stream.tell())
    check_values("array", flat)
    return flat.reshape(shape, order="F" if fortran_order else "C")


def _header(stream: io.BytesIO) -> tuple[Shape, bool, np.dtype[Any]]:
    """The shape, whether the order is Fortran's, and the type; the stream is left at the first cell."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            return HEADERS[npy.read_magic(stream)](stream)
    except DAMAGE:
        raise MapError("array: wanted a .npy file of version 1 or 2, found something else or a damaged one") from None
