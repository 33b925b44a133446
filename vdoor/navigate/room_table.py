"""Distances between the portals of one room, computed once and kept in a file."""

from __future__ import annotations

import hashlib
import io
import zipfile
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from vdoor.navigate.room_graph import RoomGraph
from vdoor.partial import write_whole

Ints = NDArray[np.int32]
Table = Ints
"""Distances (t, t) between the terminals of a room (its portals, and where the robot stands in it)."""
Tables = dict[bytes, Table]
"""Tables by the digest of their room, so that what changes one room leaves the others' as they are."""
Cell = tuple[int, int]

VERSION = 1
"""Changes whenever the same room would give other distances."""
DIGEST_BYTES = 16
MOST_TABLES = 20_000


def table_of(graph: RoomGraph, fields: Sequence[Ints], terminals: Sequence[Cell]) -> Table:
    """The table from the distances (n,) of all nodes from each terminal."""
    nodes = [graph.number(cell) for cell in terminals]
    return np.array([field[nodes] for field in fields], np.int32).reshape(len(nodes), len(nodes))


def digest_of(graph: RoomGraph, terminals: Sequence[Cell]) -> bytes:
    """A digest that is equal for equal rooms: the same cells, steps and terminals."""
    found = hashlib.blake2b(digest_size=DIGEST_BYTES)
    nodes = [graph.number(cell) for cell in terminals]
    head = np.array([VERSION, *graph.node.shape, *nodes], np.int64)
    for part in (head, np.packbits(graph.node >= 0), np.packbits(graph.crossing)):
        found.update(part.tobytes())
    return found.digest()


def read_tables(path: Path) -> Tables:
    """The tables in a file; none if there is no such file, or it is damaged or of another version."""
    try:
        with np.load(io.BytesIO(path.read_bytes()), allow_pickle=False) as stored:
            return _unpacked(stored["digest"], stored["terminals"], stored["distance"])
    except (OSError, ValueError, KeyError, TypeError, EOFError, zipfile.BadZipFile):
        return {}


def _unpacked(digest: NDArray[np.uint8], terminals: Ints, distance: Ints) -> Tables:
    """The tables of a file; raises `ValueError` for arrays that do not fit together."""
    ends = np.cumsum(terminals.astype(np.int64) ** 2)
    if digest.shape != (len(ends), DIGEST_BYTES) or distance.shape != (ends[-1] if len(ends) else 0,):
        raise ValueError("arrays do not fit together")
    parts = np.split(distance.astype(np.int32), ends[:-1]) if len(ends) else []
    return {
        key.tobytes(): part.reshape(count, count)
        for key, count, part in zip(digest, terminals.tolist(), parts, strict=True)
    }


def write_tables(path: Path, tables: Mapping[bytes, Table]) -> None:
    """Write the latest `MOST_TABLES` tables; equal tables in equal order give equal bytes."""
    kept = list(tables.items())[-MOST_TABLES:]
    data = io.BytesIO()
    np.savez_compressed(
        data,
        digest=np.frombuffer(b"".join(key for key, _ in kept), np.uint8).reshape(-1, DIGEST_BYTES),
        terminals=np.array([len(table) for _, table in kept], np.int32),
        distance=np.concatenate([np.zeros(0, np.int32), *(table.ravel() for _, table in kept)]),
    )
    write_whole(path, data.getvalue())
