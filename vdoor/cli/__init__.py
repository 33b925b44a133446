"""The `vdoor` command: parse, call, print. Heavy modules are imported inside the subcommands that need them."""

from __future__ import annotations

import contextlib
import io
import os
import sys
from typing import Annotated

import typer

from vdoor import __version__
from vdoor.cli import (
    batch,
    cover,
    edit_page,
    edits,
    evaluate,
    export,
    nav2,
    navigate,
    paper,
    recordings,
    rooms,
    run,
    studies,
    sweeps,
    terminal,
    valetudo,
    viewing,
)
from vdoor.cli.groups import Grouped
from vdoor.errors import VdoorError, say

app = typer.Typer(
    cls=Grouped,
    help="Rooms and doors from occupancy grid maps, with every stage recorded.",
    no_args_is_help=True,
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
)

COMMANDS = (
    ("run", run.run, "vdoor run map.yaml --save out.rrd --mcap out.mcap --out result/"),
    ("batch", batch.batch, "vdoor batch maps/ 'more/*.yaml' --out results/ -j 2; vdoor batch report results/"),
    ("config", run.config, "vdoor config --preset paper > my.toml; vdoor run map.pgm --config my.toml"),
    ("show", terminal.show, "vdoor show out.mcap --stage doors"),
    ("step", terminal.step, "vdoor step out.mcap"),
    ("why", terminal.why, "vdoor why out.mcap --at 3.2,4.1"),
    ("replay", viewing.replay, "vdoor replay out.mcap --save out.rrd"),
    ("shot", viewing.shot, "vdoor shot out.mcap -o pictures/ --stage Doors"),
    ("view", viewing.view, "vdoor view out.rrd"),
    ("verify", recordings.verify, "vdoor verify recordings/golden --junit report.xml"),
    ("diff", recordings.diff, "vdoor diff before.mcap after.mcap"),
    ("info", recordings.info, "vdoor info out.mcap"),
    ("check", recordings.check, "vdoor check out.mcap"),
    ("recover", recordings.recover, "vdoor recover out.mcap.partial -o out.mcap"),
    ("export", export.export, "vdoor export result/ --to nav2-route -o route.geojson"),
    ("nav2", nav2.nav2, "vdoor nav2 result/ --out nav2/ --slow Kitchen=50"),
    ("valetudo", valetudo.valetudo, "vdoor valetudo result/ --clean Kitchen --clean 3"),
    ("rooms", rooms.rooms, "vdoor rooms result/"),
    ("room-at", rooms.room_at, "vdoor room-at 3.2,-4.1 out.mcap"),
    ("route", navigate.route, "vdoor route result/ Kitchen 3 --via Hall --export waypoints=path.yaml"),
    (
        "cover",
        cover.cover,
        "vdoor cover result/ --return --export csv=path.csv; vdoor cover map.yaml --room 3 --save out.rrd",
    ),
    ("order", navigate.order, "vdoor order result/ --start Hall --return"),
    ("edit", edit_page.edit, "vdoor edit result/"),
    ("rename", edits.rename, "vdoor rename result/ 3 Kitchen"),
    ("split", edits.split, "vdoor split result/ 1.2,3.4 1.2,8.0"),
    ("merge", edits.merge, "vdoor merge result/ 2 5"),
    ("door", edits.door, "vdoor door add result/ 4.9,6.1 4.9,7.1; vdoor door remove result/ 3"),
    ("golden", recordings.golden, "vdoor golden recordings/golden"),
    ("evaluate", evaluate.evaluate, "vdoor evaluate result/ --reference truth.png --min door_f1=0.9 --save seen.rrd"),
    ("ablate", evaluate.ablate, "vdoor ablate maps/ --reference truth/ --exclude furnished --model my_curves.json"),
    ("robust", evaluate.robust, "vdoor robust maps/ --reference truth/ --bare-map maps/ --free-from 250 --json"),
    ("sweep", sweeps.sweep, "vdoor sweep --png all.png; vdoor sweep cost.bias=-1..1:0.5 seed=0..9 --json"),
    ("synth", studies.synth, "vdoor synth maps/flat --kind paper --seed 3 --set furniture=true"),
    ("train", studies.train, "vdoor train -o curves.json; vdoor run map.pgm --set score.model=curves.json"),
    ("bench", studies.bench, "vdoor bench --tile 4"),
    ("cover-bench", studies.cover_bench, "vdoor cover-bench maps/ --set cover.trade=0.3"),
    ("route-bench", studies.route_bench, "vdoor route-bench maps/ --starts 40; vdoor route-bench map.yaml --tile 4"),
    ("paper", paper.paper, "vdoor paper --apartments 20; vdoor paper --out recordings/paper --rrd --force"),
    ("search-study", studies.search_study, "vdoor search-study --graphs 60 --seeds 50"),
)
"""Name, function, example."""
WITH_PLACES = ("room-at", "route", "cover", "order", "rename", "split", "merge", "door")
CONTEXTS = {name: {"ignore_unknown_options": True} for name in WITH_PLACES}
"""Places such as -1.2,3.4 begin with a minus and are not options."""

for name, function, example in COMMANDS:
    app.command(name, epilog=f"Example: {example}", context_settings=CONTEXTS.get(name))(function)


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
