"""JSON: the whole result as one node-link document; `graph.schema.json` beside this file is its JSON Schema."""

from __future__ import annotations

import dataclasses
import json
from importlib import resources
from typing import Any

from vdoor.export.checks import refuse_not_finite
from vdoor.topology import Door, Room, TopologicalMap

VERSION = 1


def to_json(topology: TopologicalMap) -> str:
    """Rooms as nodes, doors as edges, points as [x, y] in metres of the map frame.

    `networkx.node_link_graph(document, edges="edges")` makes a MultiGraph of it. The version goes up when a field
    changes its meaning or goes; fields may be added within a version.
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
    """The JSON Schema (draft 2020-12) of what `to_json` gives."""
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
