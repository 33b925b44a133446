"""A Rerun recording of something that is finished: drawn at once, under its name only when it is whole."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import rerun.blueprint as rrb

from vdoor.emit import RunInfo
from vdoor.errors import VdoorError
from vdoor.files import partial_name
from vdoor.viz.rerun.scene import Scene
from vdoor.viz.rerun.sink import FLUSH_S, errors_at, new_stream


@contextmanager
def whole_recording(path: Path, info: RunInfo, blueprint: rrb.Blueprint) -> Iterator[Scene]:
    """Where to draw; the file is there when the block ends. VdoorError where it cannot be written."""
    partial = partial_name(path)
    stream = new_stream(info)
    try:
        with errors_at(path):
            partial.touch()
            stream.save(partial, default_blueprint=blueprint)
            yield Scene(stream)
            stream.flush(timeout_sec=FLUSH_S)
            stream.disconnect()
            if not partial.stat().st_size:
                raise VdoorError(f"recording: nothing was written, wanted a Rerun recording: {path}")
            partial.replace(path)
    finally:
        partial.unlink(missing_ok=True)
