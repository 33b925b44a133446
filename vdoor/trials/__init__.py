"""The method tried on maps whose truth is known: without each of its parts, and on the same maps changed."""

from vdoor.trials.ablation import ablation
from vdoor.trials.cases import Choice, Trial, Trials, read_trials
from vdoor.trials.changes import CHANGES, Change
from vdoor.trials.measure import Outcome, Row, measured, summarised
from vdoor.trials.robustness import changed, robustness
from vdoor.trials.variants import VARIANTS, Variant, variants_with

__all__ = [
    "CHANGES", "VARIANTS", "Change", "Choice", "Outcome", "Row", "Trial", "Trials", "Variant", "ablation", "changed",
    "measured", "read_trials", "robustness", "summarised", "variants_with",
]  # fmt: skip
