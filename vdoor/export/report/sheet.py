"""Layers of the report: pictures and shapes, in cells of the map from its upper left corner."""

from __future__ import annotations

import base64
import io
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
import skimage
from numpy.typing import NDArray
from PIL import Image

from vdoor.frame import Frame
from vdoor.viz.rerun import style

Floats = NDArray[np.float64]
Key = Sequence[tuple[str, str]]
"""Legend: pairs of colour and text."""
LARGEST_SIDE_PX = 8192
"""Larger pictures are reduced."""
MOST_TIPS = 4000
"""Maximum number of shapes with tips in a group of one colour; larger groups are drawn without tips."""
COLOURS = 256


@dataclass
class Layer:
    """One switch of the page and its content: a picture below the rooms, shapes above them."""

    id: str
    name: str
    on: bool = False
    picture: dict[str, Any] | None = None
    shapes: list[dict[str, Any]] = field(default_factory=list)
    key: list[tuple[str, str]] = field(default_factory=list)
    note: str = ""

    def add_lines(
        self,
        paths: Sequence[str],
        colour: str,
        word: str,
        *,
        tips: Sequence[str] = (),
        doors: Sequence[int] = (),
        wide_px: float = 1.5,
    ) -> None:
        """Lines of one colour, each with its tip for the pointer, unless there are too many.

        `doors` are the numbers of the virtual doors that the lines are, if they are any.
        """
        if not paths:
            return
        self.key.append((colour, word))
        style_of_line = {"colour": colour, "wide": wide_px}
        if tips and len(paths) <= MOST_TIPS:
            lines = [style_of_line | {"d": path, "tip": tip} for path, tip in zip(paths, tips, strict=True)]
            self.shapes += [line | {"door": door} for line, door in zip(lines, doors, strict=True)] if doors else lines
        else:
            self.shapes.append(style_of_line | {"d": "".join(paths)})

    def add_dots(self, points: Floats, colour: str, word: str, *, tips: Sequence[str] = (), wide_px: float = 5) -> None:
        """Dots at points (k, 2) as x, y."""
        paths = [f"M{place}h0" for place in _places(points)]
        self.add_lines(paths, colour, word, tips=tips, wide_px=wide_px)


@dataclass(frozen=True)
class Sheet:
    """Drawing surface in cells of the map, x right and y down."""

    frame: Frame

    def points(self, cells: NDArray[Any], frame: Frame) -> Floats:
        """Cells (k, 2), as row, col of any frame, as x, y on the sheet; integers are cell centres."""
        return self.world_points(frame.world_from_cell(cells))

    def world_points(self, points_m: NDArray[Any]) -> Floats:
        """Points (k, 2) of the map frame as x, y on the sheet."""
        return self.frame.cell_from_world(points_m)[:, ::-1] + 0.5

    def segments(self, start: NDArray[Any], end: NDArray[Any], frame: Frame) -> list[str]:
        """A path for each segment between cells (k, 2)."""
        ends = zip(_places(self.points(start, frame)), _places(self.points(end, frame)), strict=True)
        return [f"M{one}L{other}" for one, other in ends]

    def picture(self, raster: NDArray[Any], colours: Mapping[int, Sequence[int]], frame: Frame) -> dict[str, Any]:
        """A raster (h, w) of codes as a picture with its position; codes without a colour are transparent.

        A large raster is reduced: each pixel shows the highest code of its block of cells.
        """
        by = -(-max(raster.shape) // LARGEST_SIDE_PX)
        codes = skimage.measure.block_reduce(raster, by, np.max) if by > 1 else raster  # type: ignore[no-untyped-call]  # has no types
        whole = np.array([[-0.5, -0.5], [codes.shape[0] * by - 0.5, codes.shape[1] * by - 0.5]])
        (left, top), (right, bottom) = self.points(whole, frame).round(6).tolist()
        place = {"x": left, "y": top, "width": right - left, "height": bottom - top}
        return place | {"href": data_uri(codes.astype(np.uint8), colours)}


def polygon(rings: Iterable[Floats]) -> str:
    """SVG path of closed rings, each of points (k, 2) as x, y."""
    return "".join(f"M{'L'.join(_places(_turns(ring)))}Z" for ring in rings if len(ring))


def polyline(points: Floats) -> str:
    """SVG path along points (k, 2) as x, y."""
    return f"M{'L'.join(_places(points))}"


def room_codes(labels: NDArray[np.int32]) -> tuple[NDArray[np.int32], dict[int, Sequence[int]]]:
    """Labels as codes of one byte, with 0 unchanged, and a colour for each."""
    codes = np.where(labels > 0, (labels - 1) % (COLOURS - 1) + 1, 0)
    return codes, {code: style.room(code) for code in range(1, min(int(labels.max(initial=0)), COLOURS - 1) + 1)}


def data_uri(codes: NDArray[np.uint8], colours: Mapping[int, Sequence[int]]) -> str:
    """A PNG (h, w) with a palette, as a data URI."""
    palette = np.zeros((COLOURS, 4), np.uint8)
    for code, colour in colours.items():
        palette[code] = (*colour, 255)[:4]
    image = Image.fromarray(codes)
    image.putpalette(palette[:, :3].tobytes())
    buffer = io.BytesIO()
    image.save(buffer, format="png", transparency=palette[:, 3].tobytes())
    return f"data:image/png;base64,{base64.b64encode(buffer.getvalue()).decode()}"


def colour_text(colour: Sequence[int]) -> str:
    """A colour in CSS notation, without its opacity."""
    return "#{:02x}{:02x}{:02x}".format(*colour[:3])


def _turns(ring: Floats) -> Floats:
    """Points of a closed ring at which it turns; all points if it never turns."""
    ring = ring[:-1] if len(ring) > 1 and (ring[0] == ring[-1]).all() else ring
    along, onward = ring - np.roll(ring, 1, axis=0), np.roll(ring, -1, axis=0) - ring
    turned = np.abs(along[:, 0] * onward[:, 1] - along[:, 1] * onward[:, 0]) > 1e-9  # noqa: PLR2004  # square cells
    turned |= (along * onward).sum(axis=1) < 0
    return ring[turned] if turned.any() else ring


def _places(points: Floats) -> Iterator[str]:
    return (f"{x:.7g} {y:.7g}" for x, y in points.round(3).tolist())
