"""Exports: one file per format, and the list of them.

>>> import vdoor, vdoor.export
>>> topology = vdoor.run(vdoor.read_map("recordings/flat.yaml"))
>>> text = vdoor.export.to_geojson(topology)
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

from vdoor.editing.lookup import find_room
from vdoor.errors import SettingError, no_such
from vdoor.export.geojson import to_geojson
from vdoor.export.graphs import to_graphml, to_json
from vdoor.export.nav2_route import to_nav2_route
from vdoor.export.raster import SUFFIXES, Raster, to_keepout, to_labels
from vdoor.export.report import to_report
from vdoor.export.rmf import to_rmf
from vdoor.export.svg import to_svg
from vdoor.export.virtual_walls import to_virtual_walls
from vdoor.files import refuse_existing
from vdoor.partial import together
from vdoor.results.reading import Finished, files_of, read_finished
from vdoor.topology import TopologicalMap

__all__ = [
    "WRITERS",
    "Export",
    "Finished",
    "Raster",
    "Writer",
    "files_of",
    "read_finished",
    "refuse_files",
    "save",
    "to_geojson",
    "to_graphml",
    "to_json",
    "to_keepout",
    "to_labels",
    "to_nav2_route",
    "to_report",
    "to_rmf",
    "to_svg",
    "to_virtual_walls",
    "writer_named",
]


class Writer(NamedTuple):
    """One format: its name, its function, the function's arguments besides the map, and whether it needs rooms."""

    name: str
    write: Callable[..., str | Raster]
    takes: tuple[str, ...] = ()
    image: bool = False
    needs_rooms: bool = False


WRITERS = (
    Writer("nav2-route", to_nav2_route, takes=("annotations", "radius_m")),
    Writer("graphml", to_graphml),
    Writer("json", to_json),
    Writer("geojson", to_geojson),
    Writer("labels", to_labels, image=True),
    Writer("keepout", to_keepout, takes=("rooms", "annotations"), image=True, needs_rooms=True),
    Writer("virtual-walls", to_virtual_walls, takes=("rooms", "annotations")),
    Writer("rmf", to_rmf),
    Writer("svg", to_svg),
    Writer("report", to_report, takes=("provenance", "annotations")),
)


def writer_named(name: str) -> Writer:
    """The format of a name; `SettingError` if there is none."""
    for writer in WRITERS:
        if writer.name == name:
            return writer
    raise SettingError(f"format: {no_such('format', name, (writer.name for writer in WRITERS))}")


@dataclass(frozen=True)
class Export:
    """One requested export. Without a path its text goes to stdout.

    Raises `SettingError` at once if format, path and rooms do not go together.
    """

    writer: Writer
    path: Path | None = None
    rooms: tuple[int | str, ...] = ()
    """Rooms by id, or as text by id, name or place."""
    radius_m: float | None = None
    """The robot's radius; the format's own default if None."""

    def __post_init__(self) -> None:
        """Check what does not need the map."""
        name = self.writer.name
        if self.rooms and "rooms" not in self.writer.takes:
            takers = " or ".join(writer.name for writer in WRITERS if "rooms" in writer.takes)
            raise SettingError(f"--room: wanted the format {takers}, found {name}")
        if self.radius_m is not None and "radius_m" not in self.writer.takes:
            raise SettingError(f"--robot-radius: wanted the format nav2-route, found {name}")
        if self.writer.needs_rooms and not self.rooms:
            raise SettingError(f"{name}: wanted the rooms to keep open (--room of `vdoor export`), found none")
        if self.writer.image and self.path is None:
            raise SettingError(f"{name}: wanted a file to write the image to, found none")
        if self.writer.image and self.path and self.path.suffix.lower() not in SUFFIXES:
            raise SettingError(f"{name}: wanted a file name ending in {' or '.join(SUFFIXES)}: {self.path}")

    @classmethod
    def parse(cls, text: str) -> Export:
        """Export from FORMAT=FILE; `SettingError` for any other text."""
        name, equals, path = text.partition("=")
        if not equals or not path:
            raise SettingError(f"--export: wanted FORMAT=FILE, found {text!r}")
        return cls(writer_named(name), Path(path))

    @property
    def files(self) -> list[Path]:
        """Files that will be written; an image has a YAML beside it."""
        if self.path is None:
            return []
        return [self.path, self.path.with_suffix(".yaml")] if self.writer.image else [self.path]

    @property
    def takes_provenance(self) -> bool:
        """Whether the format shows the run behind the map, see `read_finished`."""
        return "provenance" in self.writer.takes

    def content(self, finished: Finished) -> str | Raster:
        """Text or image; `VdoorError` if the map cannot be written in this format."""
        rooms = tuple(_room_id(finished.topology, room) for room in self.rooms)
        choices: dict[str, object] = {
            "rooms": rooms,
            "provenance": finished.provenance,
            "annotations": finished.annotations,
        }
        choices |= {} if self.radius_m is None else {"radius_m": self.radius_m}
        taken = {name: value for name, value in choices.items() if name in self.writer.takes}
        return self.writer.write(finished.topology, **taken)

    def contents(self, content: str | Raster) -> list[tuple[Path, bytes]]:
        """The files to write, with their bytes."""
        if self.path is None:
            raise SettingError(f"{self.writer.name}: wanted a file to write, found none")
        return content.files(self.path) if isinstance(content, Raster) else [(self.path, content.encode())]

    def put(self, content: str | Raster, *, force: bool = True) -> list[Path]:
        """Write the files, all or none; `VdoorError` if they cannot be written, or exist and not `force`."""
        files = self.contents(content)
        with together() as staged:
            for path, data in files:
                staged.add(path, data, force=force)
        return [path for path, _ in files]

    def write(self, finished: Finished, *, force: bool = True) -> list[Path]:
        """Write the files of a map; `VdoorError` if the map has no such format or the files cannot be written."""
        return self.put(self.content(finished), force=force)


def _room_id(topology: TopologicalMap, room: int | str) -> int:
    return room if isinstance(room, int) else find_room(topology, room, what="--room").room.id


def refuse_files(exports: Iterable[Export], *, force: bool, read: Iterable[Path] = ()) -> None:
    """Raise `VdoorError` if an export would overwrite a file without `force`, or, even with it, one of `read`."""
    refuse_existing((path for export in exports for path in export.files), force=force, reads=read)


def save(
    topology: TopologicalMap, path: str | Path, to: str, *, rooms: Sequence[int | str] = (), force: bool = False
) -> list[Path]:
    """Write one format (a name in `WRITERS`) to a file and return the files written.

    Raises `VdoorError` if the map cannot be written in this format, or if a file exists and `force` is not set.
    """
    export = Export(writer_named(to), Path(path), tuple(map(str, rooms)))
    refuse_files([export], force=force)
    return export.write(Finished(topology), force=force)
