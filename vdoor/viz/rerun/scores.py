"""Drawings of door scores and of the certificate."""

from __future__ import annotations

from typing import Any

import numpy as np
import rerun as rr

from vdoor.method.scoring.features import FEATURES
from vdoor.method.scoring.score import JUDGEMENTS, LIKELY, DoorScores
from vdoor.method.search.certificate import Certificate
from vdoor.viz.rerun import style
from vdoor.viz.rerun.scene import Scene, strips, table


def draw_scores(scene: Scene, scores: DoorScores) -> None:
    """Draw likely doors coloured by log-odds, the others in one layer per judgement, and lines between conflicts."""
    doors = scene.remembered["doors"]
    start, end = doors.start[scores.door], doors.end[scores.door]
    for code, judgement in enumerate(JUDGEMENTS):
        own = np.flatnonzero(scores.judgement == code)
        likely = code == LIKELY
        odds = scores.log_odds[own].tolist()
        labels = [
            f"door {door}: {log_odds:+.2f}{', closed in pass 2' if sure else ''}"
            for door, log_odds, sure in zip(scores.door[own], odds, scores.sure[own], strict=True)
        ]
        scene.log(
            f"map/scores/{judgement}",
            rr.LineStrips2D(
                strips(start[own], end[own]),
                colors=[style.odds(log_odds) for log_odds in odds] if likely else style.JUDGED[judgement],
                radii=0.2 if likely else 0.07,
                labels=labels if likely else [f"{label}, {judgement}" for label in labels],
                show_labels=False,
                draw_order=28.0 if likely else 25.0,
            ),
        )
    middle = (start + end) / 2
    joined = strips(middle[scores.rival_a], middle[scores.rival_b])
    scene.log("map/scores/conflicts", rr.LineStrips2D(joined, colors=style.CONFLICTS, radii=0.05, draw_order=27.0))
    counts = np.bincount(scores.judgement, minlength=len(JUDGEMENTS))
    judged = ", ".join(f"{count} {word}" for count, word in zip(counts, JUDGEMENTS, strict=True))
    pairs, sure = len(scores.rival_a), int(scores.sure.sum())
    scene.log_text(f"{judged}; {pairs} pairs in conflict; {sure} closed in pass 2; map {scores.share_rough:.0%} rough")
    table(scene, scores, "scored", without=["feature"])
    if len(scores.door):
        features: dict[str, Any] = {name: scores.feature[:, at] for at, name in enumerate(FEATURES)}
        rows = np.arange(len(scores.door))
        scene.columns("tables/door_features", "row", rows, rr.AnyValues.columns(door=scores.door, **features))


def draw_certificate(scene: Scene, certificate: Certificate) -> None:
    """Draw the lower bound as a line in the cost plot, and the proof as text."""
    last = scene.remembered.get("generations", 0)
    ends = np.array([0, max(last, 1)])
    bound = certificate.lower_bound
    scene.columns("plots/search/bound", "generation", ends, rr.Scalars.columns(scalars=[bound, bound]))
    scene.keep("plots/search/bound", rr.SeriesLines(colors=style.BOUND, names="lower bound"))
    proven = "**proven optimal**" if certificate.optimal else "not proven optimal"
    rows = {"cost": certificate.cost, "lower bound": bound, "gap": certificate.gap}
    table_rows = "".join(f"| {name} | {number:.6f} |\n" for name, number in rows.items())
    text = f"The choice of doors is {proven}.\n\n| | |\n|---|---|\n{table_rows}\nNo choice costs less than the bound.\n"
    scene.log("certificate", rr.TextDocument(text, media_type="text/markdown"))
    scene.log_text(f"{proven.strip('*')}: cost {certificate.cost:.4f}, bound {bound:.4f}, gap {certificate.gap:.4f}")
