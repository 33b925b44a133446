"""Drawings of the search and of the final map that are not on the map: costs by generation, and the graph."""

from __future__ import annotations

import rerun as rr

from vdoor.frame import Frame
from vdoor.method.scoring.score import DoorScores
from vdoor.method.search.generation import Generation
from vdoor.topology import TopologicalMap
from vdoor.viz.marks.plots import cost_chart, terms_chart
from vdoor.viz.rerun import style
from vdoor.viz.rerun.chart import draw_chart
from vdoor.viz.rerun.scene import Scene, pixels

SIDE = 450.0
"""Graphs are scaled to a square of that side."""
COSTS = {"best": style.BEST, "mean": style.MEAN, "worst": style.WORST}


def draw_generation(scene: Scene, generation: Generation) -> None:
    """Log the costs, and draw their chart anew whenever the number of generations has doubled."""
    for name, colour in COSTS.items():
        scene.log(f"plots/search/{name}", rr.Scalars(getattr(generation, f"{name}_cost")))
        if generation.number == 0:
            scene.keep(f"plots/search/{name}", rr.SeriesLines(colors=colour, names=f"{name} cost"))
    count = len(scene.run.search)
    if count & (count - 1) == 0:
        draw_costs(scene)


def draw_costs(scene: Scene) -> None:
    """Draw the charts of the search so far; the three terms only of searches whose cost is made of them."""
    draw_chart(scene, "charts/cost", cost_chart(scene.run))
    if not scene.run.has(DoorScores):
        draw_chart(scene, "charts/terms", terms_chart(scene.run))


def draw_final_graph(scene: Scene, topology: TopologicalMap) -> None:
    """Draw the charts of the whole search, and the graph of rooms with their numbers."""
    if len(scene.run.search):
        draw_costs(scene)
    names = [str(room) for room in topology.room_ids]
    joined = [(str(a), str(b)) for a, b in zip(topology.room_a.tolist(), topology.room_b.tolist(), strict=True)]
    nodes = rr.GraphNodes(
        names,
        positions=pixels(topology.centre) * spread(topology.frame),
        radii=8.0,
        labels=names,
        colors=[style.room(room) for room in topology.room_ids],
    )
    scene.log("graph/final", nodes, rr.GraphEdges(joined))


def spread(frame: Frame) -> float:
    """Scale that makes a map's longer side `SIDE`, so that the labels of its graph do not overlap."""
    return SIDE / max(frame.height, frame.width, 1)


def room_classes(count: int) -> dict[int, tuple[str, tuple[int, ...]]]:
    """Name and colour of labels 0 to `count`."""
    named = {room % 2**16: (f"room {room}", style.room(room)) for room in range(1, count + 1)}
    return named | {0: ("no room", style.CLEAR)}
