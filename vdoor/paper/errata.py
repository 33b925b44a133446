"""The paper's errata and what it leaves open: what it prints, why that cannot be meant, what is done here."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from vdoor.method.corners import Candidates
from vdoor.method.curvature import Curvature
from vdoor.method.doors import ProposeDoors
from vdoor.method.search.costs import MapCost
from vdoor.method.search.optimisers import GeneticSearch
from vdoor.paper.search import POPULATION, log2_load
from vdoor.paper.walkthrough import PRINTED_EDGES, PRINTED_GENERATION, MethodRun, paper_pipeline


@dataclass(frozen=True, kw_only=True)
class Erratum:
    """A place where the paper cannot be taken by the letter."""

    where: str
    printed: str
    trouble: str
    """Why it cannot be meant."""
    here: str
    """What is done instead."""


@dataclass(frozen=True, kw_only=True)
class Unprinted:
    """Something that the method needs and the paper does not print."""

    what: str
    taken: str
    """The value or rule used here."""


def errata(run: MethodRun) -> tuple[Erratum, ...]:
    """All errata in the paper's order, with numbers from the run of the walk-through."""
    return (*_of_curvature(run), *_of_doors(), *_of_search(), *_of_results(run))


def arctan_mistakes(run: MethodRun) -> tuple[int, int]:
    """How many candidates get the wrong sign from eq. 6 with arctan, as printed, and how many there are."""
    candidates, curvature = run.get(Candidates), run.get(Curvature)
    forward, backward = (
        vector[candidates.sample].astype(np.float64) * (-1, 1) for vector in (curvature.forward, curvature.backward)
    )
    with np.errstate(divide="ignore"):
        alpha = np.arctan(forward[:, 0] / forward[:, 1]) - np.arctan(backward[:, 0] / backward[:, 1])
    return int(((alpha < 0) != candidates.convex).sum()), len(candidates.sample)


def _of_curvature(run: MethodRun) -> Iterator[Erratum]:
    wrong, of = arctan_mistakes(run)
    reach_m = paper_pipeline().curvature.reach_m
    yield Erratum(
        where="II.B, eq. 1 and 2",
        printed="K is the largest value for which the distance is more than U_k times the length",
        trouble="taken up to the first violation, noise on a wall ends it early; taken without a limit, the other "
        "walls of a small room come into it",
        here=f"the largest over the whole range, up to {reach_m:g} m of wall and half the contour",
    )
    yield Erratum(
        where="II.B, eq. 5",
        printed="rho is the inverse of the angle between f and b, and candidates have rho > 1/155",
        trouble="infinite where f and b are parallel, as at the tip of a wall; the unit is left out",
        here=f"angles are compared, below {paper_pipeline().candidates.angle_deg:g} degrees, and never their inverse",
    )
    yield Erratum(
        where="II.B, eq. 6",
        printed="alpha = arctan(f_y / f_x) - arctan(b_y / b_x), with ranges up to 360 degrees",
        trouble="arctan has only half of the directions and so can never reach those ranges: of the walk-through's "
        f"{of} candidates, {wrong} ({wrong / of:.0%}) come out as the other kind",
        here="atan2, decided by the sign of a cross product; where the path folds back, by the side it turned to",
    )


def _of_doors() -> Iterator[Erratum]:
    doors = paper_pipeline().doors
    assert isinstance(doors, ProposeDoors)
    yield Erratum(
        where="II.C",
        printed="a door from a single convex corner to the closest boundary",
        trouble="what is closest is the corner's own wall",
        here="closest of what is further away along the wall than "
        f"{doors.single_detour:g} times the door's length; only for corners without a pair",
    )
    yield Erratum(
        where="II.C",
        printed="an edge represents how neighbouring nodes are connected",
        trouble="virtual doors cross (Fig. 3g), and then one may border more than two nodes",
        here="removing a door opens just the cells that no other door covers",
    )


