"""Images: PGM, PNG, BMP and TIFF; on their own they are read in trinary mode with Nav2's default thresholds."""

from __future__ import annotations

import io
import struct
import warnings
import zlib
from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np
from PIL import Image, UnidentifiedImageError

from vdoor.errors import MapError
from vdoor.formats import pgm
from vdoor.formats.occupancy import GreyImage, Rule, cells_from_image
from vdoor.formats.source import Request, check_size, shown
from vdoor.grid import OccupancyGrid

FORMATS = ("PNG", "BMP", "TIFF")
OPAQUE = 255
# What Pillow is known to raise on damaged files.
DAMAGE = (
    OSError, SyntaxError, ValueError, TypeError, LookupError, AttributeError, ArithmeticError, EOFError, MemoryError,
    RuntimeError, struct.error, zlib.error, Image.DecompressionBombError,
)  # fmt: skip


def read(request: Request) -> OccupancyGrid:
    """Grid of a plain image, lower left corner at (0, 0), 0.05 m a cell unless the request says otherwise."""
    name = request.name
    with request.naming(name):
        image = decode(request.data(name), max_cells=request.max_cells)
        cells = cells_from_image(image, Rule(), request=request, name=name)
        return OccupancyGrid.from_array(cells, request.resolution_or_default_m(name), source=request.source)


def decode(data: bytes, *, max_cells: int) -> GreyImage:
    """Image in `data` as grey (h, w); the format is told by the content, whatever the file is called.

    MapError where it is damaged, of another format, or larger than `max_cells`. Pillow's own limit of some 179
    million pixels stays in force for all formats but PGM.
    """
    if pgm.is_pgm(data):
        return pgm.decode(data, max_cells=max_cells)
    with _pillow(), Image.open(io.BytesIO(data), formats=FORMATS) as image:
        check_size(image.height, image.width, max_cells=max_cells)
        image.load()
        return _grey(image)


@contextmanager
def _pillow() -> Iterator[None]:
    """Turn what Pillow raises into MapError and keep its warnings from the user."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            yield
    except MapError:
        raise
    except UnidentifiedImageError:
        raise MapError("image: wanted PGM, PNG, BMP or TIFF, found something else") from None
    except Image.DecompressionBombError as error:
        raise MapError(f"image: wanted a size that Pillow accepts, found more ({shown(str(error))})") from error
    except DAMAGE as error:
        raise MapError(f"image: wanted a whole file, found a damaged one ({shown(str(error))})") from error


def _grey(image: Image.Image) -> GreyImage:
    """Grey of a loaded image: colour by luma, 16 bit grey kept, palettes and transparent keys looked up."""
    if image.mode.startswith("I;16"):
        samples = np.asarray(image).astype(np.uint16)
        key = image.info.get("transparency")
        return GreyImage(samples=samples, maxval=65535, opaque=None if key is None else samples != key)
    if image.mode in ("I", "F"):
        raise MapError(f"image: wanted 1 to 16 bits a sample, found Pillow's mode {image.mode} of 32")
    if image.mode in ("1", "L") and not image.has_transparency_data:
        return GreyImage(samples=np.asarray(image.convert("L")))
    channels = np.asarray(image.convert("RGBA"))
    # The luma of ITU-R 601 in GraphicsMagick's whole numbers, which Nav2 reads images with: greys stay exact.
    luma = channels[..., :3].astype(np.uint32) @ np.array([306, 601, 117], np.uint32) >> 10
    opaque = channels[..., 3] == OPAQUE
    return GreyImage(samples=luma.astype(np.uint8), opaque=None if opaque.all() else opaque)
