"""The stored page of the paper's evidence is what the command makes, and the command does what its help states."""

from __future__ import annotations

import dataclasses
import json
import math
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from commands import Command, Done
from PIL import Image
from project import HOME
from small_evidence import small_evidence

from vdoor.experiments.search_study import Graph
from vdoor.method.corners import Candidates
from vdoor.method.curvature import Curvature
from vdoor.paper.claims import Size
from vdoor.paper.door_counts import ApartmentStudy, DoorCount, study_apartments
from vdoor.paper.errata import arctan_mistakes
from vdoor.paper.figures import SUB_CASES
from vdoor.paper.pictures import NAMES
from vdoor.paper.report import files, page, to_json
from vdoor.paper.runs import runs
from vdoor.paper.tables import Table
from vdoor.paper.walkthrough import figure_5_map, figure_5_run, run_method
from vdoor.pipeline import RECORDS, recorded
from vdoor.recording.mcap import read_recording

STORED = HOME / "recordings" / "paper"
APARTMENTS = 200
"""Those that carry the claim, on the stored page."""
SMALL = ("--apartments", "2", "--graphs", "2")
OF_ANY_SIZE = (
    "Figure 3: from the map to virtual doors",
    "Figure 4: the genetic operators",
    "Figure 5: the walk-through",
    "Table I: three environments",
    "Paths over rooms and doors",
    "Room by room against the whole space",
    "What cannot be taken by the letter",
    "What is not printed",
    "Recordings",
)
"""Sections of the page that are the same however many apartments and maps there are."""

Made = tuple[Path, Done]


def vdoor(*words: str | Path) -> Done:
    return Command()("paper", *words)


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Made:
    """A small page, and the run of the command that wrote it."""
    folder = tmp_path_factory.mktemp("paper") / "page"
    return folder, vdoor(*SMALL, "--out", folder, "--json")


def sections(page: Path) -> dict[str, str]:
    _, *parts = re.split(r"^## ", page.read_text(), flags=re.MULTILINE)
    return {part.splitlines()[0]: part for part in parts}


def stored_numbers() -> Any:
    return json.loads((STORED / "numbers.json").read_text())


def study_of(stored: Any) -> ApartmentStudy:
    """The study in a document, from its counts of each apartment alone."""
    each = [
        {name: DoorCount(real=real, virtual=virtual, matched=matched) for name, (real, virtual, matched) in row}
        for row in ([(name, stored["each"][name][at]) for name in stored["doors"]] for at in range(APARTMENTS))
    ]
    return ApartmentStudy(furniture=stored["furniture"], cell_m=stored["cell_m"], each=tuple(each))


def alike(found: Any, wanted: Any) -> bool:
    """Whether two documents are equal, but for the last digits of numbers."""
    if isinstance(wanted, dict):
        return found.keys() == wanted.keys() and all(alike(found[name], wanted[name]) for name in wanted)
    if isinstance(wanted, list):
        return len(found) == len(wanted) and all(map(alike, found, wanted))
    return bool(found == pytest.approx(wanted, rel=1e-7)) if isinstance(wanted, float) else bool(found == wanted)


def test_the_stored_page_has_what_the_command_finds(made: Made) -> None:
    here, there = sections(made[0] / "README.md"), sections(STORED / "README.md")
    for title in OF_ANY_SIZE:
        assert here[title] == there[title], title


def test_the_stored_numbers_are_those_that_the_command_finds(made: Made) -> None:
    here, there = json.loads(made[1].stdout), stored_numbers()
    for name in ("figure_3", "figure_4", "figure_5", "table_1", "motion", "slips", "unprinted"):
        assert alike(here[name], there[name]), name
    for name in ("courses", "reached", "optimum", "optimal_choices", "evaluations", "hits"):
        assert alike(here["search"][name], there["search"][name]), name
    assert alike(here["search"]["graphs"], there["search"]["graphs"][:2])


@pytest.mark.parametrize("furniture", [False, True], ids=["empty", "furnished"])
def test_the_stored_apartments_are_found_again(*, furniture: bool) -> None:
    each = stored_numbers()["apartments"][furniture]["each"]
    for number, found in enumerate(study_apartments(5, furniture=furniture).each):
        for name, count in found.items():
            assert [count.real, count.virtual, count.matched] == each[name][number], (number, name)


def test_every_word_and_number_of_the_stored_page_follows_from_what_was_counted() -> None:
    """What depends on how many there are is counted from the stored lists, of which a part is found again above."""
    stored, small = stored_numbers(), small_evidence()
    evidence = dataclasses.replace(
        small,
        size=Size(**stored["size"]),
        studies=tuple(map(study_of, stored["apartments"])),
        search=dataclasses.replace(small.search, graphs=tuple(Graph(**graph) for graph in stored["search"]["graphs"])),
    )
    assert page(evidence, [*runs(seed=0)]) == (STORED / "README.md").read_text()
    assert alike(json.loads(to_json(evidence)), stored)


def test_on_the_stored_page_every_claim_holds() -> None:
    page = (STORED / "README.md").read_text()
    claims = stored_numbers()["claims"]
    assert f"\nAll {len(claims)} claims hold:\n" in page
    assert page.count("| yes |\n") == len(claims)
    assert all(claim["holds"] for claim in claims)
    assert stored_numbers()["size"] == {"apartments": APARTMENTS, "graphs": 60, "seed": 0}
    assert "\nvdoor paper --out recordings/paper --force\n" in page


