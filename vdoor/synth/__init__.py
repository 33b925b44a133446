"""Maps of our own: apartments, homes and offices drawn from a seed, with the truth about their rooms and doors."""

from vdoor.synth.kinds import PRESETS, synthesize
from vdoor.synth.settings import Apartment, Home, Office
from vdoor.synth.truth import SyntheticMap, TrueDoor
from vdoor.synth.write import write_synthetic

__all__ = ["PRESETS", "Apartment", "Home", "Office", "SyntheticMap", "TrueDoor", "synthesize", "write_synthetic"]
