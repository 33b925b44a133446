"""All that Nav2 needs of a map in one folder: route graph, masks, parameters, a launch file, and a README."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from vdoor.errors import SettingError
from vdoor.export.nav2_route import FULL_SPEED, to_nav2_route
from vdoor.export.nav2_texts import launch_file, readme
from vdoor.export.raster import Raster, to_keepout
from vdoor.grid import Annotations, OccupancyGrid
from vdoor.navigate import NAV2_RADIUS_M
from vdoor.topology import TopologicalMap

NARROW_M = 10.0
"""What a narrow edge costs besides its length: so much of a detour is taken to avoid it."""
KEEPOUT, SPEED_PERCENT = 0, 1
"""Types of costmap filters, as in Nav2's filter_values.hpp."""
MASK_TOPIC, INFO_TOPIC = "/vdoor/{}_mask", "/vdoor/{}_info"
"""Absolute, since the costmaps of older releases would look for others below their own name."""


@dataclass(frozen=True, kw_only=True)
class Nav2Options:
    """What is asked of the folder."""

    radius_m: float = NAV2_RADIUS_M
    rooms: tuple[int, ...] = ()
    """Ids of the rooms that stay open; empty for all."""
    speed_percent: Mapping[int, float] = field(default_factory=dict)
    """Speed limits by room id, whole numbers from 1 to 100."""
    door_service: str = ""
    """A service of type std_srvs/Trigger that opens a door; `{door}` in it stands for the door's id."""

    def __post_init__(self) -> None:
        """Check the speed limits."""
        for room, percent in self.speed_percent.items():
            if not (1 <= percent <= 100 and percent == round(percent)):  # noqa: PLR2004  # per cent
                raise SettingError(
                    f"speed limit of room {room}: wanted a whole number from 1 to 100, found {percent:g}"
                )

    @property
    def masks(self) -> tuple[str, ...]:
        """Names of the masks in the folder."""
        return ("keepout", "speed") if self.speed_percent else ("keepout",)

    def names(self) -> list[str]:
        """Names of all files in the folder."""
        images = [f"{mask}.{suffix}" for mask in self.masks for suffix in ("pgm", "yaml")]
        return ["route.geojson", *images, "nav2.yaml", "vdoor.launch.py", "README.md"]


def nav2_files(
    topology: TopologicalMap, folder: Path, options: Nav2Options, annotations: Annotations | None = None
) -> dict[str, bytes]:
    """The files by name; parameters name the others by where `folder` is.

    Raises `VdoorError` for a map without a route graph, and `SettingError` for an unknown room.
    """
    route = to_nav2_route(
        topology,
        annotations,
        radius_m=options.radius_m,
        speed_percent=options.speed_percent,
        door_service=options.door_service,
        open_rooms=options.rooms,
    )
    masks = {"keepout": to_keepout(topology, options.rooms or topology.room_ids, annotations)}
    if options.speed_percent:
        masks["speed"] = to_speed(topology, options.speed_percent)
    images = {path.name: data for name, mask in masks.items() for path, data in mask.files(Path(f"{name}.pgm"))}
    texts = {
        "nav2.yaml": yaml.safe_dump(parameters(folder, options), sort_keys=False),
        "vdoor.launch.py": launch_file(options.masks),
        "README.md": readme(topology, options.masks, door_service=options.door_service),
    }
    return {"route.geojson": route.encode()} | images | {name: text.encode() for name, text in texts.items()}


def to_speed(topology: TopologicalMap, speed_percent: Mapping[int, float]) -> Raster:
    """A mask (h, w) of speed limits in per cent, 0 where there is none; for Nav2's SpeedFilter with base 0, factor 1.

    Raises `SettingError` for an unknown room.
    """
    cells = np.zeros(topology.labels.shape, np.uint8)
    for room, percent in speed_percent.items():
        cells[topology.labels == topology.room(room).id] = round(percent)
    return Raster(cells, OccupancyGrid(cells=cells.astype(np.int8), frame=topology.frame), "raw")


def parameters(folder: Path, options: Nav2Options) -> dict[str, Any]:
    """Parameters of the nodes that `vdoor.launch.py` starts, and of the global costmap."""
    servers = {"route_server": _route_server(folder, options)}
    for mask, kind in zip(options.masks, (KEEPOUT, SPEED_PERCENT), strict=False):
        servers[f"vdoor_{mask}_mask_server"] = {
            "yaml_filename": str(folder / f"{mask}.yaml"),
            "topic_name": MASK_TOPIC.format(mask),
            "frame_id": "map",
        }
        servers[f"vdoor_{mask}_info_server"] = {
            "type": kind,
            "filter_info_topic": INFO_TOPIC.format(mask),
            "mask_topic": MASK_TOPIC.format(mask),
            "base": 0.0,
            "multiplier": 1.0,
        }
    costmap = {"global_costmap": {"ros__parameters": _filters(options.masks)}}
    return {name: {"ros__parameters": table} for name, table in servers.items()} | {"global_costmap": costmap}


def _route_server(folder: Path, options: Nav2Options) -> dict[str, Any]:
    operations = ["AdjustSpeedLimit", "ReroutingService", *(["TriggerEvent"] if options.door_service else [])]
    return {
        "route_frame": "map",
        "graph_filepath": str(folder / "route.geojson"),
        "edge_cost_functions": ["DistanceScorer", "SemanticScorer"],
        "DistanceScorer": {"plugin": "nav2_route::DistanceScorer"},
        "SemanticScorer": {
            "plugin": "nav2_route::SemanticScorer",
            "semantic_key": "class",
            "semantic_classes": ["narrow"],
            "narrow": NARROW_M / (FULL_SPEED if options.speed_percent else 1.0),  # as the DistanceScorer's lengths
        },
        "operations": operations,
        **{name: {"plugin": f"nav2_route::{name}"} for name in operations},
    }


def _filters(masks: tuple[str, ...]) -> dict[str, Any]:
    plugins = {"keepout": "nav2_costmap_2d::KeepoutFilter", "speed": "nav2_costmap_2d::SpeedFilter"}
    tables: dict[str, Any] = {
        f"vdoor_{mask}": {"plugin": plugins[mask], "enabled": True, "filter_info_topic": INFO_TOPIC.format(mask)}
        for mask in masks
    }
    if "speed" in masks:
        tables["vdoor_speed"]["speed_limit_topic"] = "/speed_limit"
    return {"filters": [*tables]} | tables
