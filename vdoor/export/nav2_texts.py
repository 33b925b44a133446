"""The launch file and the README in a folder for Nav2."""

from __future__ import annotations

from collections.abc import Sequence

from vdoor.topology import TopologicalMap

LAUNCH = '''"""Starts the servers for the files beside this one; written by vdoor."""

from pathlib import Path

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument
from launch.conditions import IfCondition
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node

HERE = Path(__file__).resolve().parent
PARAMETERS = str(HERE / "nav2.yaml")
MASKS = {masks}


def server(package, executable, name, condition=None, **parameters):
    return Node(
        package=package,
        executable=executable,
        name=name,
        output="screen",
        parameters=[PARAMETERS, parameters],
        condition=condition,
    )


def manager(name, nodes, condition=None):
    return server(
        "nav2_lifecycle_manager", "lifecycle_manager", name, condition, autostart=True, node_names=nodes
    )


def generate_launch_description():
    route = IfCondition(LaunchConfiguration("route_server"))
    graph = str(HERE / "route.geojson")
    nodes = [
        DeclareLaunchArgument("route_server", default_value="true", description="Start a route server."),
        server("nav2_route", "route_server", "route_server", route, graph_filepath=graph),
        manager("lifecycle_manager_vdoor_route", ["route_server"], route),
    ]
    names = []
    for mask in MASKS:
        names += [f"vdoor_{{mask}}_mask_server", f"vdoor_{{mask}}_info_server"]
        image = str(HERE / f"{{mask}}.yaml")
        nodes.append(server("nav2_map_server", "map_server", names[-2], yaml_filename=image))
        nodes.append(server("nav2_map_server", "costmap_filter_info_server", names[-1]))
    nodes.append(manager("lifecycle_manager_vdoor_masks", names))
    return LaunchDescription(nodes)
'''

README = """# {rooms} for Nav2

Written by vdoor. What is in it was checked against the code by which Nav2 reads it; Nav2 itself was not run.

1. Copy the block `global_costmap` of `nav2.yaml` into the parameters of your robot. If there is a list `filters`
   already, add the names to it.
2. Start Nav2 as always, and beside it:

       ros2 launch ./vdoor.launch.py

   If your Nav2 starts a route server itself, give that one the graph (`graph:=` of `bringup_launch.py`), and add
   `route_server:=false` here.
3. Ask for a route from room {first} to room {last}:

       ros2 action send_goal /compute_route nav2_msgs/action/ComputeRoute \\
         "{{start_id: {first}, goal_id: {last}, use_start: true, use_poses: false}}"

| file | is |
|---|---|
| `route.geojson` | the route graph; the id of a room's node is the room's |
| `keepout.pgm`, `keepout.yaml` | black where the robot must not go |
{speed}| `nav2.yaml` | parameters of the servers that `vdoor.launch.py` starts, and of the global costmap |
{doors}"""
SPEED = "| `speed.pgm`, `speed.yaml` | speed limits in per cent, 0 for none; edges of the graph have them as well |\n"
DOORS = """
The service `{service}` (std_srvs/Trigger) is called when the robot sets out for a door; it ends the route if it fails.
"""


def launch_file(masks: Sequence[str]) -> str:
    """A ROS 2 launch file for the servers of the graph and of some masks, which lie beside it."""
    return LAUNCH.format(masks=list(masks)).replace("'", '"')


def readme(topology: TopologicalMap, masks: Sequence[str], *, door_service: str) -> str:
    """What to do with the folder, in three steps."""
    rooms = topology.room_ids
    return README.format(
        rooms=f"{len(rooms)} room{'s' * (len(rooms) != 1)}",
        first=rooms[0],
        last=rooms[-1],
        speed=SPEED if "speed" in masks else "",
        doors=DOORS.format(service=door_service) if door_service else "",
    )
