"""Images: PGM, PNG, BMP and TIFF; without a YAML they are read in trinary mode with Nav2's default thresholds."""

from __future__ import annotations

import contextlib
import io
import os
import struct
import warnings
import zlib
from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np
from numpy.typing import NDArray
from PIL import Image, UnidentifiedImageError

from vdoor.errors import MapError
from vdoor.formats import pgm
from vdoor.formats.occupancy import GreyImage, Rule, cells_from_image
from vdoor.formats.source import Request, check_size, shown
from vdoor.grid import OccupancyGrid

FORMATS = ("PNG", "BMP", "TIFF")
OPAQUE = 255
STDERR = 2
GREYISH = 16
"""Largest difference between the channels of a pixel that counts as grey."""
BAND = 1 << 20
"""Pixels whose colours are in memory at a time."""
# Exceptions that Pillow is known to raise for damaged files.
DAMAGE = (
    OSError, SyntaxError, ValueError, TypeError, LookupError, AttributeError, ArithmeticError, EOFError, MemoryError,
    RuntimeError, struct.error, zlib.error,
)  # fmt: skip


def read(request: Request) -> OccupancyGrid:
    """The grid of a plain image, its lower left corner at (0, 0); 0.05 m per cell unless the request sets another."""
    name = request.name
    with request.naming(name):
        image = decode(request.data(name), max_cells=request.max_cells)
        cells = cells_from_image(image, Rule(), request=request, name=name)
        return OccupancyGrid.from_array(cells, request.resolution_or_default_m(name), source=request.source)


def decode(data: bytes, *, max_cells: int) -> GreyImage:
    """The image in `data` as grey values (h, w); the format is recognised by content, not by file name.

    Raises MapError if it is damaged, has another format, or is larger than `max_cells`.
    """
    if pgm.is_pgm(data):
        return pgm.decode(data, max_cells=max_cells)
    with _pillow(), Image.open(io.BytesIO(data), formats=FORMATS) as image:
        check_size(image.height, image.width, max_cells=max_cells)
        with _silent_library() if image.format == "TIFF" else contextlib.nullcontext():
            image.load()
        return _grey(image)


@contextmanager
def _pillow() -> Iterator[None]:
    """Convert Pillow's exceptions to MapError, and suppress its warnings."""
    try:
        with warnings.catch_warnings(), _no_limit_of_pillow():
            warnings.simplefilter("ignore")
            yield
    except MapError:
        raise
    except UnidentifiedImageError:
        raise MapError("image: wanted PGM, PNG, BMP or TIFF, found something else") from None
    except DAMAGE as error:
        raise MapError(f"image: wanted a complete file, found a damaged one ({shown(str(error))})") from error


@contextmanager
def _silent_library() -> Iterator[None]:
    """Let what libtiff itself writes to stderr about a damaged file go nowhere; the error says it in one line."""
    try:
        kept = os.dup(STDERR)
    except OSError:  # closed: there is nothing to silence
        yield
        return
    nowhere = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, STDERR)
    try:
        yield
    finally:
        os.dup2(kept, STDERR)
        os.close(kept)
        os.close(nowhere)


@contextmanager
def _no_limit_of_pillow() -> Iterator[None]:
    """Let `max_cells`, which is compared with the size before anything is decoded, be the only limit."""
    most, Image.MAX_IMAGE_PIXELS = Image.MAX_IMAGE_PIXELS, None
    try:
        yield
    finally:
        Image.MAX_IMAGE_PIXELS = most


def _grey(image: Image.Image) -> GreyImage:
    """The grey values of a loaded image: colour as luma, 16-bit grey unchanged, palettes and transparency resolved."""
    if image.mode.startswith("I;16"):
        samples = np.asarray(image).astype(np.uint16)
        key = image.info.get("transparency")
        return GreyImage(samples=samples, maxval=65535, opaque=None if key is None else samples != key)
    if image.mode in ("I", "F"):
        raise MapError(f"image: wanted 1 to 16 bits per sample, found 32 (Pillow's mode {image.mode})")
    if image.mode in ("1", "L") and not image.has_transparency_data:
        return GreyImage(samples=np.asarray(image.convert("L")))
    return _brightness(image)


def _brightness(image: Image.Image) -> GreyImage:
    """The grey values of an image in colour or with transparency, made a band of rows at a time to save memory."""
    luma = np.empty((image.height, image.width), np.uint8)
    opaque = np.empty(luma.shape, np.bool_)
    coloured, rows = 0, max(1, BAND // image.width)
    for top in range(0, image.height, rows):
        bottom = min(top + rows, image.height)
        channels = np.asarray(image.crop((0, top, image.width, bottom)).convert("RGBA"))
        opaque[top:bottom] = channels[..., 3] == OPAQUE
        luma[top:bottom], spread = _luma(channels)
        coloured += int(np.count_nonzero(spread[opaque[top:bottom]] > GREYISH)) if spread.any() else 0
    return GreyImage(samples=luma, opaque=None if opaque.all() else opaque, coloured=coloured)


def _luma(channels: NDArray[np.uint8]) -> tuple[NDArray[np.uint8], NDArray[np.uint8]]:
    """The brightness (h, w) of pixels (h, w, 3 or more), and the largest difference between their colours.

    ITU-R 601 luma in the integer arithmetic of GraphicsMagick, with which Nav2 reads images: greys stay exact.
    """
    red, green, blue = (np.ascontiguousarray(channels[..., at]) for at in range(3))
    spread = np.maximum(np.maximum(red, green), blue) - np.minimum(np.minimum(red, green), blue)
    if not spread.any():
        return red, spread
    luma = (red.astype(np.uint32) * 306 + green.astype(np.uint32) * 601 + blue.astype(np.uint32) * 117) >> 10
    return luma.astype(np.uint8), spread
