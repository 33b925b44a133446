"""Each stage of a recorded run as text: its map, its plot, its table, in the words of the records."""

from __future__ import annotations

from collections.abc import Iterator

from rich.console import RenderableType
from rich.text import Text

from vdoor.explain.stages import view_of
from vdoor.history import SEARCH, History
from vdoor.history.records import RECORD_OF
from vdoor.viz.terminal.picture import Picture
from vdoor.viz.terminal.scene import drawn
from vdoor.viz.terminal.tables import DETAILS, Limits, plain_details, table


def overview(run: History) -> Iterator[RenderableType]:
    """What the recording is of and how far it goes, stage by stage."""
    info = run.info
    files = ", ".join(name for name, _ in info.source.files) or "an array"
    yield Text(f"{run.file.name}: {files}, preset {info.preset}, seed {info.seed}, vdoor {info.version}", style="bold")
    if run.damage:
        yield Text(f"not whole: {run.damage}", style="bold red")
    rows = table("step", "stage", "holds")
    for topic in run.stages:
        last = run.steps[topic] + (len(run.search) - 1 if topic == SEARCH else 0)
        first = run.steps[topic]
        rows.add_row(str(first) if last == first else f"{first} to {last}", topic, summary(run, topic))
    yield rows


def summary(run: History, topic: str) -> str:
    """One line on a stage."""
    return view_of(RECORD_OF[topic]).summary(run)


def stage_view(run: History, topic: str, generation: int | None, limits: Limits) -> Iterator[RenderableType]:
    """Everything about one stage: title, map, legend, then plots and tables; one generation, or the whole search."""
    canvas = drawn(run, topic, -1 if generation is None else generation)
    step = run.steps[topic] + (generation or 0)
    yield Text(f"\n{topic}", style="bold").append(
        f"  {view_of(RECORD_OF[topic]).title} (step {step})", style="not bold"
    )
    yield Text(summary(run, topic))
    yield Picture(canvas, limits.lines)
    yield canvas.legend()
    yield ""
    yield from DETAILS[topic](run, generation, limits) if topic in DETAILS else plain_details(run, topic, limits)
