"""`vdoor step`: driven by keys in a real pseudo-terminal, and walked at random without one."""

from __future__ import annotations

import signal
from pathlib import Path

import numpy as np
import pytest
from commands import call
from hypothesis import given, settings
from hypothesis import strategies as st
from maps import drawn
from terminals import Screen, history, recorded, terminal
from two_rooms import PROVEN, TWO_ROOMS

from vdoor.history import History
from vdoor.method.corners import Corners
from vdoor.method.doors import PROPOSED, VERDICTS
from vdoor.pipeline import Pipeline
from vdoor.synth import PRESETS, synthesize
from vdoor.viz.terminal.facts import facts
from vdoor.viz.terminal.walk import KEYS, Walk, entered, pressed, stops

RIGHT, LEFT, DOWN, END, TAB, BACK_TAB, ENTER, ESCAPE = (
    "\x1b[C",
    "\x1b[D",
    "\x1b[B",
    "\x1b[F",
    "\t",
    "\x1b[Z",
    "\r",
    "\x1b",
)
OTHER_SCREEN, FIRST_SCREEN, SHOW_CURSOR = b"\x1b[?1049h", b"\x1b[?1049l", b"\x1b[?25h"


@pytest.fixture(scope="module")
def apartment(tmp_path_factory: pytest.TempPathFactory) -> Path:
    made = synthesize(PRESETS["paper"], np.random.default_rng(3))
    return recorded(tmp_path_factory.mktemp("apartment"), made.grid)


def at(screen: Screen, stage: str, element: str = "") -> None:
    """Wait until the title names a stage, and what of it."""
    screen.wait(lambda text: f" {stage} " in text.splitlines()[0] and element in text.splitlines()[0])


def left_well(screen: Screen, code: int = 0) -> None:
    assert screen.end() == code
    assert screen.written.rindex(FIRST_SCREEN) > screen.written.index(OTHER_SCREEN)
    assert screen.written.rindex(SHOW_CURSOR) > screen.written.index(OTHER_SCREEN)
    assert b"Traceback" not in screen.written


def test_keys_lead_through_stages_and_samples_with_the_records_numbers(apartment: Path) -> None:
    run = history(apartment)
    found = run.curvature
    with terminal(["step", apartment], columns=120, lines=40) as screen:
        at(screen, "input")
        screen.wait(lambda text: "q quit" in text.splitlines()[-1])
        screen.press("nn" + TAB)
        at(screen, "curvature", "sample 0")
        screen.press(RIGHT * 3)
        at(screen, "curvature", "sample 3")
        screen.press(DOWN + LEFT)
        at(screen, "curvature", "sample 12 ")
        sample = 12
        screen.tells("K_f", str(found.k_forward[sample]))
        screen.tells("K_b", str(found.k_backward[sample]))
        screen.tells("vector f", "({}, {})".format(*found.forward[sample]))
        screen.tells("vector b", "({}, {})".format(*found.backward[sample]))
        screen.tells("angle", f"{np.degrees(found.angle_rad[sample]):.4f} deg")
        screen.tells("threshold", "155 deg")
        row, col = run.path.cell[sample]
        screen.tells("wall cell", f"{col},{row} (col,row)")
        screen.press(END)
        at(screen, "curvature", f"sample {len(run.path.cell) - 1} ")
        screen.press(BACK_TAB + "p")
        at(screen, "simplified")
        screen.press("q")
        left_well(screen)


def test_next_candidate_and_next_rejected_door_are_found(apartment: Path) -> None:
    run = history(apartment)
    first = int(run.candidates.sample[run.candidates.sample > 0][0])
    rejected = np.flatnonzero(run.doors.verdict != PROPOSED)
    with terminal(["step", apartment], columns=120, lines=40) as screen:
        at(screen, "input")
        screen.press("c")
        at(screen, "candidates", f"sample {run.candidates.sample[0]} ")
        screen.press("c" * 2)
        at(screen, "candidates", f"sample {run.candidates.sample[2]} ")
        screen.press("C" * 1)
        at(screen, "candidates", f"sample {first} ")
        screen.press("r")
        at(screen, "doors", f"door {rejected[0]} ")
        screen.press("r")
        at(screen, "doors", f"door {rejected[1]} ")
        door = rejected[1]
        screen.tells("verdict", VERDICTS[run.doors.verdict[door]])
        screen.tells("length", f"{run.doors.length_m[door]:.4f} m (at most 1.2)")
        screen.tells("width", f"{run.doors.width_m[door]:.4f} m free")
        screen.press("R" * 2)
        screen.wait(lambda text: "no rejected door before" in text)
        screen.press("q")
        left_well(screen)


