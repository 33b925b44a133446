"""Edits of a finished map: naming, numbering, merging and splitting rooms; adding, removing and opening doors.

>>> import vdoor
>>> topology = vdoor.run(vdoor.read_map("recordings/flat.yaml"))
>>> vdoor.edited(topology, ["name 2.9,6.5 Kitchen"]).room_named("Kitchen").id
1
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from vdoor.lazy import on_first_use

if TYPE_CHECKING:
    from vdoor.editing.apply import edited

__all__ = ["edited"]

__getattr__ = on_first_use(__name__, {"apply": ("edited",)})
