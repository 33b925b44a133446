"""The paper's evidence from one apartment and one graph, which takes ten seconds to gather and is gathered once."""

from __future__ import annotations

import functools

from vdoor.paper.claims import Evidence, Size, gather_evidence


@functools.cache
def small_evidence() -> Evidence:
    """The evidence; it cannot be changed."""
    return gather_evidence(Size(apartments=1, graphs=1))
