"""The runs behind the figures and Table I, each of which can be recorded, replayed and run again."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from vdoor import __version__
from vdoor.config import settings_of
from vdoor.emit import Recorder, RunInfo
from vdoor.grid import OccupancyGrid
from vdoor.outputs import Outputs, opened
from vdoor.paper.door_counts import FURNISHING, METHOD_TITLES, PROPOSED, environments, methods_for
from vdoor.paper.figures import SUB_CASES
from vdoor.paper.walkthrough import figure_5_map, paper_pipeline
from vdoor.pipeline import METHODS, PRESETS, AnyPipeline


@dataclass(frozen=True, eq=False)
class Run:
    """A method with its settings, a map and a seed."""

    name: str
    """The name of its files, without the ending."""
    what: str
    """What it is in the paper."""
    grid: OccupancyGrid
    pipeline: AnyPipeline
    preset: str = "paper"
    seed: int = 0

    def files(self, folder: Path, *, rrd: bool) -> list[Path]:
        """The files that `record` writes."""
        endings = ("mcap", "rrd") if rrd else ("mcap",)
        return [folder / f"{self.name}.{ending}" for ending in endings]

    def record(self, folder: Path, *, rrd: bool) -> None:
        """Run it and write its recording, with `rrd` a Rerun recording as well."""
        info = RunInfo(
            version=__version__, preset=self.preset, seed=self.seed, settings=settings_of(self.pipeline, METHODS)
        )
        mcap, *save = self.files(folder, rrd=rrd)
        with opened(Outputs(mcap=mcap, save=save[0] if save else None), info) as recording:
            self.pipeline(self.grid, np.random.default_rng(self.seed), Recorder(recording.sinks))


def runs(seed: int) -> Iterator[Run]:
    """All runs, in the paper's order."""
    yield from _of_sub_cases()
    yield Run("figure_5", "Fig. 5, the walk-through", figure_5_map(), paper_pipeline(), seed=seed)
    for furniture in (False, True):
        yield from _of_table(seed, furniture=furniture)


def _of_sub_cases() -> Iterator[Run]:
    for case in SUB_CASES:
        yield Run(case.file_stem, f"Fig. {case.part}, {case.name}", case.grid, paper_pipeline())
        if case.pipeline_undone:
            what = f"Fig. {case.part}, without that step"
            yield Run(f"{case.file_stem}_undone", what, case.grid, case.pipeline_undone)


def _of_table(seed: int, *, furniture: bool) -> Iterator[Run]:
    """The proposed method on each environment; on furnished ones every method."""
    kind = FURNISHING[furniture]
    for environment in environments(furniture=furniture):
        made = environment.made
        for name, method in methods_for(made).items():
            if furniture or name == PROPOSED:
                stem = f"{environment.name} {kind} {name}".replace(" ", "_").replace("-", "_")
                what = f"Table I, {environment.name}, {kind}: {METHOD_TITLES[name]}"
                yield Run(stem, what, made.grid, method, name if name in PRESETS else "paper", seed)
