"""The walk on the screen: rich draws it, prompt_toolkit reads the keys."""

from __future__ import annotations

import itertools
import select
from collections.abc import Iterator
from functools import lru_cache

from prompt_toolkit.input import Input, create_input
from prompt_toolkit.keys import Keys
from rich.console import Console, RenderableType
from rich.layout import Layout
from rich.padding import Padding
from rich.table import Table
from rich.text import Text

from vdoor.explain.stages import view_of
from vdoor.history import SEARCH, History
from vdoor.history.records import RECORD_OF
from vdoor.viz.terminal.canvas import Canvas
from vdoor.viz.terminal.facts import facts
from vdoor.viz.terminal.picture import Picture
from vdoor.viz.terminal.plot import Plot
from vdoor.viz.terminal.scene import cost_plot, curvature_plot, drawn
from vdoor.viz.terminal.walk import HELP, HELP_LINE, NAMES, Walk, entered, pressed

LOOK_EVERY_S = 0.5
"""How often a new size of the terminal is looked for while no key is pressed."""
FACTS_COLUMNS, PLOT_LINES, LEGEND_LINES = 48, 9, 2
TALL = 28
"""Lines from which on there is room for a plot below the map."""


class Stepper:
    """A walk through one recording; draws what each place looks like."""

    def __init__(self, run: History) -> None:
        self.run = run
        self._drawn = lru_cache(maxsize=4)(self._draw)

    def walk(self, console: Console) -> None:
        """Draw and read keys until one of them quits; the terminal is restored however this ends."""
        source = create_input()
        place, shown = entered(self.run, Walk(self.run.stages[0]), self.run.stages[0]), None
        with source.raw_mode(), console.screen() as screen:
            for key in itertools.chain([""], keys(source)):
                place = pressed(self.run, place, key) if key else place
                if place.done:
                    return
                if shown != (place, console.size):
                    shown = place, console.size
                    screen.update(self.screen(place, console.height))

    def screen(self, walk: Walk, lines: int) -> Layout:
        """The whole screen: title, map beside facts, help."""
        layout = Layout()
        layout.split_column(
            Layout(self.title(walk), size=1), Layout(name="body"), Layout(self.foot(walk), size=1, name="foot")
        )
        right = help_table() if walk.help else self.facts_table(walk)
        left = Layout()
        canvas = self.canvas(walk)
        parts = [Layout(self.picture(walk, canvas)), Layout(canvas.legend(), size=LEGEND_LINES)]
        plot = self.plot(walk) if lines >= TALL else None
        if plot is not None:
            parts.append(Layout(plot, size=PLOT_LINES + 2))
        left.split_column(*parts)
        layout["body"].split_row(left, Layout(Padding(right, (0, 0, 0, 2)), size=FACTS_COLUMNS))
        return layout

    def title(self, walk: Walk) -> Text:
        """Which recording, which stage, which element."""
        number = f"{self.run.stages.index(walk.stage) + 1}/{len(self.run.stages)}"
        text = Text(f" {self.run.file.name}  {number} {walk.stage} ", style="reverse bold", no_wrap=True)
        if walk.element:
            text.append(f" {NAMES[walk.element]} {walk.at + (walk.element == 'final')} ")
        return text.append(f" {view_of(RECORD_OF[walk.stage]).title} ", "not bold")

    def foot(self, walk: Walk) -> Text:
        """What is being typed, what the last key could not do, or the keys."""
        if walk.typing is not None:
            what = "step" if walk.typing[0] == "s" else NAMES[walk.element] or "number"
            return Text(f" jump to {what}: {walk.typing[1:]}_   (Enter; Escape)", style="bold")
        return Text(f" {walk.said}", style="bold yellow") if walk.said else Text(f" {HELP_LINE}", style="dim")

    def facts_table(self, walk: Walk) -> Table:
        """The numbers behind what is seen."""
        table = Table.grid(padding=(0, 1), expand=True)
        table.add_column(style="dim", no_wrap=True)
        table.add_column(ratio=1, overflow="fold")
        sentences = []
        for name, value in facts(self.run, walk):
            if name:
                table.add_row(name, Text(value))
            else:
                sentences.append(Text(f"\n{value}", overflow="fold"))
        whole = Table.grid(expand=True)
        whole.add_row(table)
        for sentence in sentences:
            whole.add_row(sentence)
        return whole

    def plot(self, walk: Walk) -> RenderableType | None:
        """The curve along which the walker goes, if there is one."""
        plot: Plot | None = None
        if walk.stage in ("curvature", "candidates", "corners"):
            plot = curvature_plot(self.run, PLOT_LINES, walk.sample)
        elif walk.stage == SEARCH:
            plot = cost_plot(self.run, PLOT_LINES, walk.generation)
        return plot

    def picture(self, walk: Walk, canvas: Canvas) -> Picture:
        """The map, around the walker where it is looked at from nearby."""
        centre = self.centre(walk) if walk.pixels else None
        return Picture(canvas, most_lines=10**6, centre=centre, zoom=max(walk.pixels, 1))

    def centre(self, walk: Walk) -> tuple[float, float] | None:
        """Where the walker stands, as row, col of the stage's own cells."""
        run = self.run
        if walk.element == "sample":
            row, col = run.path.free_cell[walk.sample].tolist()
        elif walk.element == "door" and len(run.doors.start):
            row, col = ((run.doors.start[walk.door] + run.doors.end[walk.door]) / 2).tolist()
        elif walk.element == "final" and len(run.topology.kind):
            middle_m = (run.topology.start_m[walk.final] + run.topology.end_m[walk.final]) / 2
            row, col = run.topology.frame.cell_from_world(middle_m)[0].tolist()
        else:
            height, width = self._drawn(walk.stage, walk.generation).inks.shape
            row, col = height / 2, width / 2
        return row, col

    def canvas(self, walk: Walk) -> Canvas:
        """The stage's map with the walker on it."""
        canvas, run = self._drawn(walk.stage, walk.generation if walk.stage == SEARCH else -1).copy(), self.run
        if walk.element == "sample":
            here = (run.path.half[walk.sample] - 1) / 2
            if walk.stage != "path":
                canvas.line("forward", here, here + run.curvature.forward[walk.sample] / 2, ends=True)
                canvas.line("backward", here, here + run.curvature.backward[walk.sample] / 2, ends=True)
            canvas.paint("chosen", run.path.cell[walk.sample])
            canvas.paint("walker", run.path.free_cell[walk.sample])
        elif walk.element == "door" and len(run.doors.start):
            canvas.line("chosen", run.doors.start[walk.door], run.doors.end[walk.door], ends=True)
        elif walk.element == "final" and len(run.topology.kind):
            ends = (run.topology.start_m[walk.final], run.topology.end_m[walk.final])
            canvas.line("chosen", *(run.topology.frame.cell_from_world(end_m)[0] for end_m in ends), ends=True)
        return canvas

    def _draw(self, stage: str, generation: int) -> Canvas:
        return drawn(self.run, stage, generation)


def help_table() -> Table:
    """All keys."""
    table = Table.grid(padding=(0, 2))
    for key, meaning in HELP:
        table.add_row(Text(key, style="bold"), meaning)
    return table


def keys(source: Input) -> Iterator[str]:
    """Keys as they are pressed, by their names; an empty one where none came for a while, or the input is at its end.

    A lone Escape looks like the beginning of another key until nothing follows it.
    """
    while not source.closed:
        ready, _, _ = select.select([source.fileno()], [], [], LOOK_EVERY_S)
        presses = source.read_keys() if ready else source.flush_keys()
        for press in presses:
            yield press.key.value if isinstance(press.key, Keys) else press.key
        if not presses:
            yield ""
