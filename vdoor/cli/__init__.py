"""The `vdoor` command: parse, call, print. Heavy modules are imported inside the subcommands that need them."""

from __future__ import annotations

import contextlib
import io
import os
import sys
from typing import Annotated, Any

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

USAGE: type[Exception] = next(kind for kind in typer.BadParameter.__mro__ if kind.__name__ == "ClickException")
"""What the parser raises for words that it does not understand; typer does not say its name."""
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
        code = app(prog_name="vdoor", standalone_mode=False)
    except USAGE as error:
        _tell_usage(error)
        code = 2
    finally:
        if sys.stdout is not None:
            sys.stdout.flush()
    sys.exit(code or 0)


def _tell_usage(error: Any) -> None:
    """Say in one line what is wrong with the words of a command; without any, write the help."""
    if not sys.argv[1:]:
        error.show()
        return
    text = error.format_message().rstrip(".").replace(". Did", "; did")
    path = error.ctx.command_path if getattr(error, "ctx", None) else "vdoor"
    place = f"{path.removeprefix('vdoor ')}: " if " " in path else ""
    advice = "" if text.endswith("?") else f"; see `{path} --help`"
    say(f"{place}{text[:1].lower()}{text[1:]}{advice}")


def _drop_output() -> None:
    """Let what could not be printed go nowhere, rather than fail again at the end of the process."""
    if isinstance(sys.stdout, io.TextIOWrapper):
        with contextlib.suppress(OSError, ValueError):
            nowhere = os.open(os.devnull, os.O_WRONLY)
            os.dup2(nowhere, sys.stdout.fileno())
            os.close(nowhere)
