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

from vdoor.errors import SettingError
from vdoor.export.geojson import to_geojson
from vdoor.export.graphs import to_graphml, to_json
from vdoor.export.nav2_route import to_nav2_route
from vdoor.export.raster import SUFFIXES, Raster, to_keepout, to_labels
from vdoor.export.report import to_report
from vdoor.export.rmf import to_rmf
from vdoor.export.svg import to_svg
from vdoor.export.virtual_walls import to_virtual_walls
from vdoor.files import refuse_existing, write_whole
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
    """One format: its name, the function that gives it, and what that takes beside the map or cannot do without."""

    name: str
    write: Callable[..., str | Raster]
    takes: tuple[str, ...] = ()
    image: bool = False
    needs_rooms: bool = False


WRITERS = (
    Writer("nav2-route", to_nav2_route),
    Writer("graphml", to_graphml),
    Writer("json", to_json),
    Writer("geojson", to_geojson),
    Writer("labels", to_labels, image=True),
    Writer("keepout", to_keepout, takes=("rooms",), image=True, needs_rooms=True),
    Writer("virtual-walls", to_virtual_walls, takes=("rooms",)),
    Writer("rmf", to_rmf),
    Writer("svg", to_svg),
    Writer("report", to_report, takes=("provenance",)),
)


def writer_named(name: str) -> Writer:
    """The format of that name; `SettingError` where there is none."""
    for writer in WRITERS:
        if writer.name == name:
            return writer
    raise SettingError(f"format: wanted one of {', '.join(writer.name for writer in WRITERS)}, found {name!r}")


@dataclass(frozen=True)
class Export:
    """One export that was asked for; `SettingError` where its format cannot go with the rest, before anything is run.

    Without a path it is text for stdout.
    """

    writer: Writer
    path: Path | None = None
    rooms: tuple[int, ...] = ()

    def __post_init__(self) -> None:
        """Check what does not need the map."""
        name = self.writer.name
        if self.rooms and "rooms" not in self.writer.takes:
            takers = " or ".join(writer.name for writer in WRITERS if "rooms" in writer.takes)
            raise SettingError(f"--room: wanted {takers} with it, found {name}")
        if self.writer.needs_rooms and not self.rooms:
            raise SettingError(f"{name}: wanted the rooms that stay open (--room of `vdoor export`), found none")
        if self.writer.image and self.path is None:
            raise SettingError(f"{name}: wanted a file to write, found none: it is an image")
        if self.writer.image and self.path and self.path.suffix.lower() not in SUFFIXES:
            raise SettingError(f"{name}: wanted a file that ends in {' or '.join(SUFFIXES)}: {self.path}")

    @classmethod
    def parse(cls, text: str) -> Export:
        """What FORMAT=FILE asks for; `SettingError` for anything else."""
        name, equals, path = text.partition("=")
        if not equals or not path:
            raise SettingError(f"--export: wanted FORMAT=FILE, found {text!r}")
        return cls(writer_named(name), Path(path))

    @property
    def files(self) -> list[Path]:
        """The files it writes: an image comes with a YAML."""
        if self.path is None:
            return []
        return [self.path, self.path.with_suffix(".yaml")] if self.writer.image else [self.path]

    @property
    def takes_provenance(self) -> bool:
        """Whether it tells how the run came to the map, see `read_finished`."""
        return "provenance" in self.writer.takes

    def content(self, finished: Finished) -> str | Raster:
        """The text or image; `VdoorError` where this map does not have it."""
        choices = {"rooms": self.rooms, "provenance": finished.provenance}
        return self.writer.write(finished.topology, **{name: choices[name] for name in self.writer.takes})

    def put(self, content: str | Raster) -> list[Path]:
        """Write the files, each whole or not at all; `VdoorError` where they cannot be written."""
        if self.path is None:
            raise SettingError(f"{self.writer.name}: wanted a file to write, found none")
        files = content.files(self.path) if isinstance(content, Raster) else [(self.path, content.encode())]
        return [write_whole(path, data) for path, data in files]

    def write(self, finished: Finished) -> list[Path]:
        """Write the files of a map; `VdoorError` where it does not have them or they cannot be written."""
        return self.put(self.content(finished))


def refuse_files(exports: Iterable[Export], *, force: bool, read: Iterable[Path] = ()) -> None:
    """Raise `VdoorError` where an export would overwrite something without `force`, or, ever, what is `read`."""
    refuse_existing((path for export in exports for path in export.files), force=force, reads=read)


def save(
    topology: TopologicalMap, path: str | Path, to: str, *, rooms: Sequence[int] = (), force: bool = False
) -> list[Path]:
    """Write one format (a name in `WRITERS`) to a file; the files that were written.

    Raises `VdoorError` where the map does not have it, or a file exists and `force` is not given.
    """
    export = Export(writer_named(to), Path(path), tuple(rooms))
    refuse_files([export], force=force)
    return export.write(Finished(topology))
