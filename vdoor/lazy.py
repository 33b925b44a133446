"""Names of a package that are imported on first use, so that nobody waits for modules that they do not use.

>>> attribute = on_first_use("vdoor", {"frame": ("Frame",)})
>>> attribute("Frame").__name__
'Frame'
"""

from __future__ import annotations

import importlib
from collections.abc import Callable, Mapping, Sequence
from typing import Any


def on_first_use(package: str, homes: Mapping[str, Sequence[str]]) -> Callable[[str], Any]:
    """A module's `__getattr__` for names by the module of the package that defines them.

    It raises AttributeError for any other name.
    """

    def attribute(name: str) -> Any:
        for module, names in homes.items():
            if name in names:
                return getattr(importlib.import_module(f"{package}.{module}"), name)
        raise AttributeError(f"module {package!r} has no attribute {name!r}")

    return attribute
