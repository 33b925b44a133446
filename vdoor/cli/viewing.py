"""`vdoor replay`, `vdoor shot` and `vdoor view`: viewing a recording."""

from __future__ import annotations

import os
import sys
import tempfile
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from vdoor.cli.options import Force, complete_stage
from vdoor.errors import RecordingError, SettingError, VdoorError, say

if TYPE_CHECKING:
    from vdoor.record import Record
    from vdoor.recording.mcap import Recording

RecordingFile = Annotated[Path, typer.Argument(metavar="REC", help="An .mcap recording.")]
AnyRecording = Annotated[Path, typer.Argument(metavar="REC", help="An .rrd or .mcap recording.")]
STEP_S = 0.1
"""Pause between two records at speed 1."""


def replay(
    recording: RecordingFile,
    *,
    save: Annotated[Path | None, typer.Option(metavar="FILE.rrd", help="Rerun recording, for viewing.")] = None,
    connect: Annotated[str | None, typer.Option(metavar="URL", help="Stream to a running Rerun viewer.")] = None,
    serve: Annotated[bool, typer.Option("--serve", help="Stream to a web viewer on 127.0.0.1.")] = False,
    spawn: Annotated[bool, typer.Option("--spawn", help="Open a Rerun viewer and stream to it.")] = False,
    speed: Annotated[float, typer.Option(min=0.0, help="1 is ten records per second, 0 without pauses.")] = 0.0,
    force: Force = False,
) -> None:
    """Draw a recording, exactly as the live run would."""
    from vdoor.files import refuse_existing
    from vdoor.outputs import Outputs

    outputs = Outputs(save=save, connect=connect, serve=serve, spawn=spawn, force=force)
    if not (save or connect or serve or spawn):
        raise SettingError("replay: wanted somewhere to draw, one of --save, --connect, --serve, --spawn")
    refuse_existing(outputs.files, force=force, reads=[recording])
    outputs.refuse_suffixes()
    records = _draw(recording, outputs, pause_s=STEP_S / speed if speed else 0.0)
    print(f"{records} records drawn")


def shot(
    recording: AnyRecording,
    *,
    out: Annotated[Path, typer.Option("--out", "-o", metavar="DIR", help="Folder for the pictures.")],
    stage: Annotated[
        list[str] | None,
        typer.Option(
            metavar="STAGE", help="Only this stage, such as doors, or tab; repeatable.", autocompletion=complete_stage
        ),
    ] = None,
    size: Annotated[str, typer.Option(metavar="WxH", help="Pictures are at most that large, in pixels.")] = "1600x1000",
    viewer: Annotated[
        bool, typer.Option("--viewer", help="Take screenshots of the Rerun viewer, as of an .rrd; needs Vulkan.")
    ] = False,
    force: Force = False,
) -> None:
    """Write a PNG picture of each stage; needs no screen."""
    from vdoor.explain.stage_names import tab_named, tab_names
    from vdoor.files import make_folder, refuse_existing
    from vdoor.partial import write_whole

    tabs = tuple(dict.fromkeys(map(tab_named, stage))) if stage else None
    refuse_existing((path for tab in tabs or tab_names() for path in out.glob(f"*_{_file_name(tab)}")), force=force)
    taken = _screenshots if viewer or _is_rrd(recording) else _drawn
    for number, tab, png in taken(recording, tabs, _size(size)):
        make_folder(out)
        print(write_whole(out / f"{number}_{_file_name(tab)}", png))


Pictures = Iterator[tuple[int, str, bytes]]
"""Number, tab and PNG of each picture."""


def _drawn(recording: Path, tabs: Sequence[str] | None, size: tuple[int, int]) -> Pictures:
    """Pictures of the records themselves, of the intact part of a recording."""
    _refuse_unreadable(recording)
    from vdoor.history import History
    from vdoor.pipeline import RECORDS
    from vdoor.recording.mcap import read_recording
    from vdoor.viz.picture.pictures import pictures

    run = History.read(read_recording(recording, types=RECORDS))
    if run.damage:
        say(f"note: only the intact part was drawn; {run.damage}")
    for picture in pictures(run, tabs=tabs, size=size):
        yield picture.number, picture.tab, picture.png


