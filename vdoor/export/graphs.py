"""The topological map as a graph: GraphML for graph programs, and a node-link document in JSON with a JSON Schema."""

from __future__ import annotations

import dataclasses
import io
import json
from importlib import resources
from operator import itemgetter
from typing import Any

from vdoor.export.geometry import refuse_not_finite
from vdoor.topology import Door, Room, TopologicalMap

VERSION = 1


def to_graphml(topology: TopologicalMap) -> str:
    """Rooms as nodes and doors as keyed edges; each point is two attributes, as GraphML has no lists.

    `networkx.read_graphml(file, node_type=int, force_multigraph=True)` reads it back.
    """
    refuse_not_finite(topology)
    source = topology.to_networkx()
    import networkx as nx  # noqa: PLC0415  # a seventh of a second

    graph: nx.MultiGraph[int] = nx.MultiGraph()
    for room, fields in source.nodes(data=True):
        graph.add_node(room, **_flat(fields))
    for one, other, door, fields in sorted(source.edges(keys=True, data=True), key=itemgetter(2)):
        graph.add_edge(one, other, key=door, **_flat(fields))
    buffer = io.BytesIO()
    nx.write_graphml_xml(graph, buffer)
    return buffer.getvalue().decode() + "\n"


def _flat(fields: dict[str, Any]) -> dict[str, Any]:
    """Fields with each point split in two: `centre_m` becomes `centre_x_m` and `centre_y_m`."""
    flat: dict[str, Any] = {}
    for name, value in fields.items():
        if isinstance(value, tuple):
            stem = name.removesuffix("_m")
            flat[f"{stem}_x_m"], flat[f"{stem}_y_m"] = value
        else:
            flat[name] = value
    return flat


def to_json(topology: TopologicalMap) -> str:
    """Rooms as nodes, doors as edges, points as [x, y] in metres of the map frame.

    `networkx.node_link_graph(document, edges="edges")` makes it a MultiGraph. The version increases when a field is
    removed or changes its meaning; fields may be added within a version.
    """
    refuse_not_finite(topology)
    frame = topology.frame
    document = {
        "format": "vdoor-graph",
        "version": VERSION,
        "directed": False,
        "multigraph": True,
        "graph": {
            "frame": "map",
            "resolution_m": frame.resolution_m,
            "size": {"width": frame.width, "height": frame.height},
            "origin": {"x_m": frame.x_m, "y_m": frame.y_m, "yaw_rad": frame.yaw_rad},
        },
        "nodes": [_node(room) for room in topology.rooms],
        "edges": [_edge(door) for door in topology.doors],
    }
    return json.dumps(document, indent=1, allow_nan=False) + "\n"


def schema() -> dict[str, Any]:
    """JSON Schema (draft 2020-12) of the document from `to_json`."""
    text = resources.files("vdoor.export").joinpath("graph.schema.json").read_text("utf-8")
    document: dict[str, Any] = json.loads(text)
    return document


def _node(room: Room) -> dict[str, Any]:
    corners = [{"point_m": corner.point_m, "kind": "convex" if corner.convex else "concave"} for corner in room.corners]
    return dataclasses.asdict(room) | {"corners": corners}


def _edge(door: Door) -> dict[str, Any]:
    fields = dataclasses.asdict(door)
    source, target = fields.pop("rooms")
    return {"source": source, "target": target, "key": fields.pop("id"), **fields}
