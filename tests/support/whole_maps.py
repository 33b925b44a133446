"""A small whole map in every format that is read, as bytes: what tests damage."""

from __future__ import annotations

import gzip
import io
import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import zstandard
from bags import ROS1, bare_mcap, file_of, grid_message, ros1_bag, ros2_bag
from PIL import Image
from rosbags.rosbag1 import Writer as Writer1
from rosbags.rosbag2 import StoragePlugin
from small_recording import small

GREYS = np.full((20, 30), 254, np.uint8)
GREYS[0], GREYS[:, 15], GREYS[-1] = 0, 0, 205
CELLS = np.where(GREYS == 254, 0, np.where(GREYS == 0, 100, -1)).astype(np.int8)


def image(name: str) -> bytes:
    stream = io.BytesIO()
    Image.fromarray(GREYS).save(stream, format=name)
    return stream.getvalue()


def array() -> bytes:
    stream = io.BytesIO()
    np.save(stream, CELLS)
    return stream.getvalue()


def valetudo() -> bytes:
    pixels = {
        kind: np.argwhere(grey == GREYS)[:, ::-1].ravel().tolist() for kind, grey in (("floor", 254), ("wall", 0))
    }
    layers = [{"__class": "MapLayer", "type": kind, "pixels": found} for kind, found in pixels.items()]
    about = {"__class": "ValetudoMap", "metaData": {"version": 1}, "size": {"x": 200, "y": 200}, "pixelSize": 5}
    return json.dumps(about | {"layers": layers, "entities": []}).encode()


def bag(folder: Path) -> bytes:
    return bare_mcap(folder / "bag.mcap", [("/map", 1, grid_message(CELLS))]).read_bytes()


def folder_bag(folder: Path) -> bytes:
    return file_of(ros2_bag(folder / "bag", [("/map", 1, grid_message(CELLS))], StoragePlugin.SQLITE3)).read_bytes()


def old_bag(folder: Path) -> bytes:
    message = grid_message(CELLS, store=ROS1)
    return ros1_bag(folder / "bag.bag", [("/map", 1, message)], Writer1.CompressionFormat.BZ2).read_bytes()


MAPS: dict[str, Callable[[Path], bytes]] = {
    "map.pgm": lambda _: b"P5\n# a comment\n30 20\n255\n" + GREYS.tobytes(),
    "plain.pgm": lambda _: b"P2\n30 20\n255\n" + b" ".join(str(grey).encode() for grey in GREYS.ravel().tolist()),
    "map.png": lambda _: image("PNG"),
    "map.bmp": lambda _: image("BMP"),
    "map.tiff": lambda _: image("TIFF"),
    "map.yaml": lambda _: (
        b"image: beside.pgm\nmode: trinary\nresolution: 0.05\norigin: [0, 0, 0]\nnegate: 0\n"
        b"occupied_thresh: 0.65\nfree_thresh: 0.196\n"
    ),
    "map.npy": lambda _: array(),
    "map.json": lambda _: valetudo(),
    "map.json.gz": lambda _: gzip.compress(valetudo(), mtime=0),
    "map.mcap": bag,
    "map.mcap.zst": lambda folder: zstandard.compress(bag(folder)),
    "map.db3": folder_bag,
    "map.bag": old_bag,
    "recording.mcap": lambda folder: small(folder / "whole.mcap").read_bytes(),
}
"""A map by the name of its file; each is written into a folder first where its library wants one."""
