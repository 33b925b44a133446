"""`vdoor train`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from vdoor.cli.options import Force, Seed
from vdoor.errors import say


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
