"""All commands: a command's module is imported when it is run, or when its help is shown."""

from __future__ import annotations

import importlib
import inspect
from collections.abc import Callable, Iterator, Mapping
from typing import Any

from typer.core import TyperCommand
from typer.main import get_command_from_info
from typer.models import CommandInfo

COMMANDS = (
    ("run", "run", "vdoor run map.yaml --save out.rrd --mcap out.mcap --out result/"),
    ("batch", "batch", "vdoor batch maps/ 'more/*.yaml' --out results/ -j 2; vdoor batch report results/"),
    ("config", "run", "vdoor config --preset paper > my.toml; vdoor run map.yaml --config my.toml"),
    ("show", "terminal", "vdoor show out.mcap --stage doors"),
    ("step", "terminal", "vdoor step out.mcap"),
    ("why", "terminal", "vdoor why out.mcap --at 3.2,4.1"),
    ("replay", "viewing", "vdoor replay out.mcap --save out.rrd"),
    ("shot", "viewing", "vdoor shot out.mcap -o pictures/ --stage Doors"),
    ("view", "viewing", "vdoor view out.rrd"),
    ("verify", "recordings", "vdoor verify recordings/golden --junit report.xml"),
    ("diff", "recordings", "vdoor diff before.mcap after.mcap"),
    ("info", "recordings", "vdoor info out.mcap"),
    ("check", "recordings", "vdoor check out.mcap"),
    ("recover", "recordings", "vdoor recover cut.mcap.partial -o whole.mcap"),
    ("export", "export", "vdoor export result/ --to nav2-route -o route.geojson"),
    ("nav2", "nav2", "vdoor nav2 result/ --out nav2/ --slow Kitchen=50"),
    ("valetudo", "valetudo", "vdoor valetudo result/ --clean Kitchen --clean 3"),
    ("rooms", "rooms", "vdoor rooms result/"),
    ("room-at", "rooms", "vdoor room-at out.mcap 3.2,6.1"),
    ("route", "navigate", "vdoor route result/ Kitchen 3 --via Hall --export waypoints=path.yaml"),
    (
        "cover",
        "cover",
        "vdoor cover result/ --return --export csv=path.csv; vdoor cover map.yaml --room 3 --save out.rrd",
    ),
    ("order", "navigate", "vdoor order result/ --start Hall --return"),
    ("edit", "edit_page", "vdoor edit result/"),
    ("rename", "edits", "vdoor rename result/ 3 Bath"),
    ("split", "edits", "vdoor split result/ 2.9,1.0 2.9,4.8"),
    ("merge", "edits", "vdoor merge result/ 2 3"),
    ("door", "edits", "vdoor door add result/ 7.1,1.0 7.1,3.4; vdoor door remove result/ 1"),
    ("golden", "recordings", "vdoor golden recordings/golden"),
    ("evaluate", "evaluate", "vdoor evaluate result/ --reference truth.png --min door_f1=0.8 --save seen.rrd"),
    ("ablate", "evaluate", "vdoor ablate maps/ --reference truth/ --exclude furnished --model my_curves.json"),
    ("robust", "evaluate", "vdoor robust maps/ --reference truth/ --bare-map maps/ --json"),
    ("sweep", "sweeps", "vdoor sweep --png all.png; vdoor sweep cost.bias=-1..1:0.5 seed=0..9 --json"),
    ("synth", "studies", "vdoor synth maps/other --kind paper --seed 3 --set furniture=true"),
    ("train", "studies", "vdoor train -o curves.json; vdoor run map.yaml --set score.model=curves.json"),
    ("map-statistics", "studies", "vdoor map-statistics maps/ --kind laser-home --count 3"),
    ("bench", "studies", "vdoor bench --tile 4"),
    ("cover-bench", "studies", "vdoor cover-bench maps/ --set cover.trade=0.3"),
    ("route-bench", "studies", "vdoor route-bench maps/ --starts 40; vdoor route-bench map.yaml --tile 4"),
    ("fleet-bench", "fleet", "vdoor fleet-bench; vdoor fleet-bench --part kills --kills 2"),
    ("paper", "paper", "vdoor paper --apartments 20; vdoor paper --out recordings/paper --rrd --force"),
    ("search-study", "studies", "vdoor search-study --graphs 60 --seeds 50"),
)
"""Name, module, example; the function has the command's name."""
WITH_PLACES = ("room-at", "route", "cover", "order", "rename", "split", "merge", "door")
CONTEXTS: dict[str, dict[str, Any]] = {name: {"ignore_unknown_options": True} for name in WITH_PLACES}
"""Places such as -1.2,3.4 begin with a minus and are not options."""
HELP = {"help_option_names": ["-h", "--help"]}


class Commands(Mapping[str, Any]):
    """The commands by name, each built when it is asked for: to build all of them takes a tenth of a second."""

    def __init__(self) -> None:
        self._rows = {name: (module, example) for name, module, example in COMMANDS}
        self._built: dict[str, Any] = {}

    def __getitem__(self, name: str) -> Any:
        """The command of that name."""
        if name not in self._built:
            info = CommandInfo(
                name,
                callback=self.function(name),
                epilog=f"Example: {self._rows[name][1]}",
                context_settings=CONTEXTS.get(name, {}) | HELP,
            )
            self._built[name] = get_command_from_info(info, pretty_exceptions_short=True, rich_markup_mode=None)
        return self._built[name]

    def __iter__(self) -> Iterator[str]:
        """The names in the table's order."""
        return iter(self._rows)

    def __len__(self) -> int:
        """The number of commands."""
        return len(self._rows)

    def function(self, name: str) -> Callable[..., None]:
        """The function that a command calls; raises KeyError if there is none."""
        module = importlib.import_module(f"vdoor.cli.{self._rows[name][0]}")
        function: Callable[..., None] = getattr(module, name.replace("-", "_"))
        return function

    def summary(self, name: str) -> str:
        """The first sentence of a command's help."""
        return TyperCommand(name, help=inspect.getdoc(self.function(name))).get_short_help_str(90)
