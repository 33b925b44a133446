"""A table, as plain text and as Markdown."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass

from vdoor.paper.door_counts import Share

NUMBER = re.compile(r"[-+]?[\d,.]+( %)?|-|")


@dataclass(frozen=True, kw_only=True)
class Table:
    """Rows of text under a head, and notes, numbered where rows point to them."""

    title: str
    head: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    notes: tuple[str, ...] = ()
    numbered: bool = False

    def to_text(self) -> str:
        """Aligned columns under an underlined title."""
        lines = [self.head, *self.rows]
        widths = [max(len(line[column]) for line in lines) for column in range(len(self.head))]
        right = [self._is_of_numbers(column) for column in range(len(self.head))]
        shown = (
            "  ".join(
                cell.rjust(width) if to_right else cell.ljust(width)
                for cell, width, to_right in zip(line, widths, right, strict=True)
            ).rstrip()
            for line in lines
        )
        return "\n".join([self.title, "-" * len(self.title), *shown, *self._noted()])

    def to_markdown(self) -> str:
        """A table for a page, its notes below, without the title."""
        marks = ["---:" if self._is_of_numbers(column) else "---" for column in range(len(self.head))]
        lines = [self.head, tuple(marks), *self.rows]
        shown = ("| " + " | ".join(cell.replace("|", "\\|") for cell in line) + " |" for line in lines)
        between = "\n" if self.numbered else "\n\n"
        return "\n\n".join(["\n".join(shown), *([between.join(self._noted())] if self.notes else [])])

    def _noted(self) -> Iterator[str]:
        return (f"{number}. {note}" if self.numbered else note for number, note in enumerate(self.notes, 1))

    def _is_of_numbers(self, column: int) -> bool:
        return all(NUMBER.fullmatch(row[column]) for row in self.rows)


def with_interval(share: Share) -> str:
    """A share and where the true one lies with 95 % confidence."""
    low, high = share.interval
    return f"{share.value:.3f} ({low:.3f} to {high:.3f})"
