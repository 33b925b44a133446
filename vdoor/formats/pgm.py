"""PGM images, plain (P2) and binary (P5), 8 and 16 bit, any maxval, with comments.

An own parser since Pillow rescales every maxval to 255 and clips 16 bits, which changes what raw mode reads.
"""

from __future__ import annotations

import re

import numpy as np
from numpy.typing import NDArray

from vdoor.errors import MapError
from vdoor.formats.occupancy import GreyImage
from vdoor.formats.source import check_size

COMMENT = rb"#[^\r\n]*"
GAP = rb"(?:\s|" + COMMENT + rb"[\r\n])+"
HEADER = re.compile(rb"P([25])" + GAP + GAP.join([rb"(\d{1,9})"] * 3) + rb"(?:" + COMMENT + rb")?(?:\s|\Z)")
MAX_MAXVAL = 65535
MAX_DIGITS = 5


def is_pgm(data: bytes) -> bool:
    """Whether the file begins as a PGM does."""
    return data[:2] in (b"P2", b"P5")


def decode(data: bytes, *, max_cells: int) -> GreyImage:
    """Grey image of a PGM, samples (h, w) as stored; MapError where it is damaged or too large."""
    header = HEADER.match(data)
    if header is None:
        raise MapError("PGM header: wanted width, height and largest value, found something else")
    width, height, maxval = (int(text) for text in header.groups()[1:])
    check_size(height, width, max_cells=max_cells)
    if not 1 <= maxval <= MAX_MAXVAL:
        raise MapError(f"PGM header: wanted a largest value of 1 to {MAX_MAXVAL}, found {maxval}")
    parse = _plain if header[1] == b"2" else _binary
    samples = parse(data, header.end(), count=height * width, wide=maxval > np.iinfo(np.uint8).max)
    return GreyImage(samples=samples.reshape(height, width), maxval=maxval)


def _binary(data: bytes, start: int, *, count: int, wide: bool) -> NDArray[np.uint8] | NDArray[np.uint16]:
    """`count` samples of one byte, or of two with the high one first."""
    found = (len(data) - start) // (2 if wide else 1)
    if found < count:
        raise MapError(f"PGM samples: wanted {count}, found {found}")
    if wide:
        return np.frombuffer(data, ">u2", count, start).astype(np.uint16)
    return np.frombuffer(data, np.uint8, count, start)


def _plain(data: bytes, start: int, *, count: int, wide: bool) -> NDArray[np.uint8] | NDArray[np.uint16]:
    """`count` samples written out as decimal numbers; all digits of one power of ten are added at a time."""
    body = data[start:]
    text = np.frombuffer(re.sub(COMMENT, b"", body) if b"#" in body else body, np.uint8)
    digits = text - np.uint8(ord("0"))  # wraps round: all but digits end up over 9
    is_digit = digits <= 9  # noqa: PLR2004  # the largest digit
    first = np.flatnonzero(is_digit & np.concatenate([[True], ~is_digit[:-1]]))[:count]
    last = np.flatnonzero(is_digit & np.concatenate([~is_digit[1:], [True]]))[:count]
    if len(last) < count:
        raise MapError(f"PGM samples: wanted {count}, found {len(last)}")
    lengths = last - first + 1
    odd = ~is_digit & ~np.isin(text, np.frombuffer(b" \t\n\v\f\r", np.uint8))
    if lengths.max() > MAX_DIGITS or odd[: last[-1]].any():
        raise MapError(f"PGM samples: wanted whole numbers of at most {MAX_DIGITS} digits, found something else")
    values = np.zeros(count, np.int32)
    for power in range(int(lengths.max())):
        at = lengths > power
        values[at] += digits[last[at] - power].astype(np.int32) * 10**power
    limit = np.iinfo(np.uint16 if wide else np.uint8).max
    if values.max() > limit:
        raise MapError(f"PGM samples: wanted at most {limit}, found {values.max()}")
    return values.astype(np.uint16) if wide else values.astype(np.uint8)
