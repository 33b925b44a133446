"""Which maps: folders, globs, lists and manifests of them, here or at any URL that fsspec opens."""

from __future__ import annotations

import glob
import posixpath
import tempfile
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from vdoor.errors import MapError, SettingError, VdoorError
from vdoor.evaluate.reference import ENDINGS, bare_name
from vdoor.files import read_regular
from vdoor.formats import READERS, reader_of

MAPS = frozenset(suffix for reader in READERS for suffix in reader.suffixes)
DESCRIPTIONS = (".yaml", ".yml")
LISTS, TABLES = (".txt",), (".csv", ".parquet")
NUMBERS = ("resolution_m", "robot_x_m", "robot_y_m")
MOST_BYTES = 1 << 28
"""Largest list or manifest: a million maps take a tenth of it."""
TRUTHS = ("_truth.json", "_truth.png")
"""What `vdoor synth` writes beside a map."""


@dataclass(frozen=True, order=True)
class Item:
    """A map, and what is known of it."""

    map: str
    """Path or URL."""
    reference: str = ""
    """Path or URL of the truth; empty if there is none."""
    resolution_m: float | None = None
    robot_x_m: float | None = None
    robot_y_m: float | None = None


def items_of(sources: Iterable[str]) -> list[Item]:
    """The maps of all sources, sorted, each once; raises `VdoorError` for a source without maps."""
    return sorted({item for source in sources for item in _items(source)}, key=_order)


def _order(item: Item) -> tuple[str, str]:
    return item.map, repr(item)


def _items(source: str) -> Iterator[Item]:
    suffix = posixpath.splitext(source)[1].lower()
    if suffix in LISTS + TABLES:
        rows = _lines(source) if suffix in LISTS else _rows(source)
        folder = source.rpartition("/")[0]
        yield from (_from_row(row, source, folder) for row in rows)
        return
    names = _files(source)
    if not names:
        raise VdoorError(f"batch: wanted maps, found none: {source}")
    there = set(names)
    for name in maps_among(names) if names != [source] else names:
        truths = [truth for ending in TRUTHS if (truth := posixpath.splitext(name)[0] + ending) in there]
        yield Item(name, reference=truths[0] if truths else "")


def maps_among(names: Sequence[str]) -> list[str]:
    """The names that are maps: not references, and not the image that belongs to a YAML."""
    files = sorted(name for name in names if posixpath.splitext(name)[1].lower() in MAPS and _is_no_truth(name))
    stems = {posixpath.splitext(name)[0] for name in files if name.lower().endswith(DESCRIPTIONS)}
    return [name for name in files if name.lower().endswith(DESCRIPTIONS) or posixpath.splitext(name)[0] not in stems]


def maps_in(folder: Path) -> list[Path]:
    """The maps of a folder here, as `maps_among` chooses them."""
    return [Path(name) for name in maps_among([str(path) for path in folder.iterdir() if path.is_file()])]


def _is_no_truth(name: str) -> bool:
    path = Path(posixpath.basename(name))
    return bare_name(path) == path.stem and f"_{path.stem}" not in ENDINGS


def _files(source: str) -> list[str]:
    """The files of a folder or glob, or the source itself."""
    if "://" in source:
        return _remote_files(source)
    if Path(source).is_dir():
        return sorted(str(path) for path in Path(source).iterdir() if path.is_file())
    return sorted(glob.glob(source, recursive=True)) if glob.has_magic(source) else [source]  # noqa: PTH207  # as typed


def _remote_files(source: str) -> list[str]:
    with _naming(source):
        system, path = _system(source)
        if glob.has_magic(path):
            names = system.glob(path)
        elif system.isdir(path):
            names = [entry["name"] for entry in system.ls(path, detail=True) if entry["type"] == "file"]
        else:
            return [source]
        return sorted(system.unstrip_protocol(name) for name in names)


# --- lists and manifests


def _lines(source: str) -> Iterator[Mapping[str, Any]]:
    """The lines of a text file as rows with a map alone; empty ones and those with # are skipped."""
    try:
        lines = _list_bytes(source).decode().splitlines()
    except UnicodeDecodeError as error:
        raise VdoorError(f"list: wanted a text of paths in UTF-8, found other bytes: {source}") from error
    yield from ({"map": line.strip()} for line in lines if line.strip() and not line.startswith("#"))