def test_the_stored_folder_holds_what_the_page_links_to_and_nothing_else(made: Made) -> None:
    page = (STORED / "README.md").read_text()
    linked = set(re.findall(r"\]\(([^)#]+)\)", page))
    assert linked | {"README.md"} == {path.name for path in STORED.iterdir()}
    assert linked | {"README.md"} == {path.name for path in made[0].iterdir()}
    assert sum(path.stat().st_size for path in STORED.iterdir()) < 2_000_000


def test_equal_seeds_give_equal_bytes_and_other_seeds_do_not(made: Made, tmp_path: Path) -> None:
    folder, first = made
    again = vdoor(*SMALL, "--out", tmp_path, "--quiet")
    assert (first.returncode, again.returncode) == (0, 0)
    assert "vdoor" not in again.stderr
    for path in files(folder, rrd=False):
        assert path.read_bytes() == (tmp_path / path.name).read_bytes(), path.name
    rows = json.loads(first.stdout)["search"]["courses"]["rows"]
    same, other = (figure_5_run(seed=seed).search.numbers("best_cost").tolist() for seed in (0, 1))
    assert [best for _, best, *_ in rows] == pytest.approx(same)
    assert same != other


def test_json_is_the_file_of_numbers_and_the_text_holds_the_same(made: Made) -> None:
    folder, done = made
    assert done.stdout == (folder / "numbers.json").read_text()
    assert "writing" in done.stderr
    assert "vdoor paper --out recordings/paper --force --apartments 2 --graphs 2" in (folder / "README.md").read_text()


def test_pictures_are_small_and_without_metadata_of_their_making(made: Made) -> None:
    for name in NAMES:
        with Image.open(made[0] / name) as picture:
            assert picture.format == "PNG"
            assert not picture.info.keys() - {"dpi"}
            assert len(picture.getcolors(256) or ()) > 3
        assert (made[0] / name).stat().st_size < 60_000


def test_every_run_is_recorded_with_the_stages_of_its_preset(made: Made) -> None:
    for run in runs(seed=0):
        recording = read_recording(made[0] / f"{run.name}.mcap", types=RECORDS)
        assert recorded(recording.info) == run.pipeline
        kinds = {type(record) for _, record in recording}
        assert kinds == set(run.pipeline.records)


def test_a_run_is_drawn_on_request(tmp_path: Path) -> None:
    run = next(runs(seed=0))
    run.record(tmp_path, rrd=True)
    assert [path.name for path in sorted(tmp_path.iterdir())] == ["figure_3a.mcap", "figure_3a.rrd"]


def test_existing_files_stay_without_force(tmp_path: Path) -> None:
    kept = tmp_path / "figure_5.png"
    kept.write_text("mine")
    done = vdoor(*SMALL, "--out", tmp_path)
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr == f"vdoor: output: already exists, --force overwrites it: {kept}\n"
    assert [path.name for path in tmp_path.iterdir()] == ["figure_5.png"]
    assert kept.read_text() == "mine"


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("--apartments", "0"), "--apartments"),
        (("--graphs", "many"), "--graphs"),
        (("--seed", "-1"), "--seed"),
        (("--rrd",), "wanted --out with a folder"),
        (("--out", __file__), "found a file"),
    ],
)
def test_what_cannot_be_done_is_refused_before_anything_runs(words: tuple[str, ...], said: str) -> None:
    done = vdoor(*words)
    assert done.returncode == 2
    assert done.stdout == ""
    assert said in done.stderr
    assert "Traceback" not in done.stderr


def test_a_table_is_aligned_as_text_and_escaped_as_markdown() -> None:
    table = Table(title="T", head=("name", "of"), rows=(("a|b", "1,000"), ("c", "-7")), notes=("so",), numbered=True)
    assert table.to_text().splitlines() == ["T", "-", "name     of", "a|b   1,000", "c        -7", "1. so"]
    assert table.to_markdown() == "| name | of |\n| --- | ---: |\n| a\\|b | 1,000 |\n| c | -7 |\n\n1. so"


def test_the_share_that_the_printed_arctan_mistakes_is_counted_right() -> None:
    def alpha_deg(of: Any, sample: int) -> float:
        """An angle by arctan, x to the right and y up, as eq. 6 has it."""
        down, right = of[sample].tolist()
        return math.degrees(math.atan(-down / right)) if right else math.copysign(90, -down)

    walk = run_method(figure_5_map())
    candidates, curvature = walk.get(Candidates), walk.get(Curvature)
    alphas = [alpha_deg(curvature.forward, at) - alpha_deg(curvature.backward, at) for at in candidates.sample.tolist()]
    convex = np.array([alpha >= 180 or -180 <= alpha < 0 for alpha in alphas])
    assert arctan_mistakes(walk) == (int((convex != candidates.convex).sum()), len(alphas))


def test_true_corners_obey_the_law_of_islands() -> None:
    for grid in (figure_5_map(), *(case.grid for case in SUB_CASES)):
        counts = run_method(grid).counts
        assert counts.concave_turns - counts.convex_turns == 4 - 4 * counts.islands
