"""Section III: the optimisation problem given by the initial map, and the evaluation of many choices at once."""

from __future__ import annotations

import itertools
from functools import cached_property

import numpy as np
import scipy
from numpy.typing import NDArray

from vdoor.method.initial_map import InitialMap
from vdoor.method.scoring.score import DoorScores
from vdoor.method.search.adjacency import Adjacency, both_ways, grouped
from vdoor.method.search.costs import Cost, Costs, Term, Totals
from vdoor.raster.components import components

Bits = NDArray[np.bool_]
Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

# Tilts and log-odds are summed as integers in these units, so that sums do not depend on their order.
TILT_UNIT_DEG2 = 1e-9
LOG_ODDS_UNIT = 1e-9
MOST_AT_ONCE = 10_000_000  # limit for the nodes, links and covers of all choices evaluated together


class MergeProblem:
    """The optimisation problem: nodes of cells that merge when doors are removed.

    A node is a region, or a bundle of atoms that are on the same doors and touch a common region, since these open and
    merge together. All sums are over integers, so that equal choices cost the same to the last bit on every machine.
    """

    def __init__(self, initial: InitialMap, cost: Cost, scores: DoorScores | None = None) -> None:
        self.edges = len(initial.door)
        self.regions = len(initial.area_m2)
        self.cost = cost if scores is None else cost.on_map(scores.share_rough)
        self.share_rough = 0.0 if scores is None else scores.share_rough
        """How rough the map is, 0 to 1."""
        self.cell_m2 = initial.frame.resolution_m**2
        bundle, self.cover_start, self.cover_edge = bundles(initial)
        count = self.regions + len(self.cover_start)
        self.node_of_atom = self.regions + bundle
        node = np.append(np.arange(self.regions), self.node_of_atom)
        area = np.append(initial.area_m2, initial.atom_area_m2)
        self.cells = np.bincount(node, weights=np.rint(area / self.cell_m2), minlength=count)
        self.links = sorted_links(node[initial.touch_a], node[initial.touch_b], count)
        self.tilt = np.rint(np.degrees(initial.tilt_rad) ** 2 / TILT_UNIT_DEG2).astype(np.int64)
        self.log_odds, self.conflicts = odds_and_conflicts(initial, scores)
        worst = (np.arange(self.edges), initial.length_m, initial.tilt_rad)
        self.border_region = initial.border_region
        """The regions that each edge borders, concatenated; `border_start` (edges,) is where each edge's begin."""
        self.border_edge = initial.border_edge
        """The edge of each entry of `border_region`."""
        self.border_start = np.searchsorted(self.border_edge, np.arange(self.edges))
        log_odds: Floats = (self.log_odds * LOG_ODDS_UNIT).astype(np.float64, copy=False)
        self.gain = self.cost.gain(log_odds)
        """The saving (edges,) from keeping each door if it separates two rooms, regardless of the rooms' areas."""
        self.most_gain = self.cost.most_gain(log_odds)
        """The largest saving (edges,), that of a further door between its rooms."""
        self.worst_first = np.lexsort(worst)[::-1] if scores is None else np.argsort(self.log_odds, kind="stable")
        """The order (edges,) in which doors that separate nothing are dropped."""
        self.is_region = np.arange(count) < self.regions
        self.small_cells = self.cost.room_m2 / self.cell_m2
        self.threshold_cells = round(self.small_cells)
        """The room threshold in whole cells, so that the area that rooms lack is summed exactly."""
        self.at_once = max(1, MOST_AT_ONCE // (count + len(self.links[0]) + len(self.cover_edge) + 1))

    @cached_property
    def adjacency(self) -> Adjacency:
        """What lies beside each node and edge."""
        nodes, count = len(self.cells), np.diff(np.append(self.cover_start, len(self.cover_edge)))
        covers = np.stack([self.cover_edge, self.regions + np.repeat(np.arange(len(count)), count)])
        border = np.stack([self.border_edge, self.border_region])
        border = border if self.cost.counts_separating else border[:, :0]
        return Adjacency(
            neighbours=grouped(both_ways(np.stack(self.links)), nodes),
            nodes_of=grouped(covers, self.edges),
            covers=covers,
            regions_of=grouped(border, self.edges),
            edges_of=grouped(border[::-1], nodes),
            conflicts=grouped(both_ways(self.conflicts), self.edges),
        )

    def open_nodes(self, removed: Bits) -> Bits:
        """Which nodes (p, nodes) are open in each choice (p, edges): regions, and bundles with all doors removed."""
        is_open = np.ones((len(removed), len(self.cells)), np.bool_)
        if len(self.cover_start):
            all_removed = np.logical_and.reduceat(removed[:, self.cover_edge], self.cover_start, axis=1)
            is_open[:, self.regions :] = all_removed
        return is_open

    def rooms(self, removed: Bits) -> tuple[NDArray[np.intp], Bits]:
        """The room (p, nodes) of each node in each choice, numbered across all choices, and which nodes are open."""
        is_open = self.open_nodes(removed)
        a, b = self.links
        choices, count = is_open.shape
        joined = is_open[:, a] & is_open[:, b]
        choice, link = np.nonzero(joined)
        # links are sorted by a, so the entries are already in the order of a CSR matrix
        per_row = np.bincount(choice * count + a[link], minlength=choices * count)
        begin = np.append(0, np.cumsum(per_row))
        graph = scipy.sparse.csr_array(
            (np.ones(len(link), np.int8), choice * count + b[link], begin), shape=(choices * count,) * 2
        )
        _, room = scipy.sparse.csgraph.connected_components(graph, directed=False)
        return room.reshape(choices, count).astype(np.intp, copy=False), is_open

    def separating(self, removed: Bits, room: NDArray[np.intp]) -> tuple[Bits, Ints]:
        """Which kept doors (p, edges) separate rooms, and the number of pairs of rooms (p,) that they separate.

        `room` (p, nodes) is from `rooms`. A door that borders more than two rooms counts as a pair of its own. If the
        cost does not count separating doors, as only the energy does, the results are False and 0.
        """
        if not (self.cost.counts_separating and self.edges):
            return np.zeros(removed.shape, np.bool_), np.zeros(len(removed), np.int64)
        beside = room[:, self.border_region]
        lowest, highest = (end.reduceat(beside, self.border_start, axis=1) for end in (np.minimum, np.maximum))
        between = (beside > lowest[:, self.border_edge]) & (beside < highest[:, self.border_edge])
        separates = ~removed & (lowest != highest)
        several = separates & np.logical_or.reduceat(between, self.border_start, axis=1)
        choice, door = np.nonzero(separates & ~several)
        pair = np.unique(np.stack([choice, lowest[choice, door], highest[choice, door]]), axis=1)
        return separates, several.sum(axis=1) + np.bincount(pair[0], minlength=len(removed))

    def evaluate(self, removed: Bits) -> Costs:
        """The cost of each choice (p, edges); bit 1 = door removed. Memory is bounded for any number of choices."""
        parts = [
            self.cost(self.totals(removed[begin : begin + self.at_once]), sqrt=np.sqrt)
            for begin in range(0, len(removed), self.at_once)
        ]
        return parts[0] if len(parts) == 1 else Costs(*map(np.concatenate, zip(*parts, strict=True)))

    def terms(self, removed: Bits) -> tuple[Term, ...]:
        """The terms whose sum is the cost of one choice (edges,)."""
        return self.cost.terms(Totals(*(total[0] for total in self.totals(removed[None]))))

    def totals(self, removed: Bits) -> Totals:
        """The sums over the rooms and the kept doors of each choice (p, edges)."""
        room, is_open = self.rooms(removed)
        choices = len(removed)
        cells = np.bincount(room.ravel(), weights=(is_open * self.cells).ravel())
        is_room = np.zeros(len(cells), np.bool_)
        is_room[room[:, self.is_region]] = True
        choice = np.zeros(len(cells), np.intp)
        choice[room] = np.arange(choices)[:, None]

        def total(values: NDArray[np.generic]) -> Floats:
            return np.bincount(choice[is_room], weights=values[is_room], minlength=choices).astype(
                np.float64, copy=False
            )

        kept = ~removed
        separating, pairs = self.separating(removed, room)
        return Totals(
            rooms=total(np.ones(len(cells))).astype(np.int64),
            small=total(cells < self.small_cells).astype(np.int64),
            area_m2=total(cells) * self.cell_m2,
            area_squared_m4=total(cells**2) * self.cell_m2**2,
            doors=kept.sum(axis=1),
            tilt_squared_deg2=(kept * self.tilt).sum(axis=1) * TILT_UNIT_DEG2,
            lacking_m2=total(np.maximum(self.threshold_cells - cells, 0)) * self.cell_m2,
            separating=separating.sum(axis=1),
            pairs=pairs,
            log_odds=(separating * self.log_odds).sum(axis=1) * LOG_ODDS_UNIT,
            conflicts=(kept[:, self.conflicts[0]] & kept[:, self.conflicts[1]]).sum(axis=1),
        )


def bundles(initial: InitialMap) -> tuple[NDArray[np.intp], NDArray[np.intp], NDArray[np.int32]]:
    """The bundle (atoms,) of each atom; and the edges that cover each bundle: where they begin, and all concatenated.

    A bundle is a node: atoms on the same doors that touch a common region.
    """
    atoms = len(initial.atom_area_m2)
    begin = np.searchsorted(initial.cover_atom, np.arange(atoms))
    cover = [
        initial.cover_edge[slice(*ends)].tobytes()
        for ends in itertools.pairwise(np.append(begin, len(initial.cover_edge)))
    ]
    number = {key: index for index, key in enumerate(dict.fromkeys(cover))}
    same_doors = np.array([number[key] for key in cover], np.intp)
    regions = len(initial.area_m2)
    to_region = initial.touch_a < regions
    atom, region = initial.touch_b[to_region] - regions, initial.touch_a[to_region]
    _, meeting = np.unique(same_doors[atom] * np.int64(max(regions, 1)) + region, return_inverse=True)
    meetings = int(meeting.max(initial=-1)) + 1
    bundle = components(np.stack([atom, atoms + meeting]), atoms + meetings)[:atoms]
    _, first, bundle = np.unique(bundle, return_index=True, return_inverse=True)
    lists = [np.frombuffer(cover[atom], np.int32) for atom in first]
    sizes = np.array([len(edges) for edges in lists], np.intp)
    flat = np.concatenate(lists) if lists else np.zeros(0, np.int32)
    return bundle, np.cumsum(sizes) - sizes, flat


def odds_and_conflicts(initial: InitialMap, scores: DoorScores | None) -> tuple[NDArray[np.int64], NDArray[np.intp]]:
    """The log-odds (edges,) of the edges in units of `LOG_ODDS_UNIT`, and their conflicts as pairs (2, k)."""
    edges = len(initial.door)
    if scores is None:
        return np.zeros(edges, np.int64), np.zeros((2, 0), np.intp)
    row = np.searchsorted(scores.door, initial.door)
    edge = np.full(len(scores.door), -1, np.intp)
    edge[row] = np.arange(edges)
    pairs = edge[np.stack([scores.rival_a, scores.rival_b])]
    return np.rint(scores.log_odds[row] / LOG_ODDS_UNIT).astype(np.int64), pairs[:, (pairs >= 0).all(axis=0)]


def sorted_links(a: NDArray[np.intp], b: NDArray[np.intp], count: int) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """The links as sorted pairs, the smaller node first, without duplicates and loops."""
    low, high = np.minimum(a, b), np.maximum(a, b)
    key = np.unique(low[low != high] * np.int64(count) + high[low != high])
    return key // count, key % count
