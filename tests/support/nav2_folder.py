"""A reader of a folder for Nav2 that refuses what Nav2's servers refuse when they read their parameters and files."""

from __future__ import annotations

import ast
import warnings
from pathlib import Path
from typing import Any, NamedTuple

import nav2_loader
import yaml
from nav2_loader import RefusedError

import vdoor
from vdoor.grid import OccupancyGrid

FILTERS = {"nav2_costmap_2d::KeepoutFilter": (0,), "nav2_costmap_2d::SpeedFilter": (1, 2)}
"""The types of filter info that each filter takes."""
OPERATIONS = {f"nav2_route::{name}" for name in ("AdjustSpeedLimit", "ReroutingService", "TriggerEvent")}
SCORERS = {"nav2_route::DistanceScorer", "nav2_route::SemanticScorer"}


class Folder(NamedTuple):
    """What Nav2 would know."""

    graph: nav2_loader.Graph
    masks: dict[str, OccupancyGrid]
    """By name of the filter's plugin."""
    speed: tuple[float, float]
    """Base and multiplier of the speed filter."""
    scorer: dict[str, Any]
    started: set[str]
    """Names of the servers that the launch file starts."""


def read(folder: Path) -> Folder:
    """What is in a folder."""
    tables = yaml.safe_load((folder / "nav2.yaml").read_text())
    servers = {name: table["ros__parameters"] for name, table in tables.items() if name != "global_costmap"}
    costmap = tables["global_costmap"]["global_costmap"]["ros__parameters"]
    masks, speed = {}, (0.0, 1.0)
    for name in costmap["filters"]:
        plugin, info = costmap[name]["plugin"], _info(servers, costmap[name]["filter_info_topic"])
        if info["type"] not in FILTERS[plugin]:
            raise RefusedError(f"{plugin} takes no filter of type {info['type']}")
        if plugin.endswith("SpeedFilter"):
            speed = info["base"], info["multiplier"]
        elif (info["base"], info["multiplier"]) != (0.0, 1.0):
            raise RefusedError("a keepout filter keeps base and multiplier")
        masks[plugin] = _mask(servers, info["mask_topic"])
    route = servers["route_server"]
    graph = nav2_loader.load(Path(route["graph_filepath"]).read_text())
    _plugins(route, "operations", OPERATIONS)
    _plugins(route, "edge_cost_functions", SCORERS)
    called = {kind for edge in graph.edges for kind, _, _ in edge.operations}
    if not called <= set(route["operations"]):
        raise RefusedError("an operation of the graph is not loaded")
    for kind in route["SemanticScorer"]["semantic_classes"]:
        _of(float, route["SemanticScorer"][kind])
    return Folder(graph, masks, speed, route["SemanticScorer"], _started(folder / "vdoor.launch.py"))


def _plugins(route: dict[str, Any], key: str, known: set[str]) -> None:
    for name in route[key]:
        if route[name]["plugin"] not in known:
            raise RefusedError(f"no plugin {name}")


def _info(servers: dict[str, Any], topic: str) -> dict[str, Any]:
    """The parameters of the filter info that comes on a topic, with the types that the server declares."""
    (info,) = [table for table in servers.values() if table.get("filter_info_topic") == topic]
    _of(int, info["type"])
    _of(float, info["base"])
    _of(float, info["multiplier"])
    return info


def _mask(servers: dict[str, Any], topic: str) -> OccupancyGrid:
    (mask,) = [table for table in servers.values() if table.get("topic_name") == topic]
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", vdoor.MapWarning)  # the note on a map that lies askew
        return vdoor.read_map(mask["yaml_filename"])


def _of(kind: type, value: object) -> None:
    """A ROS parameter that is declared with a type takes no other, an integer for a double included."""
    if type(value) is not kind:
        raise RefusedError(f"wanted {kind.__name__}, found {value!r}")


def _started(path: Path) -> set[str]:
    """The names of nodes in a launch file, which has to be Python."""
    tree = ast.parse(path.read_text())
    texts = [one.value for one in ast.walk(tree) if isinstance(one, ast.Constant) and isinstance(one.value, str)]
    masks = next(one.value for one in ast.walk(tree) if isinstance(one, ast.Assign) and one.targets[0].id == "MASKS")  # type: ignore[attr-defined]
    started = {f"vdoor_{mask}{rest}" for mask in ast.literal_eval(masks) for rest in texts if rest.startswith("_")}
    return started | {text for text in texts if text == "route_server"}
