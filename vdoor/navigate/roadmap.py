"""A roadmap: a sparse graph over the floor of all rooms, joined at the doors, for planners that follow a graph.

Within each room nodes are placed until every place that keeps the clearance sees one of them nearby (`roadmap_cover`).
Of all straight ways between nodes that see each other those are kept by which the others can be gone with little more
length (`roadmap_spanner`). Where a door or a gap is narrower than the clearance, the widest way through it is added
(`roadmap_narrow`), so that the graph joins whatever the map joins.
"""

from __future__ import annotations

from collections import defaultdict
from dataclasses import dataclass, field
from itertools import pairwise
from typing import NamedTuple

import numpy as np
import scipy
from numpy.typing import NDArray

from vdoor.grid import Annotations
from vdoor.navigate.blocked import ruled_out
from vdoor.navigate.places import standing_in
from vdoor.navigate.roadmap_cover import Cover
from vdoor.navigate.roadmap_doors import DoorPlace, door_places
from vdoor.navigate.roadmap_floor import Floor, Point
from vdoor.navigate.roadmap_narrow import narrow_ways
from vdoor.navigate.roadmap_spanner import spanner
from vdoor.navigate.space import Space
from vdoor.raster.components import components
from vdoor.topology import TopologicalMap

Mask = NDArray[np.bool_]

STRETCH = 1.05
"""Ways that can be gone over others with at most so many times their length are left out."""


class Node(NamedTuple):
    """A place of the roadmap."""

    place: Point
    """Row, col in the map; a half where it lies between two cells."""
    room: int
    """The id of its room; 0 in a door."""
    door: int = 0
    """The id of its door; 0 elsewhere."""
    main: bool = False
    """Whether this is the node of the room, or of the door; a wide door has further ones."""


class Edge(NamedTuple):
    """A straight way between two nodes, both ways, within one room, or at most a cell beside it."""

    ends: tuple[int, int]
    """Indices of the nodes."""
    room: int
    clearance_m: float
    """What it keeps: the clearance asked for, or less where the map has no more."""


@dataclass
class Roadmap:
    """Nodes and edges."""

    nodes: list[Node] = field(default_factory=list)
    """First one for each room, in their order, then one for each door, then all others."""
    edges: list[Edge] = field(default_factory=list)

    def merge(self, cover: Cover, room: int, indices: list[int]) -> list[int]:
        """The index of each node of a room; those that have none in `indices` yet are added."""
        for point in cover.points[len(indices) :]:
            row, col = (point + cover.floor.corner).tolist()
            indices.append(len(self.nodes))
            self.nodes.append(Node((row, col), room))
        return indices


def roadmap_of(topology: TopologicalMap, annotations: Annotations | None = None, *, clearance_m: float) -> Roadmap:
    """The roadmap of a map, clear of its walls and of the virtual walls and no-go areas of its file.

    Raises `VdoorError` for a door whose rooms do not touch.
    """
    blocked = topology.labels == 0
    if annotations is not None:
        blocked |= ruled_out(topology.frame, annotations, mops=False)
    space = Space.of(blocked, topology.frame, clearance_m)
    boxes = scipy.ndimage.find_objects(topology.labels)
    places = door_places(topology, space)
    found = Roadmap()
    for room in topology.room_ids:
        standing = standing_in(space, topology, room, boxes[room - 1])
        row, col = standing.cell if standing else topology.centre[topology.room_row(room)].tolist()
        found.nodes.append(Node((float(row), float(col)), room, main=True))
    at_door: dict[int, list[tuple[int, DoorPlace]]] = defaultdict(list)
    for place in places:
        for room in place.rooms:
            at_door[room].append((len(found.nodes), place))
        found.nodes.append(Node(place.place, 0, place.door, main=place.main))
    for row, room in enumerate(topology.room_ids):
        floor = Floor.of(blocked, topology.labels == room, boxes[room - 1], topology.frame, clearance_m)
        _add_room(found, floor, room, row, at_door[room])
    return found


def _add_room(found: Roadmap, floor: Floor, room: int, row: int, doors: list[tuple[int, DoorPlace]]) -> None:
    """Add the nodes and edges of one room, whose own node is `row`."""
    indices = [row, *(index for index, _ in doors)]
    points = [floor.seen_from_map(found.nodes[index].place) for index in indices]
    eyes = [points[0], *(floor.seen_from_map(place.eye(room)) for _, place in doors)]
    cover = Cover(floor.without_pockets(eyes))
    for point, eye in zip(points, eyes, strict=True):
        cover.add(point, eye)
    cover.fill()
    cover.join()
    if len(cover.points) == 1:
        cover.add_farthest()
    stuck = [at for at, (_, place) in enumerate(doors, start=1) if not place.passable]
    pieces = _narrow_pieces(cover, [*([] if cover.floor.holds(points[0]) else [0]), *stuck])
    kept = spanner(cover.ways(), STRETCH)
    indices = found.merge(cover, room, indices)
    found.edges += [Edge((indices[a], indices[b]), room, floor.clear.radius_m) for a, b in kept.ends.tolist()]
    for one, other in pieces:
        kept_m = floor.clearance_m(cover.spots.point[[one, other]])
        found.edges.append(Edge((indices[one], indices[other]), room, kept_m))


def _narrow_pieces(cover: Cover, stuck: list[int]) -> list[tuple[int, int]]:
    """The straight pieces of ways through narrow places, between nodes that are added to the cover where they bend.

    `stuck` are the nodes that do not keep the clearance.
    """
    part = components(cover.ways().ends.T.astype(np.intp), len(cover.points))
    raster = np.where(cover.owner >= 0, part[cover.owner], -1)
    known = {eye: node for node, eye in reversed([*enumerate(cover.eyes)])}
    pieces: list[tuple[int, int]] = []
    for way in narrow_ways(cover.floor, raster, [cover.eyes[node] for node in stuck]):
        for point in way:
            if point not in known:
                known[point] = len(cover.points)
                cover.add(point)
        pieces += pairwise(known[point] for point in way)
    return pieces
