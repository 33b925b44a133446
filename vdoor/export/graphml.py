"""GraphML: the graph alone, for graph programs."""

from __future__ import annotations

import io
from operator import itemgetter
from typing import Any

import networkx as nx

from vdoor.export.checks import refuse_not_finite
from vdoor.topology import TopologicalMap


def to_graphml(topology: TopologicalMap) -> str:
    """Rooms as nodes and doors as keyed edges, their points as two columns each: GraphML holds no lists.

    `networkx.read_graphml(file, node_type=int, force_multigraph=True)` gives it back.
    """
    refuse_not_finite(topology)
    source = topology.to_networkx()
    graph: nx.MultiGraph[int] = nx.MultiGraph()
    for room, fields in source.nodes(data=True):
        graph.add_node(room, **_flat(fields))
    for one, other, door, fields in sorted(source.edges(keys=True, data=True), key=itemgetter(2)):
        graph.add_edge(one, other, key=door, **_flat(fields))
    buffer = io.BytesIO()
    nx.write_graphml_xml(graph, buffer)
    return buffer.getvalue().decode() + "\n"


def _flat(fields: dict[str, Any]) -> dict[str, Any]:
    """Fields with each point, say `centre_m`, as `centre_x_m` and `centre_y_m`."""
    flat: dict[str, Any] = {}
    for name, value in fields.items():
        if isinstance(value, tuple):
            stem = name.removesuffix("_m")
            flat[f"{stem}_x_m"], flat[f"{stem}_y_m"] = value
        else:
            flat[name] = value
    return flat
