"""`vdoor cover`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from vdoor.cli.navigate import (
    PLACE,
    Avoid,
    Closed,
    Radius,
    Running,
    Save,
    Source,
    done_on,
    path_exports,
)
from vdoor.cli.options import Force, Json, MaxCells, Preset, Resolution, Seed, Set, Unknown, print_json
from vdoor.config import DEFAULT_PRESET
from vdoor.errors import SettingError, say
from vdoor.navigate import LEAVE, ROBOT_RADIUS_M, TOOL_M, TRADE


def cover(
    source: Source,
    *,
    room: Annotated[
        list[str] | None, typer.Option("--room", metavar="ROOM", help="Room to sweep; repeatable; default: all rooms.")
    ] = None,
    keep_order: Annotated[bool, typer.Option("--order", help="Sweep the rooms in the order given by --room.")] = False,
    unit: Annotated[str, typer.Option(help="Sweep room by room (room), or the map as one (map).")] = "room",
    start: Annotated[
        str, typer.Option(metavar="PLACE", help=f"Where to begin: {PLACE}; default: the charger or the largest room.")
    ] = "",
    end: Annotated[str, typer.Option(metavar="PLACE", help=f"Where to end: {PLACE}; default: anywhere.")] = "",
    back: Annotated[bool, typer.Option("--return", help="End at the start.")] = False,
    avoid: Avoid = None,
    closed: Closed = None,
    mop: Annotated[bool, typer.Option("--mop", help="Keep out of the map's no-mop areas.")] = False,
    robot_radius: Radius = ROBOT_RADIUS_M,
    tool_width: Annotated[float, typer.Option(min=0.01, max=10, metavar="M", help="Width that is swept.")] = TOOL_M,
    leave: Annotated[
        float, typer.Option(min=0, max=1, help="Share that may stay uncovered for a shorter path.")
    ] = LEAVE,
    tau: Annotated[
        float, typer.Option(min=0, max=1, help="Area given up per area saved in length: 0 sweeps all it can.")
    ] = TRADE,
    speed: Annotated[float, typer.Option(min=0.001, max=10, metavar="M/S", help="Speed of the robot.")] = 0.3,
    turn_rate: Annotated[float, typer.Option(min=0.001, max=100, metavar="RAD/S", help="Its speed in turns.")] = 1.5,
    export: Annotated[
        list[str] | None,
        typer.Option(
            metavar="FORMAT=FILE",
            help="The path as csv, geojson or waypoints; fields, lanes: opennav_coverage; zones: Valetudo. Repeatable.",
        ),
    ] = None,
    save: Save = None,
    mcap: Annotated[Path | None, typer.Option(metavar="FILE.mcap", help="Recording of the run with the path.")] = None,
    preset: Preset = DEFAULT_PRESET,
    set_: Set = None,
    seed: Seed = 0,
    resolution: Resolution = None,
    unknown_value: Unknown = None,
    max_cells: MaxCells = 100_000_000,
    force: Force = False,
    as_json: Json = False,
) -> None:
    """Plan a path whose tool sweeps rooms: along the walls, in lanes between, one room after the other."""
    from vdoor.explain.coverage import document_of, figures
    from vdoor.export.coverage_files import COVERAGE_WRITERS
    from vdoor.export.paths import PATH_WRITERS, DrivenPath
    from vdoor.navigate.cover_floor import BACK, Coverage, CoverFloor
    from vdoor.outputs import Outputs

    if back and end:
        raise SettingError("--return: wanted no --end beside it, found one")
    if keep_order and not room:
        raise SettingError("--order: wanted the rooms in order, by --room, found none")
    outputs = Outputs(save=save, mcap=mcap, force=force)
    formats = [*PATH_WRITERS, *COVERAGE_WRITERS]
    exports = path_exports(export or (), formats, outputs, source, force=force)
    task = CoverFloor(
        unit=unit,
        rooms=tuple(room or ()),
        ordered=keep_order,
        avoid=tuple(avoid or ()),
        closed=tuple(closed or ()),
        start=start,
        end=BACK if back else end,
        mops=mop,
        radius_m=robot_radius,
        tool_m=tool_width,
        trade=tau,
        leave=leave,
        speed_m_s=speed,
        turn_rad_s=turn_rate,
    )
    running = Running(
        preset=preset, assignments=set_, seed=seed, resolution_m=resolution, unknown=unknown_value, max_cells=max_cells
    )
    found, topology = done_on(source, "cover", task, running, outputs)
    assert isinstance(found, Coverage)
    for number in found.missed.tolist():
        say(f"note: {topology.room(number).title}: out of reach of a robot with a radius of {robot_radius:g} m")
    if as_json:
        print_json(document_of(found))
    else:
        for name, value in figures(found):
            print(f"{name:16}{value}")
        for number, done_s in zip(found.visit_room.tolist(), found.visit_done_s.tolist(), strict=True):
            print(f"{topology.room(number).title if number else 'all rooms'}: done after {done_s:.0f} s")
    properties = {"length_m": found.length_m, "radius_m": found.radius_m, "tool_m": found.tool_m}
    driven = DrivenPath(found.point_m, found.yaw_rad, properties)
    for item in exports:
        of_path = PATH_WRITERS.get(item.name)
        item.write(of_path(driven) if of_path else COVERAGE_WRITERS[item.name](found, topology))
