"""What measures gives the same figures whatever the number of processes."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from commands import Command
from project import HOME

from vdoor.engines import over
from vdoor.experiments.search_study import hit_rates
from vdoor.paper.door_counts import study_apartments
from vdoor.paper.walkthrough import paper_pipeline
from vdoor.synth import PRESETS, synthesize, write_synthetic
from vdoor.train import default_pipeline, fitted_model, known, synthetic_maps


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Two small apartments with their truth."""
    folder = tmp_path_factory.mktemp("maps")
    for seed in (0, 1):
        write_synthetic(synthesize(PRESETS["paper"], np.random.default_rng(seed)), folder / f"flat{seed}", seed=seed)
    return folder


def untimed(value: Any) -> Any:
    """The same without CPU times."""
    if isinstance(value, dict):
        return {name: untimed(part) for name, part in value.items() if not name.startswith("cpu_")}
    return [untimed(part) for part in value] if isinstance(value, list) else value


@pytest.mark.parametrize(
    "words",
    [
        ("robust", "MAPS", "--reference", "MAPS", "--preset", "paper", "--json", "--quiet"),
        ("sweep", "seed=0,1", "--maps", "MAPS", "--reference", "MAPS", "--preset", "paper", "--json", "--quiet"),
        ("verify", HOME / "recordings/golden/plain.mcap", HOME / "recordings/golden/crossing.mcap", "--json"),
    ],
    ids=lambda words: words[0],
)
def test_commands(words: tuple[str | Path, ...], folder: Path, command: Command) -> None:
    words = tuple(folder if word == "MAPS" else word for word in words)
    one, two = command(*words, "-j", "1"), command(*words, "-j", "2")
    assert one.code == two.code == 0
    assert untimed(one.json) == untimed(two.json)


def test_training_the_search_study_and_the_papers_apartments() -> None:
    draws = synthetic_maps(2, 0, seed=3)
    draws.append(known(draws[0]()))
    alone = fitted_model(draws, default_pipeline(), {})
    graphs = hit_rates(paper_pipeline(), graphs=3, seeds=2)
    study = study_apartments(3)
    with over(2) as each:
        assert fitted_model(draws, default_pipeline(), {}, over=each) == alone
        assert hit_rates(paper_pipeline(), graphs=3, seeds=2, over=each) == graphs
        assert study_apartments(3, over=each) == study
