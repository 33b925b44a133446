"""Pictures by matplotlib, which is an extra: without a screen, and equal bytes for equal drawings."""

from __future__ import annotations

import importlib.util
import io
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

from vdoor.errors import VdoorError

if TYPE_CHECKING:
    from matplotlib.figure import Figure

DOTS_PER_INCH = 100
LOOK: dict[str, Any] = {
    "font.family": "DejaVu Sans",  # comes with matplotlib, so that the machine's fonts do not matter
    "font.size": 9,
    "axes.titlesize": 9,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.linewidth": 0.6,
    "legend.fontsize": 8,
    "legend.frameon": False,
}


def require_matplotlib() -> None:
    """VdoorError that says how to install it, where it is missing."""
    if importlib.util.find_spec("matplotlib") is None:
        raise VdoorError(
            "pictures: wanted matplotlib, found none; in a checkout, `pip install -e '.[plots]'` installs it"
        )


@contextmanager
def drawing(width_in: float, height_in: float) -> Iterator[Figure]:
    """An empty picture; within the block all has the same look, whatever the user's own settings of matplotlib are."""
    require_matplotlib()
    from matplotlib import style  # noqa: PLC0415
    from matplotlib.backends.backend_agg import FigureCanvasAgg  # noqa: PLC0415
    from matplotlib.figure import Figure  # noqa: PLC0415

    with style.context(["default", LOOK]):
        figure = Figure(figsize=(width_in, height_in), dpi=DOTS_PER_INCH, layout="constrained")
        FigureCanvasAgg(figure)
        yield figure


def to_png(figure: Figure) -> bytes:
    """The picture as a PNG of 256 colours that says nothing of program or date."""
    from PIL import Image  # noqa: PLC0415

    buffer = io.BytesIO()
    figure.savefig(buffer, format="png", metadata={"Software": None})
    image = Image.open(buffer).convert("RGB").quantize(256, dither=Image.Dither.NONE)
    small = io.BytesIO()
    image.save(small, format="png", optimize=True)
    return small.getvalue()
