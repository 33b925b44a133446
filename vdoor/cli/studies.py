"""`vdoor synth`, `vdoor bench`, `vdoor search-study` and `vdoor train`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from vdoor.cli.options import Force, Json, Preset, Resolution, Seed, Set, chosen_pipeline, read_grid
from vdoor.config import DEFAULT_PRESET
from vdoor.errors import SettingError, say


def synth(
    stem: Annotated[
        Path | None, typer.Argument(metavar="STEM", help="Writes STEM.pgm, STEM.yaml and the truth beside.")
    ] = None,
    *,
    kind: Annotated[str, typer.Option(help="Settings to start from: paper, paper-5cm, home or office.")] = "paper",
    set_: Annotated[list[str] | None, typer.Option("--set", metavar="FIELD=VALUE", help="One setting.")] = None,
    seed: Seed = 0,
    show: Annotated[bool, typer.Option("--show", help="Print the settings instead.")] = False,
    force: Force = False,
) -> None:
    """Draw a map of our own making, with its true rooms and doors."""
    import numpy as np

    from vdoor.config import commented, parse_assignments, replaced
    from vdoor.files import refuse_existing
    from vdoor.synth import PRESETS, synthesize, write_synthetic

    if kind not in PRESETS:
        raise SettingError(f"--kind: wanted one of {', '.join(PRESETS)}, found {kind!r}")
    values = parse_assignments(f"apartment.{text}" for text in set_ or ()).get("apartment", {})
    settings = replaced(PRESETS[kind], values, "--set")
    if show:
        print("\n".join(commented(settings)))
        return
    if stem is None:
        raise SettingError("synth: wanted STEM, the name of the files without their endings")
    refuse_existing([stem.with_name(f"{stem.name}.pgm"), stem.with_name(f"{stem.name}.yaml")], force=force)
    for path in write_synthetic(synthesize(settings, np.random.default_rng(seed)), stem, seed=seed):
        print(path)


def bench(
    maps: Annotated[list[Path] | None, typer.Argument(metavar="[MAP]...", help="Default: a synthetic one.")] = None,
    *,
    tile: Annotated[int, typer.Option(min=1, max=64, metavar="N", help="Repeat each map N x N times, joined.")] = 1,
    record: Annotated[bool, typer.Option("--record", help="Also with both recordings, to a scratch folder.")] = False,
    preset: Preset = DEFAULT_PRESET,
    set_: Set = None,
    resolution: Resolution = None,
    as_json: Json = False,
) -> None:
    """Measure CPU seconds of the method, stage by stage."""
    from vdoor.experiments import benchmark
    from vdoor.outputs import both_recordings

    pipeline = chosen_pipeline(preset, None, set_)
    grids = {path.name: read_grid(path, resolution, None, 100_000_000, quiet=True) for path in maps or ()}
    for report in benchmark.measured(
        grids or benchmark.own_maps(), pipeline, tile=tile, record=both_recordings if record else None
    ):
        print(report.to_json() if as_json else report.to_text())


def search_study(
    *,
    graphs: Annotated[int, typer.Option(min=1, help="Initial maps, from synthetic apartments.")] = 60,
    seeds: Annotated[int, typer.Option(min=1, help="Searches a graph.")] = 50,
    set_: Set = None,
    as_json: Json = False,
) -> None:
    """Compare the search with the proven optimum, by number of virtual doors."""
    from vdoor.experiments import search_study as study
    from vdoor.pipeline import Pipeline

    pipeline = chosen_pipeline("paper", None, set_)
    assert isinstance(pipeline, Pipeline)
    found = study.hit_rates(pipeline, graphs=graphs, seeds=seeds)
    print(study.to_json(found) if as_json else study.to_text(found))


def train(
    *,
    output: Annotated[Path, typer.Option("-o", "--output", metavar="FILE.json", help="The curves.")],
    homes: Annotated[int, typer.Option(min=0, help="Synthetic homes.")] = 800,
    offices: Annotated[int, typer.Option(min=0, help="Synthetic office floors.")] = 400,
    seed: Seed = 0,
    rounds: Annotated[
        int,
        typer.Option(
            min=1, max=100, help="Fit so often, to synthetic maps of one seed after the other; take the mean."
        ),
    ] = 1,
    maps: Annotated[Path | None, typer.Option(metavar="DIR", help="Labelled maps of your own, as well.")] = None,
    reference: Annotated[Path | None, typer.Option(metavar="REF", help="Their truth, as for `vdoor evaluate`.")] = None,
    bare_map: Annotated[
        Path | None, typer.Option(metavar="DIR", help="The maps that label references were drawn on.")
    ] = None,
    resolution: Annotated[float | None, typer.Option(metavar="M", help="Metres a cell, for images.")] = None,
    weight: Annotated[float, typer.Option(min=0, max=1000, help="How much each of your maps counts.")] = 3.0,
    force: Force = False,
) -> None:
    """Fit the curves that score doors; use them with --set score.model=FILE.json."""
    import functools

    from vdoor import train as training
    from vdoor.errors import SettingError
    from vdoor.files import refuse_existing

    if (maps is None) != (reference is None):
        raise SettingError("train: wanted both --maps and --reference, or neither")
    if homes + offices == 0 and maps is None:
        raise SettingError("train: wanted maps, found none: --homes 0 and --offices 0")
    refuse_existing([output], force=force)
    pipeline = training.default_pipeline()
    made: dict[str, Any] = {
        "command": f"vdoor train --homes {homes} --offices {offices} --seed {seed} --rounds {rounds}",
        "labelled_maps": 0,
    }
    own: list[training.TrainingMap] = []
    if maps is not None and reference is not None:
        own = training.labelled_maps(maps, reference, weight=weight, bare=bare_map, resolution_m=resolution)
        made["labelled_maps"] = len(own)
        made["command"] += f" --maps {maps.name} --reference {reference.name} --weight {weight:g}"

    def told(number: int, draw: training.Draw) -> training.TrainingMap:
        if number % 50 == 0:
            say(f"map {number} of {len(own) + homes + offices}")
        return draw()

    models = []
    for number in range(rounds):
        say(f"round {number + 1} of {rounds}")
        draws = [*map(training.known, own), *training.synthetic_maps(homes, offices, seed + number)]
        training_maps = [functools.partial(told, *both) for both in enumerate(draws, 1)]
        models.append(training.fitted_model(training_maps, pipeline, made))
    model = training.mean_of(models, made)
    training.write_model(output, model)
    said, real = (model.made[name] for name in ("examples", "real_doors"))
    print(f"{output}: {rounds * (len(own) + homes + offices)} maps, {said} virtual doors, {real} of them real")
