"""The command: parse, call, print. Heavy modules are imported inside the command that needs them."""

from __future__ import annotations

import sys
from typing import Annotated

import typer

from vdoor import __version__
from vdoor.cli import run, studies
from vdoor.errors import VdoorError
from vdoor.say import say

app = typer.Typer(
    help="Rooms and doors from occupancy grid maps, every stage on record.",
    no_args_is_help=True,
    add_completion=False,
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
)

COMMANDS = (
    ("run", run.run, "vdoor run map.yaml --save out.rrd --mcap out.mcap --out result/"),
    ("config", run.config, "vdoor config --preset paper > my.toml; vdoor run map.pgm --config my.toml"),
    ("synth", studies.synth, "vdoor synth maps/flat --kind paper --seed 3 --set furniture=true"),
    ("bench", studies.bench, "vdoor bench --tile 4"),
    ("search-study", studies.search_study, "vdoor search-study --graphs 60 --seeds 50"),
)
"""Name, function, example."""

for name, function, example in COMMANDS:
    app.command(name, epilog=f"Example: {example}")(function)


@app.callback()
def _vdoor(version: Annotated[bool, typer.Option("--version", help="Print the version.")] = False) -> None:
    if version:
        print(f"vdoor {__version__}")
        raise typer.Exit


def main() -> None:
    """Run the command; errors are one line on stderr and exit code 2."""
    try:
        app()
    except VdoorError as error:
        say(str(error))
        sys.exit(2)
    except KeyboardInterrupt as error:
        sys.exit(getattr(error, "exit_code", 130))
