"""`vdoor synth`, `vdoor bench`, `vdoor search-study` and `vdoor train`."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, TypeVar

import typer

from vdoor.cli.options import Force, Jobs, Json, Preset, Resolution, Seed, Set, chosen_pipeline, read_grid
from vdoor.config import DEFAULT_PRESET
from vdoor.errors import SettingError, say
from vdoor.navigate import ROBOT_RADIUS_M, TOOL_M

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator

    from vdoor.engines import Over
    from vdoor.grid import OccupancyGrid

T = TypeVar("T")
R = TypeVar("R")
PROGRESS_EVERY = 50


def synth(
    stem: Annotated[
        Path | None, typer.Argument(metavar="STEM", help="Write STEM.pgm, STEM.yaml and the truth beside them.")
    ] = None,
    *,
    kind: Annotated[
        str, typer.Option(help="Preset of settings: paper, paper-5cm, home, laser-home or office.")
    ] = "paper",
    set_: Annotated[list[str] | None, typer.Option("--set", metavar="FIELD=VALUE", help="One setting.")] = None,
    seed: Seed = 0,
    show: Annotated[bool, typer.Option("--show", help="Print the settings instead.")] = False,
    force: Force = False,
) -> None:
    """Draw a synthetic map, with its true rooms and doors."""
    import numpy as np

    from vdoor.config import commented, parse_assignments, replaced
    from vdoor.files import refuse_existing
    from vdoor.synth import kind_named, synthesize, write_synthetic

    preset = kind_named(kind)
    values = parse_assignments(f"apartment.{text}" for text in set_ or ()).get("apartment", {})
    settings = replaced(preset, values, "--set")
    if show:
        print("\n".join(commented(settings)))
        return
    if stem is None:
        raise SettingError("synth: wanted STEM, the name of the files without their suffixes, found none")
    refuse_existing([stem.with_name(f"{stem.name}.pgm"), stem.with_name(f"{stem.name}.yaml")], force=force)
    for path in write_synthetic(synthesize(settings, np.random.default_rng(seed)), stem, seed=seed):
        print(path)


def bench(
    maps: Annotated[list[Path] | None, typer.Argument(metavar="[MAP]...", help="Default: a synthetic map.")] = None,
    *,
    tile: Annotated[int, typer.Option(min=1, max=64, metavar="N", help="Tile each map N x N.")] = 1,
    record: Annotated[bool, typer.Option("--record", help="Also measure runs that write both recordings.")] = False,
    preset: Preset = DEFAULT_PRESET,
    set_: Set = None,
    resolution: Resolution = None,
    as_json: Json = False,
) -> None:
    """Measure the CPU time of the method, stage by stage."""
    from vdoor.experiments import benchmark
    from vdoor.outputs import both_recordings

    pipeline = chosen_pipeline(preset, None, set_)
    grids = {path.name: read_grid(path, quiet=True, resolution_m=resolution) for path in maps or ()}
    for report in benchmark.measured(
        grids or benchmark.own_maps(), pipeline, tile=tile, record=both_recordings if record else None
    ):
        print(report.to_json() if as_json else report.to_text())


def route_bench(
    maps: Annotated[list[Path], typer.Argument(metavar="MAP...", help="Maps, or folders of them.")],
    *,
    tile: Annotated[int, typer.Option(min=1, max=64, metavar="N", help="Tile each map N x N.")] = 1,
    starts: Annotated[int, typer.Option(min=1, metavar="N", help="Starts on each map, with five goals each.")] = 20,
    robot_radius: Annotated[float, typer.Option(min=0.001, max=10, metavar="M", help="Clearance.")] = ROBOT_RADIUS_M,
    preset: Preset = DEFAULT_PRESET,
    set_: Set = None,
    resolution: Resolution = None,
    as_json: Json = False,
) -> None:
    """Compare routes by rooms and doors with the whole grid: lengths, CPU times, clearance."""
    import dataclasses
    import json

    from vdoor.experiments import route_benchmark

    grids = _grids(maps, resolution)
    pipeline = chosen_pipeline(preset, None, set_)
    if not as_json:
        print(route_benchmark.HEADING)
    for report in route_benchmark.measured(grids, pipeline, tile=tile, starts=starts, radius_m=robot_radius):
        print(json.dumps(dataclasses.asdict(report)) if as_json else report.to_text(), flush=True)


def cover_bench(
    maps: Annotated[list[Path], typer.Argument(metavar="MAP...", help="Maps, or folders of them.")],
    *,
    robot_radius: Annotated[float, typer.Option(min=0.001, max=10, metavar="M", help="Clearance.")] = ROBOT_RADIUS_M,
    tool_width: Annotated[float, typer.Option(min=0.01, max=10, metavar="M", help="Width that is swept.")] = TOOL_M,
    preset: Preset = DEFAULT_PRESET,
    set_: Set = None,
    resolution: Resolution = None,
    as_json: Json = False,
) -> None:
    """Compare covering maps room by room with covering them as one: coverage, length, turns, CPU times.

    `--set cover.trade=0.3` moves along the curve between coverage and length.
    """
    import dataclasses
    import json

    from vdoor.experiments import cover_benchmark

    grids = _grids(maps, resolution)
    pipeline = chosen_pipeline(preset, None, set_)
    cover = dataclasses.replace(pipeline.cover, radius_m=robot_radius, tool_m=tool_width)
    if not as_json:
        print(cover_benchmark.HEADING)
    found = []
    for report in cover_benchmark.measured(grids, pipeline, cover):
        print(json.dumps(dataclasses.asdict(report)) if as_json else report.to_text(), flush=True)
        found.append(report)
    for mean in cover_benchmark.means(found) if not as_json else ():
        print(mean.to_text())


def _grids(maps: list[Path], resolution_m: float | None) -> dict[str, OccupancyGrid]:
    """The grids of maps and of those in folders, by file name."""
    return dict(_named_grids(maps, resolution_m))


def _named_grids(maps: list[Path], resolution_m: float | None) -> Iterator[tuple[str, OccupancyGrid]]:
    from vdoor.experiments.cases import map_files

    for file in (file for path in maps for file in map_files(path)):
        yield file.name, read_grid(file, quiet=True, resolution_m=resolution_m)


def map_statistics(
    maps: Annotated[list[Path] | None, typer.Argument(metavar="[MAP]...", help="Maps, or folders of them.")] = None,
    *,
    kind: Annotated[
        list[str] | None, typer.Option(metavar="KIND", help="Synthetic maps to compare, see `vdoor synth`; repeatable.")
    ] = None,
    count: Annotated[int, typer.Option(min=1, metavar="N", help="Synthetic maps of each kind.")] = 40,
    seed: Seed = 0,
    resolution: Resolution = None,
    as_json: Json = False,
) -> None:
    """Compare how maps look, synthetic and real: surroundings and lengths of walls, islands, corners.

    Quartiles over the maps. Maps that cannot be divided into rooms are left out.
    """
    import json

    from vdoor.experiments import likeness
    from vdoor.synth import kind_named

    if not maps and not kind:
        raise SettingError("map-statistics: wanted maps, found none: neither MAP nor --kind")
    kinds = {name: kind_named(name) for name in kind or ()}
    groups = {"maps": [grid for _, grid in _named_grids(maps, resolution)]} if maps else {}
    found = likeness.measured(groups | {name: likeness.drawn(of, count, seed) for name, of in kinds.items()})
    print(json.dumps(found) if as_json else likeness.to_text(found))


def search_study(
    *,
    graphs: Annotated[int, typer.Option(min=1, help="Number of initial maps, from synthetic apartments.")] = 60,
    seeds: Annotated[int, typer.Option(min=1, help="Number of searches per map.")] = 50,
    set_: Set = None,
    jobs: Jobs = 1,
    as_json: Json = False,
) -> None:
    """Compare the search with the proven optimum, by number of virtual doors."""
    from vdoor.engines import over
    from vdoor.experiments import search_study as study
    from vdoor.pipeline import Pipeline

    pipeline = chosen_pipeline("paper", None, set_)
    assert isinstance(pipeline, Pipeline)
    with over(jobs) as each:
        found = study.hit_rates(pipeline, graphs=graphs, seeds=seeds, over=each)
    print(study.to_json(found) if as_json else study.to_text(found))


def train(
    *,
    output: Annotated[Path, typer.Option("-o", "--output", metavar="FILE.json", help="File for the curves.")],
    homes: Annotated[int, typer.Option(min=0, help="Number of synthetic homes.")] = 800,
    offices: Annotated[int, typer.Option(min=0, help="Number of synthetic office floors.")] = 400,
    laser_homes: Annotated[int, typer.Option(min=0, help="Number of synthetic homes mapped by laser.")] = 0,
    seed: Seed = 0,
    rounds: Annotated[
        int,
        typer.Option(
            min=1, max=100, help="Number of fits, each to synthetic maps of the next seed; the mean is written."
        ),
    ] = 1,
    maps: Annotated[Path | None, typer.Option(metavar="DIR", help="Also fit to your own labelled maps.")] = None,
    reference: Annotated[Path | None, typer.Option(metavar="REF", help="Truth of these, see `vdoor evaluate`.")] = None,
    bare_map: Annotated[Path | None, typer.Option(metavar="DIR", help="Maps on which REF's rooms were drawn.")] = None,
    resolution: Annotated[float | None, typer.Option(metavar="M", help="Cell size of images, in metres.")] = None,
    weight: Annotated[float, typer.Option(min=0, max=1000, help="Weight of each of your own maps.")] = 3.0,
    jobs: Jobs = 1,
    force: Force = False,
) -> None:
    """Fit the curves that score doors, for use with --set score.model=FILE.json."""
    from vdoor import train as training
    from vdoor.engines import over
    from vdoor.errors import SettingError
    from vdoor.files import refuse_existing

    if (maps is None) != (reference is None):
        raise SettingError("train: wanted both --maps and --reference, or neither")
    if homes + offices + laser_homes == 0 and maps is None:
        raise SettingError("train: wanted maps, found none: --homes 0, --offices 0 and --laser-homes 0")
    refuse_existing([output], force=force)
    pipeline = training.default_pipeline()
    made: dict[str, Any] = {
        "command": f"vdoor train --homes {homes} --offices {offices} --seed {seed} --rounds {rounds}",
        "labelled_maps": 0,
    }
    if laser_homes:
        made["command"] += f" --laser-homes {laser_homes}"
    own: list[training.TrainingMap] = []
    if maps is not None and reference is not None:
        own = training.labelled_maps(maps, reference, weight=weight, bare=bare_map, resolution_m=resolution)
        made["labelled_maps"] = len(own)
        made["command"] += f" --maps {maps.name} --reference {reference.name} --weight {weight:g}"

    models = []
    with over(jobs) as each:
        for number in range(rounds):
            say(f"round {number + 1} of {rounds}")
            draws = [*map(training.known, own), *training.synthetic_maps(homes, offices, seed + number, laser_homes)]
            models.append(training.fitted_model(draws, pipeline, made, over=_told(each)))
    model = training.mean_of(models, made)
    training.write_model(output, model)
    examples, real = (model.made[name] for name in ("examples", "real_doors"))
    fitted = rounds * (len(own) + homes + offices + laser_homes)
    print(f"{output}: {fitted} maps, {examples} virtual doors, {real} of them real")


def _told(over: Over) -> Over:
    """The same `map`, which says on stderr how far it is."""

    def told(work: Callable[[T], R], items: Iterable[T], /) -> Iterator[R]:
        for number, result in enumerate(over(work, items), 1):
            if number % PROGRESS_EVERY == 0:
                say(f"map {number} done")
            yield result

    return told
