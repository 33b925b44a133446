"""SVG: a picture of the rooms and doors, to look at or to print."""

from __future__ import annotations

import math
import xml.etree.ElementTree as ET  # written here, never read

import numpy as np
from numpy.typing import NDArray

from vdoor.export.geometry import Point, line_m, refuse_not_finite
from vdoor.topology import Door, Room, TopologicalMap
from vdoor.viz.rerun import style

LONGEST_PX = 1000
MARGIN = 0.03
"""Of the longer side."""
TEXT = {"text-anchor": "middle", "dominant-baseline": "central", "font-family": "sans-serif"}


def to_svg(topology: TopologicalMap) -> str:
    """Rooms in their colours with id and area, doors as lines with ids; each tells its sizes under the pointer.

    Drawn as the map's image stands, in metres from its upper left corner, however the map frame lies. Elements are
    called `room-1`, `door-1`, and so on.
    """
    refuse_not_finite(topology)
    left, top, width, height = _extent_m(topology)
    longest = max(width, height)
    root = ET.Element(
        "svg",
        xmlns="http://www.w3.org/2000/svg",
        viewBox=" ".join(map(_text, (left, top, width, height))),
        width=_text(width / longest * LONGEST_PX),
        height=_text(height / longest * LONGEST_PX),
    )
    ET.SubElement(root, "rect", _place(left, top) | {"width": "100%", "height": "100%", "fill": "white"})
    rooms, doors, names = (ET.SubElement(root, "g", id=name) for name in ("rooms", "doors", "names"))
    for room in topology.rooms:
        _add_room(rooms, topology, room, longest)
        _add_name(names, topology, room, longest)
    for door in topology.doors:
        _add_door(doors, topology, door, longest)
    ET.indent(root, " ")
    return ET.tostring(root, encoding="unicode") + "\n"


def _add_room(group: ET.Element, topology: TopologicalMap, room: Room, longest: float) -> None:
    rings = (_drawn(topology, ring[:-1]) for ring in room.polygon_m)
    path = " ".join("M" + " ".join(f"{_text(x)},{_text(y)}" for x, y in ring.tolist()) + "Z" for ring in rings)
    fill = {"fill": _rgb(style.room(room.id)), "fill-rule": "evenodd"}
    stroke = {"stroke": _rgb(style.OCCUPIED), "stroke-width": _text(longest / 800)}
    shape = ET.SubElement(group, "path", {"id": f"room-{room.id}", "d": path} | fill | stroke)
    ET.SubElement(shape, "title").text = f"{_called(room)}: {room.area_m2:.1f} m2"


def _add_name(group: ET.Element, topology: TopologicalMap, room: Room, longest: float) -> None:
    """Id, or name and id, and area in the middle of the room, no larger than it can hold."""
    size = min(longest / 40, math.sqrt(room.area_m2) / 4)
    ((x, y),) = _drawn(topology, (room.centre_m,)).tolist()
    area = f"{room.area_m2:.1f} m²"
    first, second = (room.name, f"{room.id}: {area}") if room.name else (str(room.id), area)
    for text, scale, below in ((first, 8 / max(8, len(first)), -0.4), (second, 0.6, 0.5)):
        look = TEXT | {"font-size": _text(scale * size), "pointer-events": "none"}
        ET.SubElement(group, "text", _place(x, y + below * size) | look).text = text


def _add_door(group: ET.Element, topology: TopologicalMap, door: Door, longest: float) -> None:
    """The door's line, and its id beside the line's middle, at the side towards the top or the left."""
    (x1, y1), (x2, y2) = _drawn(topology, line_m(topology, door)).tolist()
    colour = _rgb(style.KEPT)
    about = ET.SubElement(group, "g", id=f"door-{door.id}")
    ends = {"x1": _text(x1), "y1": _text(y1), "x2": _text(x2), "y2": _text(y2)}
    stroke = {"stroke": colour, "stroke-width": _text(longest / 250), "stroke-linecap": "round"}
    ET.SubElement(about, "line", ends | stroke)
    aside = longest / 70
    along = math.hypot(x2 - x1, y2 - y1)
    right, down = (y2 - y1) / along * aside, (x1 - x2) / along * aside
    if right + down > 0:
        right, down = -right, -down
    middle = _place((x1 + x2) / 2 + right, (y1 + y2) / 2 + down)
    ET.SubElement(about, "text", middle | TEXT | {"font-size": _text(longest / 70), "fill": colour}).text = str(door.id)
    one, other = door.rooms
    told = f"door {door.id}: {door.width_m:.2f} m, {door.kind}, rooms {one} and {other}"
    ET.SubElement(about, "title").text = told


def _called(room: Room) -> str:
    return f"{room.name}, room {room.id}" if room.name else f"room {room.id}"


def _extent_m(topology: TopologicalMap) -> tuple[float, float, float, float]:
    """Left, top, width and height of what has rooms, and a margin."""
    cells = np.argwhere(topology.labels)
    top_left, size = cells.min(axis=0), np.ptp(cells, axis=0) + 1
    margin = MARGIN * size.max()
    top_m, left_m = ((top_left - margin) * topology.frame.resolution_m).tolist()
    height_m, width_m = ((size + 2 * margin) * topology.frame.resolution_m).tolist()
    return left_m, top_m, width_m, height_m


def _drawn(topology: TopologicalMap, points_m: tuple[Point, ...]) -> NDArray[np.float64]:
    """Points of the map frame as x to the right and y down (k, 2), metres from the image's upper left corner."""
    row_col = topology.frame.cell_from_world(np.array(points_m)) + 0.5
    return np.asarray(row_col[:, ::-1] * topology.frame.resolution_m)


def _place(x: float, y: float) -> dict[str, str]:
    return {"x": _text(x), "y": _text(y)}


def _text(number: float) -> str:
    """A number to a tenth of a millimetre, without idle zeros."""
    return f"{number:.4f}".rstrip("0").rstrip(".")


def _rgb(colour: style.Colour) -> str:
    return "#{:02x}{:02x}{:02x}".format(*colour)
