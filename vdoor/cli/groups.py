"""The list of commands in `vdoor --help`, in groups."""

from __future__ import annotations

from typing import Any

from typer.core import TyperGroup

from vdoor.cli.commands import Commands

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
        "fleet-bench",
        "cover-bench",
        "route-bench",
        "search-study",
        "synth",
        "map-statistics",
        "train",
    ),
    "the paper": ("paper", "golden"),
}
"""Heading of each group, and its commands in order; a command in no group is listed at the end."""


class Grouped(TyperGroup):
    """Commands listed in groups."""

    def __init__(self, **options: Any) -> None:
        super().__init__(**options)
        self.commands: Any = Commands()

    def format_commands(self, ctx: Any, formatter: Any) -> None:
        """Write one section for each group."""
        every = self.list_commands(ctx)
        sections = {heading: [name for name in names if name in every] for heading, names in GROUPS.items()}
        grouped = {name for names in sections.values() for name in names}
        for heading, names in {**sections, "more": [name for name in every if name not in grouped]}.items():
            rows = [(name, self.commands.summary(name)) for name in names]
            if rows:
                with formatter.section(f"{heading.capitalize()}"):
                    formatter.write_dl(rows)
