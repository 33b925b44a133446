"""Drawings of topological maps, edits and the search: over the map, and as graphs."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import rerun as rr
from numpy.typing import NDArray

from vdoor.editing.apply import VERDICTS, Edits
from vdoor.editing.edits import FORMS
from vdoor.method.initial_map import InitialMap
from vdoor.method.search.generation import Generation
from vdoor.topology import TopologicalMap
from vdoor.viz.rerun import style
from vdoor.viz.rerun.scene import Scene, classes, pixels, strips, table

TERMS = {"small_rooms": "NumSmallNode", "area_sd_m2": "AreaSD, m2", "tilt_sd_deg": "DegSD, degrees"}
MOST_IN_A_BYTE = 255
COSTS = {"best": style.BEST, "mean": style.MEAN, "worst": style.WORST}


def draw_initial(scene: Scene, initial: InitialMap) -> None:
    """Draw regions, and the graph of regions and the doors that they border; a door may border more than two."""
    scene.remembered[initial.topic] = initial
    regions = len(initial.area_m2)
    shown = as_classes(np.where(initial.piece <= regions, initial.piece, 0))
    scene.keep("map/regions", classes(room_classes(regions)))
    scene.raster("map/regions", shown, order=2.0, opacity=0.6)
    middle = (initial.start + initial.end) / 2
    links = strips(initial.centre[initial.border_region], middle[initial.border_edge])
    scene.log("map/initial/links", rr.LineStrips2D(links, colors=style.LINK, radii=0.05, draw_order=32.0))
    nodes = [f"room {region}: {area_m2:.2f} m2" for region, area_m2 in enumerate(initial.area_m2)]
    doors = [f"door {door}: {width_m:.2f} m" for door, width_m in zip(initial.door, initial.width_m, strict=True)]
    rooms = rr.Points2D(
        pixels(initial.centre), colors=style.NODE, radii=0.4, labels=nodes, show_labels=False, draw_order=34.0
    )
    scene.log("map/initial/rooms", rooms)
    middles = rr.Points2D(
        pixels(middle), colors=style.EDGE_MIDDLE, radii=0.2, labels=doors, show_labels=False, draw_order=33.0
    )
    scene.log("map/initial/doors", middles)

    names = [f"r{region}" for region in range(regions)]
    door_names = [f"d{door}" for door in initial.door]
    place = np.concatenate([pixels(initial.centre), pixels(middle)]) * spread(initial.frame.width)
    colours = [style.NODE] * regions + [style.EDGE_MIDDLE] * len(door_names)
    sizes = [6.0] * regions + [3.0] * len(door_names)
    links_by_name = [
        (names[region], door_names[edge])
        for edge, region in zip(initial.border_edge, initial.border_region, strict=True)
    ]
    scene.log(
        "graph/initial",
        rr.GraphNodes(
            [*names, *door_names], positions=place, colors=colours, radii=sizes, labels=[*names, *door_names]
        ),
        rr.GraphEdges(links_by_name),
    )


def draw_generation(scene: Scene, generation: Generation) -> None:
    """Draw the cost and its terms, and the doors that the best string keeps and removes."""
    scene.at(generation=generation.number)
    scene.remembered["generations"] = generation.number
    for name, colour in COSTS.items():
        scene.log(f"plots/search/{name}", rr.Scalars(getattr(generation, f"{name}_cost")))
        if generation.number == 0:
            scene.keep(f"plots/search/{name}", rr.SeriesLines(colors=colour, names=f"{name} cost"))
    for name, label in TERMS.items():
        scene.log(f"plots/terms/{name}", rr.Scalars(float(getattr(generation, name))))
        if generation.number == 0:
            scene.keep(f"plots/terms/{name}", rr.SeriesLines(names=label))
    initial: InitialMap = scene.remembered["initial_map"]
    kept = ~generation.removed
    for name, chosen, colour, radius in (("kept", kept, style.KEPT, 0.2), ("removed", ~kept, style.REMOVED, 0.06)):
        lines = strips(initial.start[chosen], initial.end[chosen])
        scene.log(f"map/search/{name}", rr.LineStrips2D(lines, colors=colour, radii=radius, draw_order=36.0))


def draw_edits(scene: Scene, edits: Edits) -> None:
    """Draw the places of edits on the input map, and the table of edits."""
    table(scene, edits, "edit")
    frame = scene.remembered.get("input")
    if frame is None:  # lost from a damaged recording
        return
    kinds, codes = tuple(FORMS), zip(edits.kind.tolist(), edits.verdict.tolist(), strict=True)
    labels = [f"{kinds[kind]}: {VERDICTS[verdict]}" for kind, verdict in codes]
    lines = np.isfinite(edits.end_m).all(axis=1)
    size = max(frame.height, frame.width) / 400
    start, end = frame.cell_from_world(edits.start_m), frame.cell_from_world(edits.end_m)
    options: dict[str, Any] = {"colors": style.EDIT, "show_labels": False, "draw_order": 23.0}
    scene.log("rooms/edits/places", rr.Points2D(pixels(start), radii=size, labels=labels, **options))
    strokes = rr.LineStrips2D(
        strips(start[lines], end[lines]), radii=size / 2, labels=np.array(labels)[lines].tolist(), **options
    )
    scene.log("rooms/edits/lines", strokes)


def draw_map(scene: Scene, topology: TopologicalMap) -> None:
    """Draw rooms and doors at the input's resolution, and the graph."""
    frame, rooms, ids = topology.frame, topology.rooms, np.array(topology.room_ids, np.int64)
    scene.keep("rooms/labels", classes(classes_of({room.id: room.title for room in rooms})))
    scene.raster("rooms/labels", as_classes(topology.labels), order=1.0, opacity=0.85)
    start, end = frame.cell_from_world(topology.start_m), frame.cell_from_world(topology.end_m)
    middle = (start + end) / 2
    size = max(frame.height, frame.width) / 400
    widths = [f"door {row + 1}: {width_m:.2f} m" for row, width_m in enumerate(topology.width_m)]
    doors = rr.LineStrips2D(
        strips(start, end), colors=style.KEPT, radii=size, labels=widths, show_labels=False, draw_order=20.0
    )
    scene.log("rooms/doors", doors)
    ends = np.searchsorted(ids, np.concatenate([topology.room_a, topology.room_b]))
    links = strips(topology.centre[ends], np.concatenate([middle, middle]))
    scene.log("rooms/graph/links", rr.LineStrips2D(links, colors=style.LINK, radii=size / 3, draw_order=21.0))
    labels = [f"{room.title}: {room.area_m2:.1f} m2" for room in rooms]
    nodes = rr.Points2D(pixels(topology.centre), colors=style.NODE, radii=size * 2, labels=labels, draw_order=22.0)
    scene.log("rooms/graph/nodes", nodes)

    names = [str(room.id) for room in rooms]
    joined = [(str(a), str(b)) for a, b in zip(topology.room_a.tolist(), topology.room_b.tolist(), strict=True)]
    place = pixels(topology.centre) * spread(frame.width)
    scene.log(
        "graph/final",
        rr.GraphNodes(
            names,
            positions=place,
            radii=8.0,
            labels=[room.title for room in rooms],
            colors=[style.room(room.id) for room in rooms],
        ),
        rr.GraphEdges(joined),
    )


def as_classes(labels: NDArray[np.int32]) -> NDArray[np.uint8] | NDArray[np.uint16]:
    """Labels as class numbers in the smallest type that holds them; numbers wrap around above 65,535."""
    if labels.max(initial=0) <= MOST_IN_A_BYTE:
        return labels.astype(np.uint8)
    return labels.astype(np.uint16)


def room_classes(count: int) -> dict[int, tuple[str, tuple[int, ...]]]:
    """Name and colour of labels 0 to `count`."""
    return classes_of({room: f"room {room}" for room in range(1, count + 1)})


def classes_of(titles: Mapping[int, str]) -> dict[int, tuple[str, tuple[int, ...]]]:
    """Name and colour of labels, numbered as by `as_classes`, from the titles of their rooms."""
    return {room % 2**16: (title, style.room(room)) for room, title in titles.items()} | {0: ("no room", style.CLEAR)}


def spread(width: int) -> float:
    """Scale that makes a map about a thousand units wide, so that the labels of its graph do not overlap."""
    return 1000.0 / max(width, 1)
