"""Maps whose numbers can be written: formats have no word for infinite, or for what is no number."""

from __future__ import annotations

import dataclasses

import numpy as np

from vdoor.errors import VdoorError
from vdoor.topology import TopologicalMap


def refuse_not_finite(topology: TopologicalMap) -> None:
    """VdoorError naming the first part of a map that has a number which is not finite, as damaged recordings have."""
    columns = {field.name: getattr(topology, field.name) for field in dataclasses.fields(topology)}
    pose = {f"frame.{name}": np.array(value, np.float64) for name, value in vars(topology.frame).items()}
    for name, values in (columns | pose).items():
        if isinstance(values, np.ndarray) and values.dtype == np.float64 and not np.isfinite(values).all():
            raise VdoorError(f"map: wanted finite numbers, found {values[~np.isfinite(values)].item(0)} in {name}")
