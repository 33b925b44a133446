"""The list of commands in `vdoor --help`, in groups."""

from __future__ import annotations

from typing import Any

from typer.core import TyperGroup

GROUPS = {
    "run and look": ("run", "batch", "rooms", "room-at", "show", "view", "shot", "config"),
    "debug": ("why", "step", "replay", "diff", "verify", "info", "check", "recover"),
    "drive": ("route", "cover", "order"),
    "edit": ("edit", "rename", "merge", "split", "door"),
    "export": ("export", "nav2", "valetudo"),
    "measure": (
        "evaluate",
        "ablate",
        "robust",
        "sweep",
        "bench",
        "cover-bench",
        "route-bench",
        "search-study",
        "synth",
        "train",
    ),
    "the paper": ("paper", "golden"),
}
"""Heading of each group, and its commands in order; a command in no group is listed at the end."""


class Grouped(TyperGroup):
    """Commands listed in groups."""

    def format_commands(self, ctx: Any, formatter: Any) -> None:
        """Write one section for each group."""
        left = {name: self.get_command(ctx, name) for name in self.list_commands(ctx)}
        sections = {heading: [(name, left.pop(name, None)) for name in names] for heading, names in GROUPS.items()}
        for heading, commands in {**sections, "more": [*left.items()]}.items():
            rows = [(name, command.get_short_help_str(90)) for name, command in commands if command is not None]
            if rows:
                with formatter.section(f"{heading.capitalize()}"):
                    formatter.write_dl(rows)
