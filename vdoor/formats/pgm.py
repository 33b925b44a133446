"""PGM images, plain (P2) and binary (P5), 8 and 16 bit, any maxval, with comments.

Parsed here because Pillow rescales all maxvals to 255 and clips 16 bits, which changes the values in raw mode.
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
    """Whether the file begins like a PGM."""
    return data[:2] in (b"P2", b"P5")


def decode(data: bytes, *, max_cells: int) -> GreyImage:
    """The grey image in a PGM, samples (h, w) as stored; raises MapError if it is damaged or too large."""
    header = HEADER.match(data)
    if header is None:
        raise MapError("PGM header: wanted width, height and largest value, found something else")
    width, height, maxval = (int(text) for text in header.groups()[1:])
    check_size(height, width, max_cells=max_cells)
    if not 1 <= maxval <= MAX_MAXVAL:
        raise MapError(f"PGM header: wanted a largest value of 1 to {MAX_MAXVAL}, found {maxval}")
    wide = maxval > np.iinfo(np.uint8).max
    if header[1] == b"2":
        samples, remark = _plain(data, header.end(), count=height * width, wide=wide), ""
    else:
        begin, remark = _start(data, header.end(), size=height * width * (2 if wide else 1))
        samples = _binary(data, begin, count=height * width, wide=wide)
    return GreyImage(samples=samples.reshape(height, width), maxval=maxval, remark=remark)


def _start(data: bytes, end: int, *, size: int) -> tuple[int, str]:
    """The first byte of the samples behind a header that ends at `end`, and what is odd about it.

    One character ends the header. Two, as Windows ends lines, would shift all samples by one and leave one byte over.
    """
    left = len(data) - end - size
    if left == 1 and data[end - 1 : end + 1] == b"\r\n":
        return end + 1, "PGM: the header's last line ends in CR LF, reading the samples from behind both"
    odd = left > 0 and data[-left:].strip() != b""
    return end, f"PGM: {left} bytes left over behind the samples" if odd else ""


def _binary(data: bytes, start: int, *, count: int, wide: bool) -> NDArray[np.uint8] | NDArray[np.uint16]:
    """`count` samples of one byte, or of two bytes, high byte first."""
    found = (len(data) - start) // (2 if wide else 1)
    if found < count:
        raise MapError(f"PGM samples: wanted {count}, found {found}")
    if wide:
        return np.frombuffer(data, ">u2", count, start).astype(np.uint16)
    return np.frombuffer(data, np.uint8, count, start)


def _plain(data: bytes, start: int, *, count: int, wide: bool) -> NDArray[np.uint8] | NDArray[np.uint16]:
    """`count` samples written as decimal numbers, parsed for all samples one power of ten at a time."""
    body = data[start:]
    text = np.frombuffer(re.sub(COMMENT, b"", body) if b"#" in body else body, np.uint8)
    digits = text - np.uint8(ord("0"))  # wraps around: everything but digits ends up above 9
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
