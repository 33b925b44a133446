"""Map formats: one module per format, and the list of them in `reading`."""

from __future__ import annotations

from typing import TYPE_CHECKING

from vdoor.lazy import on_first_use

if TYPE_CHECKING:
    from vdoor.formats.reading import (
        READERS,
        Reader,
        described,
        read_annotations,
        read_map,
        read_piped,
        read_source,
        reader_of,
    )
    from vdoor.formats.source import MAX_CELLS

__all__ = [
    "MAX_CELLS",
    "READERS",
    "Reader",
    "described",
    "read_annotations",
    "read_map",
    "read_piped",
    "read_source",
    "reader_of",
]

__getattr__ = on_first_use(
    __name__,
    {
        "reading": (
            "READERS",
            "Reader",
            "described",
            "read_annotations",
            "read_map",
            "read_piped",
            "read_source",
            "reader_of",
        ),
        "source": ("MAX_CELLS",),
    },
)
