"""An evaluation drawn over the map: hit, missed and false doors, and pairs of found and true rooms."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import rerun as rr
import rerun.blueprint as rrb
from numpy.typing import NDArray

from vdoor import __version__
from vdoor.emit import RunInfo
from vdoor.evaluate import Doors, Evaluation
from vdoor.evaluate.tables import fates
from vdoor.grid import Source
from vdoor.viz.marks.boundary import STATES, states
from vdoor.viz.rerun import style
from vdoor.viz.rerun.graphs import room_classes
from vdoor.viz.rerun.scene import Scene, classes, pixels, strips
from vdoor.viz.rerun.sink import whole_recording

TABS = ("Doors", "Rooms")
HIT, MISSED, FALSE, EXCUSED = "hits", "missed", "false", "excused"
FATES: dict[str, style.Colour] = {
    HIT: (20, 150, 70),
    MISSED: (214, 30, 50),
    FALSE: (240, 130, 20),
    EXCUSED: (120, 122, 128),
}
NO_PARTNER = 65_535
"""Class of rooms without a partner."""
UNPAIRED: style.Colour = (90, 60, 70)
LEGEND = """
Doors: **green** hit, **red** missed, **orange** false, **grey** excused (the reference is uncertain there); thin green
lines are the true doors that were hit. Paired rooms share a colour, with their intersection over union on the found
room; dark rooms have no partner. Several maps follow one another along the timeline `step`.
"""


def save_evaluations(path: Path, evaluations: Sequence[Evaluation]) -> None:
    """Write a Rerun recording with one step per map; `VdoorError` if it cannot be written."""
    with whole_recording(path, _identity(evaluations), blueprint()) as scene:
        keep_classes(scene, evaluations)
        for step, evaluation in enumerate(evaluations):
            scene.begin(step, evaluation.name)
            draw_evaluation(scene, evaluation)


def blueprint() -> rrb.Blueprint:
    """Tabs with doors over the map beside the figures, and found rooms beside true ones."""
    doors = _view("Doors: green hit, red missed, orange false", "evaluation/doors/**")
    found = _view("Found rooms, with their IoU", "evaluation/found/**")
    true = _view("True rooms", "evaluation/true/**")
    figures = rrb.TextDocumentView(origin="figures", name="Figures")
    return rrb.Blueprint(
        rrb.Tabs(
            rrb.Horizontal(doors, figures, column_shares=[3, 1], name=TABS[0]),
            rrb.Horizontal(found, true, name=TABS[1]),
        ),
        rrb.BlueprintPanel(state="collapsed"),
        rrb.SelectionPanel(state="collapsed"),
        rrb.TimePanel(state="collapsed", timeline="step", play_state="paused"),
        auto_views=False,
        auto_layout=False,
    )


def keep_classes(scene: Scene, evaluations: Sequence[Evaluation]) -> None:
    """Log the names and colours of cells and rooms, for all maps."""
    rooms = max(int(evaluation.division.rooms.max(initial=0)) for evaluation in evaluations)
    rooms = max(rooms, *(evaluation.rooms.true for evaluation in evaluations if evaluation.rooms), 0)
    scene.keep("evaluation/map", classes({code: (word, colour) for code, (colour, word) in STATES.items()}))
    for side in ("found", "true"):
        names = room_classes(rooms) | {NO_PARTNER: ("no partner", UNPAIRED)}
        scene.keep(f"evaluation/{side}/rooms", classes(names))


def draw_evaluation(scene: Scene, evaluation: Evaluation) -> None:
    """Draw one map: cells, doors by outcome, rooms by pair, figures."""
    scene.raster("evaluation/map", states(evaluation.division.grid.cells))
    size = max(evaluation.division.free.shape) / 400
    for fate, doors in fates(evaluation).items():
        draw_doors(scene, f"evaluation/doors/{fate}", doors, colour=FATES[fate], radius=size)
    of_hits = evaluation.reference.doors[evaluation.matches[0.5].hit_true]
    draw_doors(scene, "evaluation/doors/true_of_hits", of_hits, colour=FATES[HIT], radius=size / 3)
    draw_rooms(scene, evaluation)
    rows = "\n".join(f"| {name} | {value:.4g} |" for name, value in evaluation.figures().items())
    text = f"# {evaluation.name}\n\n| figure | |\n|---|---|\n{rows}\n{LEGEND}"
    scene.log("figures", rr.TextDocument(text, media_type="text/markdown"))


def draw_doors(scene: Scene, entity: str, doors: Doors, *, colour: style.Colour, radius: float) -> None:
    """Draw doors as lines from end to end, with a dot at the middle."""
    fate = entity.rsplit("/", 1)[1].replace("_", " ")
    labels = [f"{fate}: {width_m:.2f} m" for width_m in doors.width_m]
    lines = strips(doors.ends[:, 0], doors.ends[:, 1])
    scene.log(entity, rr.LineStrips2D(list(lines), colors=colour, radii=radius, draw_order=20.0))
    middles = rr.Points2D(
        pixels(doors.centre), colors=colour, radii=radius * 2, labels=labels, show_labels=False, draw_order=21.0
    )
    scene.log(f"{entity}/middle", middles)


def draw_rooms(scene: Scene, evaluation: Evaluation) -> None:
    """Draw found and true rooms, numbered by the true room of their pair."""
    found, true, score = evaluation.division.rooms, evaluation.reference.rooms, evaluation.rooms
    if score is None or true is None:
        sides = {"found": found, "true": np.zeros_like(found)}
    else:
        of_found = np.full(score.found + 1, NO_PARTNER)
        of_true = np.full(score.true + 1, NO_PARTNER)
        of_found[0] = of_true[0] = 0
        of_true[score.pairs[:, 0]] = of_found[score.pairs[:, 1]] = score.pairs[:, 0]
        sides = {"found": of_found[found], "true": of_true[true]}
    for side, numbers in sides.items():
        scene.raster(f"evaluation/{side}/rooms", numbers.astype(np.uint16), order=1.0, opacity=0.85)
    draw_shares(scene, evaluation)


def draw_shares(scene: Scene, evaluation: Evaluation) -> None:
    """Draw the intersection over union of each pair at the middle of its found room."""
    score = evaluation.rooms
    places, labels = np.zeros((0, 2)), []
    if score is not None:
        places = _middles(evaluation.division.rooms)[score.pairs[:, 1] - 1]
        labels = [f"{share:.2f}" for share in score.pair_iou]
    scene.log(
        "evaluation/found/iou",
        rr.Points2D(pixels(places), colors=style.FREE, radii=0.1, labels=labels, show_labels=True, draw_order=22.0),
    )


def _middles(rooms: NDArray[np.int32]) -> NDArray[np.float64]:
    """Mean of the cells (k, 2) of each room, as row, col."""
    cells = np.argwhere(rooms)
    room = rooms[rooms > 0]
    counts = np.bincount(room)[1:]
    return np.stack([np.bincount(room, along)[1:] / counts for along in cells.T], axis=1)


def _view(name: str, contents: str) -> rrb.Spatial2DView:
    return rrb.Spatial2DView(name=name, origin="evaluation", contents=["+ /evaluation/map", f"+ /{contents}"])


def _identity(evaluations: Sequence[Evaluation]) -> RunInfo:
    """Information that the recording's id is derived from; equal evaluations have equal ids."""
    files = tuple((evaluation.name, evaluation.division.rooms.tobytes()) for evaluation in evaluations)
    figures = {evaluation.name: evaluation.figures() for evaluation in evaluations}
    return RunInfo(version=__version__, preset="evaluate", seed=0, settings=figures, source=Source(files=files))