def test_jumps_to_a_step_and_a_generation_with_its_terms(apartment: Path) -> None:
    run = history(apartment)
    with terminal(["step", apartment], columns=120, lines=40) as screen:
        at(screen, "input")
        screen.press(f"s{run.steps['generation'] + 7}")
        screen.wait(lambda text: f"jump to step: {run.steps['generation'] + 7}_" in text)
        screen.press(ENTER)
        at(screen, "generation", "generation 7 ")
        generation, cost = run.search[7], run.pipeline.cost
        screen.tells("best cost", f"{generation.best_cost:.6f}")
        screen.tells("mean", f"{generation.mean_cost:.6f}")
        area = f"{generation.area_sd_m2:.6f} m2 x 0.05 = {generation.area_sd_m2 * cost.area_weight_per_m2:.6f}"
        screen.tells("AreaSD", area)
        screen.tells("best string", "".join("01"[bit] for bit in generation.removed.astype(int)))
        removed, before = (set(np.flatnonzero(run.search[at].removed).tolist()) for at in (7, 6))
        assert removed - before == {6}, "a change to look for"
        screen.tells(
            "changed", " ".join(f"{'-' if edge in removed else '+'}{edge}" for edge in sorted(removed ^ before))
        )
        screen.press("g12" + ENTER)
        at(screen, "generation", "generation 12 ")
        screen.press("s99999" + ENTER)
        screen.wait(lambda text: f"steps go from 0 to {run.last_step}" in text)
        screen.press("g5" + ESCAPE)
        screen.wait(lambda text: "jump to" not in text and "q quit" in text)
        at(screen, "generation", "generation 12 ")
        screen.press("?")
        screen.wait(lambda text: "next / previous rejected door" in text)
        screen.press("?q")
        left_well(screen)


@pytest.mark.parametrize(("number", "code"), [(signal.SIGTERM, 143), (signal.SIGINT, 130)])
def test_terminal_is_restored_when_a_signal_ends_it(apartment: Path, number: signal.Signals, code: int) -> None:
    with terminal(["step", apartment]) as screen:
        at(screen, "input")
        screen.process.send_signal(number)
        left_well(screen, code)


def test_ctrl_c_quits(apartment: Path) -> None:
    with terminal(["step", apartment]) as screen:
        at(screen, "input")
        screen.press("\x03")
        left_well(screen)


def test_small_terminal_still_shows_title_map_and_help(apartment: Path) -> None:
    with terminal(["step", apartment], columns=80, lines=24) as screen:
        at(screen, "input")
        screen.press("c")
        at(screen, "candidates")
        screen.wait(lambda text: "K_f" in text and "▀" in text and "n/p stage" in text.splitlines()[-1])
        screen.press("q")
        left_well(screen)


def test_pipe_gets_all_stages_as_plain_text(apartment: Path) -> None:
    done = call("step", apartment)
    assert "\x1b" not in done.stdout
    assert [line.split()[0] for line in done.stdout.splitlines() if "(step " in line] == [
        record.topic for record in Pipeline().records
    ]
    assert "not a terminal" in done.stderr


@settings(max_examples=60, deadline=None, derandomize=True)
@given(keys=st.lists(st.sampled_from([*KEYS, *"0123456789", "c-m", "escape", "c-h", "?", "x"]), max_size=60))
def test_no_keys_lead_out_of_the_recording(apartment: Path, keys: list[str]) -> None:
    run = RUNS.setdefault(apartment, history(apartment))
    walk = Walk(run.stages[0])
    for key in keys:
        walk = pressed(run, walk, key)
        here = stops(run, walk.stage)
        assert walk.stage in run.stages
        assert walk.at in here or not len(here)
        assert dict(facts(run, walk))


RUNS: dict[Path, History] = {}


def test_walk_through_a_recording_that_ends_early_stays_in_it(tmp_path: Path) -> None:
    run = history(recorded(tmp_path, drawn(TWO_ROOMS), PROVEN, until=Corners))
    walk = entered(run, Walk(run.stages[0]), run.stages[-1])
    assert walk.stage == "corners"
    assert pressed(run, walk, "n").message
    assert "ends before doors" in pressed(run, walk, "r").message
    assert pressed(run, walk, "c").stage == "candidates"


def test_walk_stays_at_the_first_and_at_the_last_one(apartment: Path) -> None:
    run = RUNS.setdefault(apartment, history(apartment))
    first, last = (Walk("path", sample=sample) for sample in (0, len(run.path.cell) - 1))
    for walk, key in ((first, "left"), (first, "up"), (last, "right"), (last, "down")):
        assert pressed(run, walk, key).at == walk.at
    assert "first" in pressed(run, first, "left").message
    assert "last" in pressed(run, last, "right").message
