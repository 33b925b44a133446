"""The generations of a search, held small."""

from __future__ import annotations

from array import array
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from vdoor.errors import RecordingError
from vdoor.method.search.generation import Generation
from vdoor.record import specs


class ConvergenceHistory(Sequence[Generation]):
    """The generations of a search, held as numbers and packed strings; each is made when asked for."""

    NUMBERS = tuple(name for name in specs(Generation) if name != "removed")

    def __init__(self) -> None:
        self._numbers = array("d")
        self._packed = bytearray()
        self.edges = 0

    def add(self, generation: Generation) -> None:
        """Take one more, which must choose among as many doors as those before."""
        found = len(generation.removed)
        if len(self) and found != self.edges:
            raise RecordingError(f"generation.removed: wanted {self.edges} doors in each, found {found}")
        self.edges = found
        self._packed += np.packbits(generation.removed).tobytes()
        self._numbers.extend(getattr(generation, name) for name in self.NUMBERS)

    def __len__(self) -> int:
        return len(self._numbers) // len(self.NUMBERS)

    def __getitem__(self, index: int) -> Generation:  # type: ignore[override]  # no slices
        row = range(len(self))[index]
        values: dict[str, Any] = {
            name: int(value) if spec.kind == "count" else float(value)
            for (name, (spec, _)), value in zip(specs(Generation).items(), self._rows[row], strict=False)
        }
        removed = np.unpackbits(self._strings[row], count=self.edges).astype(np.bool_)
        return Generation(**values, removed=removed)

    def numbers(self, name: str) -> NDArray[np.float64]:
        """One of the numbers (g,) of every generation, by its field's name."""
        return self._rows[:, self.NUMBERS.index(name)].copy()

    def choices(self, edge: int) -> NDArray[np.bool_]:
        """Whether the best string (g,) of every generation removes one edge."""
        return np.asarray(self._strings[:, edge // 8] >> (7 - edge % 8) & 1, np.bool_)

    @property
    def _rows(self) -> NDArray[np.float64]:
        return np.frombuffer(self._numbers, np.float64).reshape(len(self), len(self.NUMBERS))

    @property
    def _strings(self) -> NDArray[np.uint8]:
        return np.frombuffer(self._packed, np.uint8).reshape(len(self), -(-self.edges // 8))
