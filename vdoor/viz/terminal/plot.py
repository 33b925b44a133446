"""Curves as text, over the full available width."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from rich.console import Console, ConsoleOptions, RenderResult
from rich.text import Text

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Curve:
    """Values (n,) of one curve; if a column has several, it shows `take` of them."""

    name: str
    values: Floats
    mark: str
    style: str
    take: Callable[[Floats], Any] = np.min


@dataclass(frozen=True)
class Plot:
    """Curves over their index, `lines` lines high, with a horizontal line at `level` if that is given."""

    curves: Sequence[Curve]
    lines: int
    unit: str = ""
    span: tuple[float, float] | None = None
    """Lowest and highest value shown; None to fit the values."""
    level: float | None = None
    across: str = ""
    """Name of the index."""
    first: int = 0
    """Index of the first value."""
    chosen: int | None = None
    """Index that is marked."""

    def __rich_console__(self, console: Console, options: ConsoleOptions) -> RenderResult:
        """Lines of the plot, with the scale on the left and the names of the curves below."""
        plain = console.color_system is None or options.ascii_only
        low, high = self._span()
        names = [f"{value:.4g}{self.unit}" for value in (high, low)] + ([] if self.level is None else [self._level()])
        margin = max(map(len, names)) + 1
        width = max(options.max_width - margin - 1, 1)
        grid = [[(" ", "")] * width for _ in range(self.lines)]
        scale = {0: names[0], self.lines - 1: names[1]}
        if self.level is not None and low <= self.level <= high:
            line = self._line_of(self.level, low, high)
            grid[line] = [("-" if plain else "─", "dim")] * width
            scale[line] = self._level()
        for curve in reversed(self.curves):
            for at, value in enumerate(_columns(curve, width)):
                if np.isfinite(value):
                    grid[self._line_of(value, low, high)][at] = (curve.mark, curve.style)
        for number, row in enumerate(grid):
            text = Text(f"{scale.get(number, ''):>{margin - 1}} {'|' if plain else '│'}", no_wrap=True, end="\n")
            for letter, style in row:
                text.append(letter, style)
            yield text
        yield self._foot(margin, width)

    def _foot(self, margin: int, width: int) -> Text:
        """Line below the plot: mark of the selected index, range of the index, names of the curves."""
        count = len(self.curves[0].values)
        text = Text(" " * margin)
        if self.chosen is not None and count:
            at = min((self.chosen - self.first) * width // count, width - 1)
            text.append(" " * (at + 1) + "^\n" + " " * margin)
        text.append(f" {self.across} {self.first} to {self.first + count - 1}  ")
        for curve in self.curves:
            text.append(f" {curve.mark}", curve.style)
            text.append(f" {curve.name} ")
        return text

    def _level(self) -> str:
        return f"{self.level:.4g}{self.unit}"

    def _line_of(self, value: float, low: float, high: float) -> int:
        share = (high - value) / (high - low) if high > low else 0.5
        return int(np.clip(round(share * (self.lines - 1)), 0, self.lines - 1))

    def _span(self) -> tuple[float, float]:
        if self.span is not None:
            return self.span
        values = np.concatenate([curve.values for curve in self.curves])
        values = values[np.isfinite(values)]
        return (float(values.min()), float(values.max())) if len(values) else (0.0, 1.0)


def _columns(curve: Curve, width: int) -> list[float]:
    """One value per column."""
    count = len(curve.values)
    if not count:
        return []
    begin = np.arange(width) * count // width
    end = np.maximum((np.arange(width) + 1) * count // width, begin + 1)
    return [float(curve.take(curve.values[slice(*ends)])) for ends in zip(begin, end, strict=True)]
