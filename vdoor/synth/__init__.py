"""Maps of our own: apartments drawn from a seed, with the truth about their rooms and doors beside them."""

from vdoor.synth.apartment import SyntheticMap, TrueDoor, synthesize
from vdoor.synth.settings import PRESETS, Apartment
from vdoor.synth.write import write_synthetic

__all__ = ["PRESETS", "Apartment", "SyntheticMap", "TrueDoor", "synthesize", "write_synthetic"]
