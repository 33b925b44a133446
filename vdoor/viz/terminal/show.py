"""Each stage of a recorded run as text: map, plots and tables."""

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
    """Run information, and a table of the recorded stages."""
    info = run.info
    files = ", ".join(name for name, _ in info.source.files) or "an array"
    yield Text(f"{run.file.name}: {files}, preset {info.preset}, seed {info.seed}, vdoor {info.version}", style="bold")
    if run.damage:
        yield Text(f"incomplete: {run.damage}", style="bold red")
    rows = table("step", "stage", "content")
    for topic in run.stages:
        last = run.steps[topic] + (len(run.search) - 1 if topic == SEARCH else 0)
        first = run.steps[topic]
        rows.add_row(str(first) if last == first else f"{first} to {last}", topic, summary(run, topic))
    yield rows


def summary(run: History, topic: str) -> str:
    """Result of a stage in one line."""
    return view_of(RECORD_OF[topic]).summary(run)


def stage_view(run: History, topic: str, generation: int | None, limits: Limits) -> Iterator[RenderableType]:
    """Title, map, legend, plots and tables of one stage; for the search, of one generation or of all."""
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
