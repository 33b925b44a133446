"""Report: one self-contained web page, to be opened from a file without a network."""

from __future__ import annotations

from vdoor.errors import printable
from vdoor.export.geometry import refuse_not_finite
from vdoor.export.report.data import page_data
from vdoor.export.report.document import document
from vdoor.grid import Annotations
from vdoor.history.provenance import Provenance
from vdoor.topology import TopologicalMap

__all__ = ["Provenance", "to_report"]


def to_report(
    topology: TopologicalMap, provenance: Provenance | None = None, annotations: Annotations | None = None
) -> str:
    """HTML: the map with a switch for each stage, tables of rooms and doors, cost curve, settings.

    Without provenance only rooms and doors are shown; without `annotations`, those of a recorded map file. Numbers are
    rounded for reading; the other formats have them in full. Equal runs give equal pages. Raises `VdoorError` if
    records contain values that cannot be drawn.
    """
    refuse_not_finite(topology)
    return document(title_of(provenance), page_data(topology, provenance, annotations))


def title_of(provenance: Provenance | None) -> str:
    """The title of the page: the name of the map."""
    return printable(provenance.name if provenance else "map")
