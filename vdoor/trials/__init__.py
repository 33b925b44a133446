"""The method tried on maps whose truth is known: without each of its parts, and on the same maps changed."""

from vdoor.trials.ablation import ablation
from vdoor.trials.cases import Choice, Trial, Trials, read_trials
from vdoor.trials.changes import CHANGES, Change
from vdoor.trials.drawn import trial_of
from vdoor.trials.measure import Outcome, Row, measured, summarised
from vdoor.trials.robustness import changed, robustness
from vdoor.trials.steps import Setting, Step, planned
from vdoor.trials.sweep import Point, by_setting, spread, swept
from vdoor.trials.variants import VARIANTS, Variant, variants_with

__all__ = [
    "CHANGES", "VARIANTS", "Change", "Choice", "Outcome", "Point", "Row", "Setting", "Step", "Trial", "Trials",
    "Variant", "ablation", "by_setting", "changed", "measured", "planned", "read_trials",
    "robustness", "spread", "summarised", "swept", "trial_of", "variants_with",
]  # fmt: skip
