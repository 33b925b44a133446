"""`vdoor show`, `vdoor step` and `vdoor why`: debugging a recording in a terminal."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from vdoor.cli.options import Json, complete_stage, place_in, print_json
from vdoor.errors import SettingError, naming, say

if TYPE_CHECKING:
    from rich.console import Console

    from vdoor.history import History

RecordingFile = Annotated[Path, typer.Argument(metavar="REC.mcap", help="Recording made with `vdoor run --mcap`.")]
PIPE_COLUMNS = 120
FRAME_LINES = 6
"""Lines of a screen reserved for the title, the legend and the prompt."""
ALL = 10**6
ALL_STAGES = "all"
TERMINAL_ROWS = 40


def show(
    recording: RecordingFile,
    *,
    stage: Annotated[
        str | None,
        typer.Option(metavar="STAGE", help="A stage or a tab of the viewer, or all.", autocompletion=complete_stage),
    ] = None,
    step: Annotated[int | None, typer.Option(min=0, metavar="N", help="Show the record of this step.")] = None,
    rows: Annotated[int | None, typer.Option(min=1, help="Maximum rows of a table (terminal: 40, pipe: all).")] = None,
) -> None:
    """Show a recording's stages in the terminal; without options, an overview and the last stage."""
    from vdoor.viz.terminal.show import overview

    run, console = _read(recording), _console()
    topics, generation = _chosen(run, stage, step)
    if not topics:
        console.print(*overview(run), sep="\n")
    _print_stages(run, console, topics or run.stages[-1:], generation=generation, rows=rows)


def _print_stages(
    run: History, console: Console, topics: Sequence[str], *, generation: int | None = None, rows: int | None = None
) -> None:
    from vdoor.viz.terminal.show import stage_view
    from vdoor.viz.terminal.tables import Limits

    lines = max(console.height - FRAME_LINES, FRAME_LINES) if console.is_terminal else ALL
    limits = Limits(lines=lines, rows=rows or (TERMINAL_ROWS if console.is_terminal else ALL))
    for topic in topics:
        for part in stage_view(run, topic, generation, limits):
            console.print(part)


def step(recording: RecordingFile) -> None:
    """Step through a recording with keys: stages, samples, doors, generations; `?` lists the keys."""
    import sys

    from vdoor.outputs import interruptible

    run, console = _read(recording), _console()
    if not (console.is_terminal and sys.stdin.isatty()) or console.is_dumb_terminal:
        say("step: cannot read keys, as this is not a terminal; showing the stages as text")
        _print_stages(run, console, run.stages)
        return
    from vdoor.viz.terminal.stepper import Stepper

    with interruptible():
        Stepper(run).walk(console)


def why(
    recording: RecordingFile,
    *,
    at: Annotated[str | None, typer.Option(metavar="X,Y", help="Point, metres in the map frame.")] = None,
    door: Annotated[
        str | None, typer.Option("--door", metavar="DOOR", help="In place of a point: a door of the final map.")
    ] = None,
    edge: Annotated[
        int | None, typer.Option("--edge", metavar="N", help="In place of a point: an edge of the initial map.")
    ] = None,
    candidate: Annotated[
        int | None, typer.Option("--candidate", metavar="N", help="In place of a point: a virtual door, as it prints.")
    ] = None,
    cells: Annotated[bool, typer.Option("--cells", help="--at is COL,ROW of the map instead.")] = False,
    count: Annotated[int, typer.Option(min=1, metavar="N", help="Number of elements of each kind.")] = 3,
    as_json: Json = False,
) -> None:
    """Explain why there is a door at a point, or none: the decision of each stage about the nearest elements."""
    import dataclasses

    from vdoor.explain import explain
    from vdoor.explain.places import place_of
    from vdoor.explain.text import to_lines

    given = {"--at": at, "--door": door, "--edge": edge, "--candidate": candidate}
    named = [(option, value) for option, value in given.items() if value is not None]
    if len(named) != 1:
        raise SettingError(f"why: wanted one of {', '.join(given)}, found {len(named)}: {recording}")
    ((option, word),) = named
    run = _read(recording)
    with naming(recording):
        if at is not None:
            place_m = place_in(run.input.frame, at, what="--at", cells=cells)
        else:
            place_m = place_of(run, option.removeprefix("--"), str(word))
        answer = explain(run, place_m, count=count)
    if as_json:
        print_json(dataclasses.asdict(answer))
    else:
        print("\n".join(to_lines(answer)))


def _read(path: Path) -> History:
    from vdoor.history import History
    from vdoor.pipeline import RECORDS
    from vdoor.recording.mcap import read_recording

    run = History.read(read_recording(path, types=RECORDS))
    if run.damage:
        say(run.damage)
    return run


def _console() -> Console:
    """Console for the results: the terminal, or plain text of a fixed width in a pipe."""
    import os

    from rich.console import Console

    console = Console(highlight=False, markup=False, emoji=False)
    if not console.is_terminal and "COLUMNS" not in os.environ:
        console.width = PIPE_COLUMNS
    return console


def _chosen(run: History, stage: str | None, step: int | None) -> tuple[tuple[str, ...], int | None]:
    """The requested stages (none for an overview), and the requested generation (None for all)."""
    from vdoor.explain.stage_names import stages_named
    from vdoor.history import SEARCH

    wanted = () if stage is None else run.stages if stage == ALL_STAGES else stages_named(stage)
    topics = tuple(topic for topic in wanted if topic in run.stages)
    if wanted and not topics:
        raise SettingError(f"--stage: {stage} was not recorded, the last one is {run.stages[-1]}: {run.file}")
    if step is None:
        return topics, None
    topic, index = run.stage_of(step)
    if topics and topic not in topics:
        raise SettingError(f"--step: step {step} belongs to {topic}, not to {stage}: {run.file}")
    return (topic,), index if topic == SEARCH else None