def _rows(source: str) -> Iterator[Mapping[str, Any]]:
    """The rows of a CSV or Parquet file."""
    import pyarrow as pa  # noqa: PLC0415  # takes a while
    from pyarrow import csv, parquet  # noqa: PLC0415

    data = pa.BufferReader(_list_bytes(source))
    try:
        text = csv.ConvertOptions(column_types=dict.fromkeys(("map", "reference"), pa.string()))
        is_csv = source.lower().endswith(".csv")
        table = csv.read_csv(data, convert_options=text) if is_csv else parquet.read_table(data)
    except pa.ArrowException as error:
        raise VdoorError(f"manifest: wanted a table, found a damaged one ({error}): {source}") from error
    if "map" not in table.column_names:
        found = ", ".join(table.column_names[:9])
        raise VdoorError(f"manifest: wanted a column map, found {found}: {source}")
    known = [name for name in ("map", "reference", *NUMBERS) if name in table.column_names]
    yield from table.select(known).to_pylist()


def _from_row(row: Mapping[str, Any], source: str, folder: str) -> Item:
    """The item of a row, whose relative paths begin at the folder of the list."""
    if not row["map"]:
        raise VdoorError(f"manifest: wanted a map in every row, found none: {source}")
    places = {name: _joined(folder, str(row[name])) for name in ("map", "reference") if row.get(name)}
    try:
        numbers = {name: float(row[name]) for name in NUMBERS if row.get(name) not in (None, "")}
    except ValueError as error:
        raise VdoorError(f"manifest: wanted numbers for {row['map']}, found others ({error}): {source}") from error
    if ("robot_x_m" in numbers) != ("robot_y_m" in numbers):
        raise VdoorError(f"manifest: wanted both robot_x_m and robot_y_m for {row['map']}, found one: {source}")
    return Item(places["map"], places.get("reference", ""), *(numbers.get(name) for name in NUMBERS))


def _joined(folder: str, name: str) -> str:
    return name if "://" in name or not folder else posixpath.join(folder, name)


# --- URLs


def _system(url: str) -> tuple[Any, str]:
    """The file system of a URL, and the path in it."""
    try:
        import fsspec  # noqa: PLC0415  # an extra
    except ImportError as error:
        raise SettingError(f"maps: wanted the package fsspec for URLs (pip install 'vdoor[cluster]'): {url}") from error
    system, path = fsspec.core.url_to_fs(url)
    return system, str(path)


@contextmanager
def _naming(url: str) -> Iterator[None]:
    """Whatever a file system raises as one error with the URL."""
    try:
        yield
    except VdoorError:
        raise
    except Exception as error:  # file systems of all kinds raise what they like
        reason = str(error) or type(error).__name__
        raise MapError(f"file: wanted a file that can be read, found {reason}: {url}") from error


def _list_bytes(source: str) -> bytes:
    """The bytes of a list or manifest, here or at a URL."""
    if "://" not in source:
        return read_regular(Path(source), "a list of maps", limit=MOST_BYTES)
    return _bytes(source)


def _bytes(url: str) -> bytes:
    """The bytes of what a URL names."""
    with _naming(url):
        system, path = _system(url)
        return bytes(system.cat_file(path))


@contextmanager
def at_hand(place: str, home: Path, *, beside: Iterable[str] = ()) -> Iterator[Path]:
    """A file here: the place itself, below `home` if it is relative, or a copy of what a URL has while it is needed.

    A copy has beside it the files that a map's YAML names, and those with the suffixes `beside`, if they are there.
    """
    if "://" not in place:
        yield home / place
        return
    with tempfile.TemporaryDirectory(prefix="vdoor-") as folder:
        copy = Path(folder) / posixpath.basename(place)
        copy.write_bytes(_bytes(place))
        for name in _needed(copy):
            other = Path(folder) / name
            other.parent.mkdir(parents=True, exist_ok=True)
            other.write_bytes(_bytes(posixpath.join(place.rpartition("/")[0], name)))
        for suffix in beside:
            system, path = _system(place)
            if system.exists(near := posixpath.splitext(path)[0] + suffix):
                copy.with_suffix(suffix).write_bytes(system.cat_file(near))
        yield copy


def _needed(path: Path) -> Iterable[str]:
    """Names of further files that a map's file refers to, below its own folder."""
    reader = reader_of(path.name)
    names = reader.needs(path.read_bytes()) if reader else ()  # a copy of our own
    return [name for name in names if not posixpath.isabs(name) and ".." not in name.split("/")]