def _screenshots(recording: Path, tabs: Sequence[str] | None, size: tuple[int, int]) -> Pictures:
    """Screenshots of what the viewer shows."""
    from vdoor.viz.rerun.shot import shots

    with _as_rrd(recording) as drawn:
        for picture in shots(drawn, tabs=tabs, size=size):
            yield picture.number, picture.tab, picture.png
            for problem in picture.problems:
                say(f"note: {picture.tab}: {problem}")


def view(recording: AnyRecording) -> None:
    """Open a recording in the Rerun viewer."""
    _refuse_unreadable(recording)
    if not (os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY") or sys.platform in ("darwin", "win32")):
        raise VdoorError(
            "view: this machine has no screen; take pictures with `vdoor shot`, or run `vdoor replay REC.mcap --serve` "
            "here and `ssh -L 9090:127.0.0.1:9090 -L 9876:127.0.0.1:9876 THIS_MACHINE` there, then open "
            f"http://127.0.0.1:9090?url=rerun%2Bhttp://127.0.0.1:9876/proxy: {recording}"
        )
    from vdoor.viz.rerun.sink import open_viewer

    with _as_rrd(recording) as drawn:
        open_viewer(drawn)


def _draw(path: Path, outputs: object, *, pause_s: float = 0.0) -> int:
    """Draw the intact part of a recording to `outputs`, and return the number of records."""
    from vdoor.outputs import Outputs, opened
    from vdoor.pipeline import RECORDS
    from vdoor.recording.mcap import read_recording

    assert isinstance(outputs, Outputs)
    recording = read_recording(path, types=RECORDS)
    count = 0
    with opened(outputs, recording.info) as drawing:
        for step, record in _whole(recording):
            for sink in drawing.sinks:
                sink.write(step, record)
            count += 1
            time.sleep(pause_s)
    return count


def _whole(recording: Recording) -> Iterator[tuple[int, Record]]:
    """Steps and records up to any damage, which is noted on stderr; `RecordingError` if no record is intact."""
    count = 0
    try:
        for step, record in recording:
            yield step, record
            count += 1
    except RecordingError as error:
        if not count:
            raise
        say(f"note: only the intact part was drawn, {count} record{'s' * (count > 1)}; {error}")


@contextmanager
def _as_rrd(path: Path) -> Iterator[Path]:
    """The recording as an .rrd, drawn into a scratch folder if it is an .mcap."""
    _refuse_unreadable(path)
    if _is_rrd(path):
        yield path
        return
    from vdoor.outputs import Outputs

    with tempfile.TemporaryDirectory() as folder:
        drawn = Path(folder) / f"{path.name.split('.')[0]}.rrd"
        _draw(path, Outputs(save=drawn))
        yield drawn


def _is_rrd(path: Path) -> bool:
    return path.name.removesuffix(".partial").endswith(".rrd")


def _refuse_unreadable(path: Path) -> None:
    """Raise `VdoorError` if there is no recording, or none that can be drawn: a viewer would wait for it."""
    if not path.is_file():
        from vdoor.kinds import kind_of

        found = "none" if not path.exists() else kind_of(path) if path.is_dir() else "a device or pipe"
        advice = "; `vdoor run MAP --mcap FILE` writes one" if path.is_dir() else ""
        raise VdoorError(f"recording: wanted an .rrd or .mcap file, found {found}{advice}: {path}")
    if _is_rrd(path):
        from vdoor.viz.rerun.program import refuse_unreadable

        refuse_unreadable(path)
        return
    from vdoor.pipeline import RECORDS
    from vdoor.recording.mcap import read_recording

    read_recording(path, types=RECORDS)


def _file_name(tab: str) -> str:
    """File name of the picture of a tab, without the tab's number."""
    return f"{tab.lower().replace(' ', '_')}.png"


def _size(text: str) -> tuple[int, int]:
    """Width and height in pixels; `SettingError` if out of range."""
    width, _, height = text.partition("x")
    if not (width.isdigit() and height.isdigit() and 100 <= int(width) <= 8192 and 100 <= int(height) <= 8192):  # noqa: PLR2004  # what viewers can draw
        raise SettingError(f"--size: wanted WxH of 100 to 8192 pixels, such as 1600x1000, found {text!r}")
    return int(width), int(height)
