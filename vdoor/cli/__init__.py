"""The `vdoor` command: parse, call, print. Heavy modules are imported inside the subcommands that need them."""

from __future__ import annotations

import contextlib
import io
import os
import sys
from typing import Annotated

import typer

from vdoor import __version__
from vdoor.cli.groups import Grouped
from vdoor.errors import VdoorError, say

app = typer.Typer(
    cls=Grouped,
    help="Rooms and doors from occupancy grid maps, with every stage recorded.",
    no_args_is_help=True,
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
)

LEFT_OUT = {"rerun": "rerun-sdk==0.41.*"}
"""Packages without which most commands work, by the name of the module."""


def _print_version(wanted: bool) -> None:
    if wanted:
        print(f"vdoor {__version__}")
        raise typer.Exit


@app.callback()
def _vdoor(
    *,
    version: Annotated[
        bool, typer.Option("--version", callback=_print_version, is_eager=True, help="Print the version.")
    ] = False,
) -> None:
    del version


def main() -> None:
    """Run the command; errors are one line on stderr and exit code 2."""
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="backslashreplace")  # a name that the terminal's encoding lacks
    try:
        _run()
    except VdoorError as error:
        say(str(error))
        sys.exit(2)
    except ModuleNotFoundError as error:
        if error.name not in LEFT_OUT:
            raise
        package = LEFT_OUT[error.name]
        say(f"{error.name}: wanted the package {package}, found none; `pip install {package}` adds it")
        sys.exit(2)
    except OSError as error:
        say(f"{error.filename or 'standard output'}: cannot be read or written ({error.strerror})")
        _drop_output()
        sys.exit(2)


def _run() -> None:
    """Run the command and write all that it printed, so that an error in that is seen here."""
    try:
        app(prog_name="vdoor")
    finally:
        if sys.stdout is not None:
            sys.stdout.flush()


def _drop_output() -> None:
    """Let what could not be printed go nowhere, rather than fail again at the end of the process."""
    if isinstance(sys.stdout, io.TextIOWrapper):
        with contextlib.suppress(OSError, ValueError):
            nowhere = os.open(os.devnull, os.O_WRONLY)
            os.dup2(nowhere, sys.stdout.fileno())
            os.close(nowhere)
