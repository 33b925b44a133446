"""What changed between two results, in the words of those who use them: rooms and doors, not records."""

from __future__ import annotations

import math

import numpy as np
import scipy
from numpy.typing import NDArray

from vdoor.matching.align import labels_under
from vdoor.topology import Door, TopologicalMap

LINKED = 0.5
"""Share of the smaller room that two rooms must have in common to be the same place."""
SAME_DOOR_M = 1.0
"""Doors whose ends are farther apart are different ones."""


def result_changes(old: TopologicalMap, new: TopologicalMap, *, within_m: float = 0.0) -> list[str]:
    """One line for each room and door that came, went, was split or merged, or moved by more than `within_m`.

    Both maps must lie in the same frame. A room moves by the largest distance from a cell that one map gives it to the
    nearest one that the other gives it, a door by that of its ends. Ids and names are not compared.
    """
    return [*_room_changes(old, new, within_m), *_door_changes(old.doors, new.doors, within_m)]


def _room_changes(old: TopologicalMap, new: TopologicalMap, within_m: float) -> list[str]:
    cells = np.argwhere(new.labels)
    under = np.zeros(new.labels.shape, np.int32)
    points_m = new.frame.world_from_cell(np.argwhere(np.ones(under.shape, np.bool_)))
    under[:] = labels_under(old, points_m, np.zeros(2)).reshape(under.shape)
    import networkx as nx  # noqa: PLC0415  # a seventh of a second

    links: nx.Graph[tuple[str, int]] = nx.Graph()
    links.add_nodes_from([("old", room) for room in old.room_ids] + [("new", room) for room in new.room_ids])
    pairs, shared = np.unique(
        np.stack([under[tuple(cells.T)], new.labels[tuple(cells.T)]], axis=1), axis=0, return_counts=True
    )
    sizes = {key: _sizes(labels) for key, labels in (("old", under), ("new", new.labels))}
    for (one, other), count in zip(pairs.tolist(), shared.tolist(), strict=True):
        if one and count >= LINKED * min(sizes["old"][one], sizes["new"][other]):
            links.add_edge(("old", one), ("new", other))
    lines = []
    for group in sorted(nx.connected_components(links), key=min):
        before = sorted(room for side, room in group if side == "old")
        after = sorted(room for side, room in group if side == "new")
        lines += _room_line(before, after, under, new, within_m)
    return lines


def _sizes(labels: NDArray[np.int32]) -> dict[int, int]:
    """The number of cells of each label, which may be any number."""
    label, cells = np.unique(labels, return_counts=True)
    return dict(zip(label.tolist(), cells.tolist(), strict=True))


def _room_line(
    before: list[int], after: list[int], under: NDArray[np.int32], new: TopologicalMap, within_m: float
) -> list[str]:
    """At most one line on rooms that are the same place before and after."""
    if len(before) == len(after) == 1:
        moved_m = _apart_m(under == before[0], new.labels == after[0]) * new.frame.resolution_m
        return [f"room {before[0]} moved by up to {moved_m:.3f} m"] if moved_m > within_m else []
    if not after:
        return [f"room {before[0]} went"]
    if not before:
        return [f"room {after[0]} came"]
    if len(before) == 1:
        return [f"room {before[0]} was split into rooms {_listed(after)}"]
    if len(after) == 1:
        return [f"rooms {_listed(before)} were merged into room {after[0]}"]
    return [f"rooms {_listed(before)} were divided anew, into rooms {_listed(after)}"]


def _apart_m(one: NDArray[np.bool_], other: NDArray[np.bool_]) -> float:
    """Largest distance, in cells, from a cell of either mask to the other mask; 0 for equal ones."""
    (box,) = scipy.ndimage.find_objects((one | other).astype(np.int32))
    one, other = one[box], other[box]
    if not (one.any() and other.any()):
        return math.inf
    ways = (scipy.ndimage.distance_transform_edt(~mask)[beside].max() for mask, beside in ((one, other), (other, one)))
    return float(max(ways))


def _door_changes(old: list[Door], new: list[Door], within_m: float) -> list[str]:
    apart_m = np.array([[_doors_apart_m(one, other) for other in new] for one in old]).reshape(len(old), len(new))
    rows, cols = scipy.optimize.linear_sum_assignment(np.minimum(apart_m, 2 * SAME_DOOR_M))
    same = [(row, col) for row, col in zip(rows, cols, strict=True) if apart_m[row, col] <= SAME_DOOR_M]
    went = set(range(len(old))) - {row for row, _ in same}
    came = set(range(len(new))) - {col for _, col in same}
    moved = [(old[row], float(apart_m[row, col])) for row, col in same if apart_m[row, col] > within_m]
    return [
        *(f"door {door.id} moved by {by_m:.3f} m" for door, by_m in moved),
        *(f"door {old[row].id} at {_place(old[row])} went" for row in sorted(went)),
        *(f"door {new[col].id} at {_place(new[col])} came" for col in sorted(came)),
    ]


def _doors_apart_m(one: Door, other: Door) -> float:
    """The larger distance between ends of two doors, matched the better way round."""
    ways = ((other.start_m, other.end_m), (other.end_m, other.start_m))
    return min(max(math.dist(one.start_m, start), math.dist(one.end_m, end)) for start, end in ways)


def _place(door: Door) -> str:
    return ",".join(f"{(a + b) / 2:.2f}" for a, b in zip(door.start_m, door.end_m, strict=True))


def _listed(rooms: list[int]) -> str:
    return " and ".join(map(str, rooms))
