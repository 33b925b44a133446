"""`vdoor synth`, `vdoor bench` and `vdoor search-study`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from vdoor.cli.options import Force, Json, Preset, Resolution, Seed, Set, chosen_pipeline, read_grid
from vdoor.config import DEFAULT_PRESET
from vdoor.errors import SettingError


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
