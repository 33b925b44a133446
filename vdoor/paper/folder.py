"""The folder of the page: recordings, pictures, numbers, and the page itself last."""

from __future__ import annotations

from pathlib import Path

from vdoor.files import make_folder, write_whole
from vdoor.paper.claims import Evidence
from vdoor.paper.document import to_json
from vdoor.paper.page import page
from vdoor.paper.pictures import NAMES, pictures
from vdoor.paper.runs import runs
from vdoor.paper.walkthrough import Progress, no_progress

PAGE, NUMBERS = "README.md", "numbers.json"


def files(folder: Path, *, rrd: bool) -> list[Path]:
    """All that `write` writes."""
    recordings = [path for run in runs(seed=0) for path in run.files(folder, rrd=rrd)]
    return [*recordings, *(folder / name for name in (*NAMES, NUMBERS, PAGE))]


def write(evidence: Evidence, folder: Path, *, rrd: bool, progress: Progress = no_progress) -> None:
    """Write everything, each file under its name only when it is whole; `VdoorError` where that cannot be done."""
    make_folder(folder)
    recorded = list(runs(evidence.size.seed))
    progress(f"writing {len(recorded)} recordings")
    for run in recorded:
        run.record(folder, rrd=rrd)
    progress(f"drawing {len(NAMES)} pictures")
    for name, content in pictures(evidence):
        write_whole(folder / name, content)
    write_whole(folder / NUMBERS, f"{to_json(evidence)}\n".encode())
    write_whole(folder / PAGE, page(evidence, recorded).encode())
