"""What people change about a finished map: names, ids, rooms merged or split, doors added, removed or opened.

>>> import vdoor
>>> topology = vdoor.run(vdoor.read_map("recordings/flat.yaml"))
>>> vdoor.edited(topology, ["name 2.9,6.5 Kitchen"]).room_named("Kitchen").id
1
"""

from vdoor.editing.apply import edited

__all__ = ["edited"]