def _of_search() -> Iterator[Erratum]:
    evaluations = PRINTED_GENERATION * POPULATION
    search = paper_pipeline().search
    assert isinstance(search, GeneticSearch)
    yield Erratum(
        where="III",
        printed="50 x 30 strings at most, but the process ends with the fiftieth generation",
        trouble="population times generations is 50 x 50",
        here=f"{search.generations} generations of {search.population}",
    )
    yield Erratum(
        where="III, eq. 7",
        printed="DegSD is the standard deviation of the doors' angles to the nearer axis",
        trouble="about their mean, doors that all lean the same way would cost nothing",
        here="root mean square about 0; 0 with no doors. AreaSD likewise about the room threshold, as printed",
    )
    yield Erratum(
        where="IV",
        printed="optimum after the 9th generation of 2^16 choices: the load decreased to about 1/2^9",
        trouble=f"9 x 50 = {evaluations} strings of 65,536 are 1/2^{-log2_load(evaluations, PRINTED_EDGES):.1f}; with "
        f"the first population, 1/2^{-log2_load(evaluations + POPULATION, PRINTED_EDGES):.1f}",
        here="every evaluated string is counted, the first population with them",
    )


def _of_results(run: MethodRun) -> Iterator[Erratum]:
    counts = run.counts
    yield Erratum(
        where="IV, Fig. 5d",
        printed="43 concave and 35 convex corners",
        trouble="on a connected right-angled map the former less the latter is 4 - 4 x islands, at most 4, and not 8: "
        "some were missed or found twice",
        here=f"the same happens here: the simplified map turns {counts.concave_turns} times concave and "
        f"{counts.convex_turns} times convex around {counts.islands} islands, of which {counts.concave_corners} and "
        f"{counts.convex_corners} are found",
    )
    yield Erratum(
        where="IV, Fig. 5e",
        printed="18 nodes and 16 edges",
        trouble="nodes are 1 + doors + crossings - islands tied in: 16 doors that do not cross part at most 17",
        here=f"crossing doors are allowed; here {counts.nodes} nodes of {counts.edges} edges, of which "
        f"{counts.edges_of_many} border more than two nodes",
    )
    yield Erratum(
        where="IV, Table I",
        printed="accuracy is the ratio of extracted virtual doors to matched real doors",
        trouble="that grows with the doors that match none; the table's head and numbers are matched / virtual",
        here="matched / virtual, and beside it matched / real",
    )


def unprinted() -> tuple[Unprinted, ...]:
    """All that the paper leaves open, with what is used here; preset `paper` has it as settings."""
    preset = paper_pipeline()
    search, cost, simplify = preset.search, preset.cost, preset.simplify
    assert isinstance(search, GeneticSearch)
    assert isinstance(cost, MapCost)
    areas, tilts = cost.area_weight_per_m2, cost.tilt_weight_per_deg
    taken = {
        "room threshold T of eq. 7": f"{cost.room_m2:g} m2",
        "weights w1, w2, w3 of eq. 7": f"{cost.small_weight:g} a room, {areas:g} per m2, {tilts:g} per degree",
        "first population": f"each door removed with a chance of {search.start_removed:g}",
        "who mates with whom": f"pairs drawn at random; each bit is exchanged with a chance of {search.crossover:g}",
        "samples": "the obstacle cell at the walker's left hand, once in a row; lengths are Euclidean",
        "local maximum": f"the smallest angle of its kind within {preset.corners.window_m:g} m of wall; the middle of "
        "a plateau, but both cells at the end of a wall two cells thick",
        "a jut": f"up to {simplify.jut_m:g} m long (at least a cell), one cell deep, on a wall that goes on at both "
        f"ends; notches likewise; {simplify.passes} passes",
        "what is accessible": "the largest 4-connected free space, or the robot's; walls are 8-connected",
        "doors that part nothing": "dropped at the end; of doors with nothing between them one is kept",
    }
    return tuple(Unprinted(what=what, taken=how) for what, how in taken.items())
