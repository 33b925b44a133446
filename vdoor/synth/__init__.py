"""Maps of our own: apartments, homes and offices drawn from a seed, with the truth about their rooms and doors.

`settings` has all that one can set; `apartment`, `home`, `laser_home` and `office` draw one kind each. A plan in metres
(`layout`) is painted on a fine raster (`canvas`) and furnished (`furniture`), a robot sees it (`scan`), the walls of
some maps are drawn in other ways (`wall_style`, `drawn_walls`), and what comes out is a map with its `truth`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import MappingProxyType
from typing import Any

import numpy as np

from vdoor.errors import SettingError, no_such
from vdoor.synth.apartment import draw_apartment
from vdoor.synth.home import draw_home
from vdoor.synth.laser_home import draw_laser_home
from vdoor.synth.office import draw_office
from vdoor.synth.settings import Apartment, Home, LaserHome, Office
from vdoor.synth.truth import SyntheticMap, TrueDoor, write_synthetic

__all__ = [
    "PRESETS",
    "Apartment",
    "Home",
    "LaserHome",
    "Office",
    "SyntheticMap",
    "TrueDoor",
    "kind_named",
    "synthesize",
    "write_synthetic",
]

_DRAW: Mapping[type, Callable[[Any, np.random.Generator], SyntheticMap]] = MappingProxyType(
    {
        Apartment: draw_apartment,  # the paper's kind: orthogonal, sparsely cluttered
        Home: draw_home,  # as a robot vacuum maps it
        LaserHome: draw_laser_home,  # as a robot with a laser scanner maps it
        Office: draw_office,  # a floor of an office building
    }
)

PRESETS: Mapping[str, Any] = MappingProxyType(  # Any: each kind has settings of its own, and checks them
    {
        "paper": Apartment(rooms=5, rooms_spread=1, cell_m=0.2),
        "paper-5cm": Apartment(rooms=5, rooms_spread=1, cell_m=0.05),
        "home": Home(),
        "laser-home": LaserHome(),
        "office": Office(),
    }
)


def kind_named(kind: str) -> Any:
    """The preset of a kind; `SettingError` for others."""
    if kind not in PRESETS:
        raise SettingError(f"--kind: {no_such('kind', kind, PRESETS)}")
    return PRESETS[kind]


def synthesize(settings: Apartment | Home | LaserHome | Office, rng: np.random.Generator) -> SyntheticMap:
    """Return one map of the settings' kind; the same generator state gives the same one.

    Raises `SettingError` if the rooms of an apartment do not fit.
    """
    return _DRAW[type(settings)](settings, rng)
