"""Experiments on maps with known truth: ablation, robustness, sweeps, benchmark and search study."""

from vdoor.experiments.ablation import VARIANTS, Variant, ablation, variants_with
from vdoor.experiments.cases import Choice, Trial, Trials, read_trials, trial_of
from vdoor.experiments.changes import CHANGES, Change
from vdoor.experiments.measure import Outcome, Row, measured, summarised
from vdoor.experiments.robustness import changed, robustness
from vdoor.experiments.steps import Setting, Step, planned
from vdoor.experiments.sweep import Point, by_setting, spread, swept

__all__ = [
    "CHANGES", "VARIANTS", "Change", "Choice", "Outcome", "Point", "Row", "Setting", "Step", "Trial", "Trials",
    "Variant", "ablation", "by_setting", "changed", "measured", "planned", "read_trials",
    "robustness", "spread", "summarised", "swept", "trial_of", "variants_with",
]  # fmt: skip
