"""Requests for a robot with Valetudo: clean rooms, make its segments ours. Nothing is sent."""

from __future__ import annotations

import itertools
import json
import shlex
from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from vdoor.errors import VdoorError
from vdoor.export.geometry import line_m
from vdoor.export.virtual_walls import CORNERS, origin_of, own_points_cm
from vdoor.grid import Annotations
from vdoor.results.segments import MOSTLY, segments_of, shares_of
from vdoor.topology import TopologicalMap

MOST_ZONES = 5
"""Zones that robots take in one request; Valetudo tells its robot's own limit, which is this for most."""
WORTH = 0.05
"""Another rectangle must spare this share of the room's cells outside the room."""
Box = tuple[int, int, int, int]
"""First row, first column, and the row and column behind the last."""


class Request(NamedTuple):
    """What to PUT, and where."""

    capability: str
    body: dict[str, Any]

    @property
    def text(self) -> str:
        """The body as JSON on one line."""
        return json.dumps(self.body)

    @property
    def curl(self) -> str:
        """The command that would send it."""
        head = "curl -X PUT -H 'Content-Type: application/json'"
        return f"{head} --data {shlex.quote(self.text)} http://ROBOT/api/v2/robot/capabilities/{self.capability}"


def clean(topology: TopologicalMap, rooms: Sequence[int], annotations: Annotations | None) -> list[Request]:
    """Requests that clean rooms in this order: by segment where a room is one, else by zones that cover it."""
    segments = segments_of(topology, annotations)
    ids = [segments[room].id for room in rooms if room in segments]
    requests = []
    if ids:
        body = {"action": "start_segment_action", "segment_ids": ids, "iterations": 1, "customOrder": True}
        requests.append(Request("MapSegmentationCapability", body))
    for room in rooms:
        if room not in segments:
            zones = [{"points": points, "iterations": 1} for points in _zones(topology, room)]
            requests.append(Request("ZoneCleaningCapability", {"action": "clean", "zones": zones}))
    return requests


def reshape(topology: TopologicalMap, annotations: Annotations | None) -> list[Request]:
    """Requests that make the robot's segments ours: splits along our doors, or else, if none is left to do, joins.

    A split gives the parts new ids, so joins only come once the map is read again after the splits. Raises
    `VdoorError` for a map without segments.
    """
    shares = shares_of(topology, annotations)
    if not shares.segments:
        raise VdoorError("segments: wanted a map with the robot's segments, found none")
    return [*_splits(topology, annotations)] or [*_joins(topology, annotations)]


def _splits(topology: TopologicalMap, annotations: Annotations | None) -> Iterator[Request]:
    """A split of a segment along each door between two rooms that lie mostly in it; one a segment, as ids change."""
    shares = shares_of(topology, annotations)
    row_of = {room: row for row, room in enumerate(topology.room_ids)}
    done = set()
    for door in topology.doors:
        rows = [row_of[room] for room in door.rooms]
        for col in np.flatnonzero((shares.of_room[rows] >= MOSTLY).all(axis=0)).tolist():
            if col in done:
                continue
            done.add(col)
            ends = topology.frame.cell_from_world(np.array(line_m(topology, door)))
            start, end = own_points_cm(topology, ends, origin_of(topology))
            body = {"action": "split_segment", "segment_id": shares.segments[col].id, "pA": start, "pB": end}
            yield Request("MapSegmentEditCapability", body)


def _joins(topology: TopologicalMap, annotations: Annotations | None) -> Iterator[Request]:
    """A join of the segments that lie mostly in one room, two at a time; one a room, as ids change."""
    shares = shares_of(topology, annotations)
    for row in range(len(topology.room_ids)):
        own = np.flatnonzero(shares.of_segment[row] >= MOSTLY).tolist()
        for one, other in itertools.islice(itertools.pairwise(own), 1):
            ids = {"segment_a_id": shares.segments[one].id, "segment_b_id": shares.segments[other].id}
            yield Request("MapSegmentEditCapability", {"action": "join_segments", **ids})


def _zones(topology: TopologicalMap, room: int) -> Iterator[dict[str, dict[str, int]]]:
    """Rectangles that cover a room, by their corners in the robot's own frame, clockwise from the upper left."""
    for top, left, bottom, right in covering(topology.labels == room):
        corners = np.array([(top, left), (top, right), (bottom, right), (bottom, left)]) - 0.5
        yield dict(zip(CORNERS, own_points_cm(topology, corners, origin_of(topology)), strict=True))


def covering(mask: NDArray[np.bool_], most: int = MOST_ZONES) -> list[Box]:
    """At most `most` boxes that together cover all cells of a mask (h, w), and few others."""
    boxes = [_tight(mask, (0, 0, *mask.shape))]
    while len(boxes) < most:
        cuts = [(saved, at, parts) for at, box in enumerate(boxes) for saved, parts in _cuts(mask, box)]
        saved, at, parts = max(cuts, default=(0, 0, ()))
        if saved < WORTH * np.count_nonzero(mask):
            break
        boxes[at : at + 1] = parts
    return boxes


def _cuts(mask: NDArray[np.bool_], box: Box) -> Iterator[tuple[int, tuple[Box, ...]]]:
    """Every way to cut a box in two: cells spared, and both parts made tight."""
    top, left, bottom, right = box
    halves = [((top, left, row, right), (row, left, bottom, right)) for row in range(top + 1, bottom)]
    halves += [((top, left, bottom, col), (top, col, bottom, right)) for col in range(left + 1, right)]
    for one, other in halves:
        parts = (_tight(mask, one), _tight(mask, other))
        yield _size(box) - sum(map(_size, parts)), parts


def _tight(mask: NDArray[np.bool_], box: Box) -> Box:
    """The smallest box around the mask's cells in a box."""
    top, left, bottom, right = box
    rows, cols = (np.flatnonzero(mask[top:bottom, left:right].any(axis=axis)) for axis in (1, 0))
    if not len(rows):
        return top, left, top, left
    return top + int(rows[0]), left + int(cols[0]), top + int(rows[-1]) + 1, left + int(cols[-1]) + 1


def _size(box: Box) -> int:
    return (box[2] - box[0]) * (box[3] - box[1])
