"""Where to go, as people write it: a room by its id or name, or a place."""

from __future__ import annotations

from dataclasses import dataclass

from vdoor.editing.lookup import find_room
from vdoor.editing.places import Point, parse_place
from vdoor.errors import SettingError
from vdoor.navigate.places import Standing, standing_at
from vdoor.navigate.routes import Cell, Routes
from vdoor.topology import TopologicalMap


@dataclass(frozen=True)
class Target:
    """A room, or a place."""

    text: str
    """As it was written."""
    room: int = 0
    """Id of the room; 0 for a place."""
    place_m: Point | None = None

    @classmethod
    def of(cls, topology: TopologicalMap, text: str, *, what: str) -> Target:
        """The target of a text; raises `SettingError`, which begins with `what`, if the map has no such room."""
        if "," in text and text not in topology.name:
            return cls(text, place_m=parse_place(text, what=what, wanted="a room's id, its name or X,Y"))
        return cls(text, room=find_room(topology, text, what=what).room.id)

    def standing(self, routes: Routes, *, what: str) -> Standing | None:
        """Where the robot stands there; None for a room that it does not fit into.

        Raises `SettingError`, which begins with `what`, for a place that is too far from where it fits, or in no room.
        """
        if self.place_m is None:
            return routes.standing[self.room]
        found = standing_at(routes.space, self.place_m, what=what)
        if not routes.topology.labels[found.cell]:
            raise SettingError(f"{what}: wanted a place in a room, found none at {self.text}")
        return found

    def cell(self, routes: Routes, before: Standing | None) -> Cell | None:
        """Where the robot stands in a space that is less restricted than the one it stood in `before`."""
        if self.place_m is not None and before is not None:
            return before.cell
        standing = routes.standing[self.room]
        return standing.cell if standing is not None else None

    def told(self, topology: TopologicalMap) -> str:
        """The target in words."""
        return topology.room(self.room).title if self.room else self.text
