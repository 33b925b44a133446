"""The robot's own segments beside our rooms: which is which, and the names that rooms take from them."""

from __future__ import annotations

import dataclasses
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from vdoor.grid import Annotations, Segment
from vdoor.record import TEXT
from vdoor.topology import TopologicalMap

SAME = 0.8
"""Share of its own cells that a room, and a segment, must have in common with the other to be the same."""
MOSTLY = 0.5
"""Share of a segment's cells in a room from which on the segment belongs to it, and the other way round."""


class Shares(NamedTuple):
    """How rooms and segments overlap; rows are rooms in the order of their ids, columns segments in theirs."""

    segments: tuple[Segment, ...]
    of_room: NDArray[np.float64]
    """Share of the room's cells in the segment (room, segment)."""
    of_segment: NDArray[np.float64]
    """Share of the segment's cells in the room (room, segment), out of those in any room."""


def shares_of(topology: TopologicalMap, annotations: Annotations | None) -> Shares:
    """The overlaps of all rooms with all segments; no columns for a map without segments."""
    rooms = len(topology.room_ids)
    if annotations is None or annotations.labels is None:
        return Shares((), np.zeros((rooms, 0)), np.zeros((rooms, 0)))
    segments = annotations.segments
    row = np.searchsorted(np.array(topology.room_ids), topology.labels)
    inside = topology.labels > 0
    flat = row[inside] * (len(segments) + 1) + annotations.labels[inside]
    cells = np.bincount(flat, minlength=rooms * (len(segments) + 1)).reshape(rooms, -1).astype(np.float64)
    of_room = cells[:, 1:] / np.maximum(cells.sum(axis=1, keepdims=True), 1)
    of_segment = cells[:, 1:] / np.maximum(cells[:, 1:].sum(axis=0, keepdims=True), 1)
    return Shares(segments, of_room, of_segment)


def segments_of(topology: TopologicalMap, annotations: Annotations | None) -> dict[int, Segment]:
    """The segment that each room is, by the room's id; rooms that are none are left out."""
    shares = shares_of(topology, annotations)
    same = (shares.of_room >= SAME) & (shares.of_segment >= SAME)
    return {topology.room_ids[row]: shares.segments[col] for row, col in np.argwhere(same).tolist()}


def named_by_robot(topology: TopologicalMap, annotations: Annotations | None) -> TopologicalMap:
    """The map with the robot's names for rooms that are its segments, unless they have names of their own."""
    found = {room: segment.name.strip() for room, segment in segments_of(topology, annotations).items()}
    old = topology.name or ("",) * len(topology.room_ids)
    names = tuple(own or found.get(room, "") for room, own in zip(topology.room_ids, old, strict=True))
    if not any(names) or not all(TEXT.fullmatch(name) for name in names):
        return topology
    return dataclasses.replace(topology, name=names)
