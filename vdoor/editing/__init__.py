"""Edits of a finished map: naming, numbering, merging and splitting rooms; adding, removing and opening doors.

>>> import vdoor
>>> topology = vdoor.run(vdoor.read_map("recordings/flat.yaml"))
>>> vdoor.edited(topology, ["name 2.9,6.5 Kitchen"]).room_named("Kitchen").id
1
"""

from vdoor.editing.apply import edited

__all__ = ["edited"]
