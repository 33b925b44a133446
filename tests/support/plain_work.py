"""Work for engines; in a module of its own, since worker processes import it."""

from __future__ import annotations

import os
import signal
import time
import warnings
from pathlib import Path

import numpy as np

from vdoor.errors import MapError


def squared(number: int) -> int:
    return number * number


def reciprocal(number: int) -> float:
    """The reciprocal, with a warning; late for small numbers, so that items end out of order."""
    time.sleep(0.2 / (1 + number * number))
    if number == 0:
        raise MapError("zero: wanted another number, found 0")
    warnings.warn(f"number {number}", stacklevel=1)
    return 1 / number


def die_of(number: int, poison: int, log: Path) -> int:
    """Note that the number was tried; die of the poison."""
    with log.open("a") as file:
        file.write(f"{number}\n")
    if number == poison:
        os.kill(os.getpid(), signal.SIGKILL)
    return number


def eat(megabytes: int) -> int:
    """Take so much memory, and fill it."""
    return int(np.full(megabytes << 20, 1, np.uint8).sum() >> 20)


def own_process(_: int) -> int:
    return os.getpid()
