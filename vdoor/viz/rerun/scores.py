"""Tables of door scores, and the certificate as text."""

from __future__ import annotations

from typing import Any

import numpy as np
import rerun as rr

from vdoor.method.scoring.features import FEATURES
from vdoor.method.scoring.score import JUDGEMENTS, DoorScores
from vdoor.method.search.certificate import Certificate
from vdoor.viz.rerun.scene import Scene, rounded, table


def draw_scores(scene: Scene, scores: DoorScores) -> None:
    """Log what was judged, and the tables of scores and features."""
    counts = np.bincount(scores.judgement, minlength=len(JUDGEMENTS))
    judged = ", ".join(f"{count} {word}" for count, word in zip(counts, JUDGEMENTS, strict=True))
    pairs, sure = len(scores.rival_a), int(scores.sure.sum())
    scene.log_text(f"{judged}; {pairs} pairs in conflict; {sure} closed in pass 2; map {scores.share_rough:.0%} rough")
    table(scene, scores, "scored", without=["feature"])
    if len(scores.door):
        features: dict[str, Any] = {name: rounded(scores.feature[:, at]) for at, name in enumerate(FEATURES)}
        rows = np.arange(len(scores.door))
        scene.columns("tables/door_features", "row", rows, rr.AnyValues.columns(door=scores.door, **features))


def draw_certificate(scene: Scene, certificate: Certificate) -> None:
    """Write what is proven as text."""
    bound = certificate.lower_bound
    proven = "**proven optimal**" if certificate.optimal else "not proven optimal"
    rows = {"cost": certificate.cost, "lower bound": bound, "gap": certificate.gap}
    table_rows = "".join(f"| {name} | {number:.6f} |\n" for name, number in rows.items())
    text = f"The choice of doors is {proven}.\n\n| | |\n|---|---|\n{table_rows}\nNo choice costs less than the bound.\n"
    scene.log("certificate", rr.TextDocument(text, media_type="text/markdown"))
    scene.log_text(f"{proven.strip('*')}: cost {certificate.cost:.4f}, bound {bound:.4f}, gap {certificate.gap:.4f}")
