"""Coverage-guided fuzzing of what reads binary data, by name: a kind of file, and for how many seconds.

    .venv/bin/pip install atheris
    .venv/bin/python tests/stress/coverage_fuzz.py mcap 3600

What is not a result or an error of vdoor's own is kept in `build/fuzz/KIND/found`, one file for each place in the code,
and so is what takes over ten seconds or a gigabyte; those are to become tests. What reached new code is kept in
`build/fuzz/KIND/corpus` for the next time. The exit code is 1 if anything was found.
"""

from __future__ import annotations

import os
import sys
import tempfile
import traceback
import warnings
import zlib
from collections.abc import Callable
from pathlib import Path

import atheris

HOME = Path(__file__).parents[2]
sys.path.append(str(HOME / "tests" / "support"))
with atheris.instrument_imports(include=["vdoor", "mcap", "rosbags", "PIL"], enable_loader_override=False):
    from vdoor.errors import VdoorError
    from vdoor.formats import read_map
    from vdoor.pipeline import RECORDS, emitted
    from vdoor.recording.check import check
    from vdoor.recording.recover import recover

MOST_CELLS = 100_000
"""So small that a map as large as this is no finding."""
LIMITS = ("-timeout=10", "-rss_limit_mb=1500", "-max_len=20000", "-print_final_stats=1")
"""Of a run in libFuzzer's words; its own code and what it remembers are 500 MB."""
SEEDS = {
    "mcap": ("map.mcap", "recording.mcap"),
    "images": ("map.png", "map.pgm", "plain.pgm", "map.bmp", "map.tiff"),
    "db3": ("map.db3",),
    "containers": ("map.npy", "map.json", "map.json.gz", "map.mcap.zst", "base64.json", "map.bag"),
}
MAGIC = b"\x89PNG\r\n\x1a\n"


def with_checksums(data: bytes) -> bytes:
    """Set the checksums of a PNG's chunks right, so that a change gets further than to them."""
    if not data.startswith(MAGIC):
        return data
    at, made = len(MAGIC), [MAGIC]
    while at + 12 <= len(data):
        end = at + 8 + int.from_bytes(data[at : at + 4])
        made += [data[at:end], zlib.crc32(data[at + 4 : end]).to_bytes(4)]
        at = end + 4
    return b"".join([*made, data[at:]])


def read_all(kind: str, path: Path) -> None:
    """Read a file in every way in which its kind is read."""
    ways: list[Callable[[], object]] = [lambda: read_map(path, max_cells=MOST_CELLS)]
    if kind == "mcap":
        ways.append(lambda: check(path, types=RECORDS, emits=emitted))
        ways.append(lambda: recover(path, path.with_name("out.mcap"), types=RECORDS, emits=emitted))
    for way in ways:
        try:
            way()
        except VdoorError as error:
            if len(str(error).splitlines()) != 1:
                raise AssertionError(str(error)) from error


def place_of(error: Exception) -> str:
    """Give a file name for where an error was raised."""
    last = traceback.extract_tb(error.__traceback__)[-1]
    return f"{type(error).__name__}-{Path(last.filename).stem}-{last.lineno}"


def target(kind: str, found: Path, folder: Path) -> Callable[[bytes], None]:
    """Give the function that is called with every input."""
    path = folder / "input"

    def one(data: bytes) -> None:
        path.write_bytes(with_checksums(data))
        (folder / "out.mcap").unlink(missing_ok=True)
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")
                read_all(kind, path)
        except Exception as error:  # noqa: BLE001  # that it came at all is the finding
            kept = found / place_of(error)
            if not kept.exists():
                kept.write_bytes(path.read_bytes())
                kept.with_suffix(".txt").write_text(traceback.format_exc())

    return one


def write_seeds(kind: str, corpus: Path) -> None:
    """Put whole maps into the corpus, from which changes start."""
    from base64 import b64encode  # noqa: PLC0415

    from whole_maps import MAPS  # noqa: PLC0415  # imports what is instrumented

    for name in SEEDS[kind]:
        with tempfile.TemporaryDirectory() as folder:
            whole = b64encode(MAPS["map.json.gz"](Path(folder))) if name == "base64.json" else MAPS[name](Path(folder))
        (corpus / name).write_bytes(whole)


def main(kind: str, seconds: str) -> None:
    """Fuzz for some seconds."""
    build = HOME / "build" / "fuzz" / kind
    corpus, found = build / "corpus", build / "found"
    for folder in (corpus, found):
        folder.mkdir(parents=True, exist_ok=True)
    write_seeds(kind, corpus)
    with tempfile.TemporaryDirectory(dir="/dev/shm") as folder:  # in memory, for speed
        words = [sys.argv[0], str(corpus), *LIMITS, f"-artifact_prefix={found}/", f"-max_total_time={seconds}"]
        atheris.Setup(words, target(kind, found, Path(folder)), enable_python_coverage=True)
        child = os.fork()  # libFuzzer ends its process
        if child == 0:
            atheris.Fuzz()
        os.waitpid(child, 0)
    sys.exit(any(found.iterdir()))


if __name__ == "__main__":
    main(*sys.argv[1:3])
