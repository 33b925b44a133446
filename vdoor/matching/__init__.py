"""Matching a new map with an older one of the same place, so that rooms keep their ids and names.

>>> import vdoor
>>> old = vdoor.edited(vdoor.run(vdoor.read_map("recordings/flat.yaml")), ["name 2.9,6.5 Kitchen", "number 2.9,6.5 7"])
>>> new = vdoor.run(vdoor.read_map("recordings/flat.yaml"))
>>> match = vdoor.match(old, new)
>>> vdoor.edited(new, match.edits).room_named("Kitchen").id
7
"""

from __future__ import annotations

from vdoor.matching.align import Alignment, aligned
from vdoor.matching.carry import Older, carried_over
from vdoor.matching.room_matching import Kept, Match, match

__all__ = ["Alignment", "Kept", "Match", "Older", "aligned", "carried_over", "match"]
