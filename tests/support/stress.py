"""How much the stress tests do: a sample in CI, all of it with STRESS=1 in the environment."""

from __future__ import annotations

import os
import random
import signal
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType
from typing import TypeVar

FULL = bool(os.environ.get("STRESS"))
LIMIT_S = 10
T = TypeVar("T")


def count(sample: int, full: T) -> int | T:
    return full if FULL else sample


class TooSlowError(Exception):
    """More than `LIMIT_S` of processor time."""


@contextmanager
def limited() -> Iterator[None]:
    """Stop what takes more than `LIMIT_S` of processor time, however loaded the machine is."""

    def stop(number: int, _: FrameType | None) -> None:
        raise TooSlowError(number)

    before = signal.signal(signal.SIGPROF, stop)
    signal.setitimer(signal.ITIMER_PROF, LIMIT_S)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0)
        signal.signal(signal.SIGPROF, before)


class Findings:
    """What went wrong, case by case: a long run goes on after the first, and all are claimed not to be at its end."""

    def __init__(self) -> None:
        self.found: list[str] = []

    @contextmanager
    def of(self, case: object) -> Iterator[None]:
        try:
            yield
        except Exception as error:  # noqa: BLE001  # whatever it is, it should not have come
            self.found.append(f"{case}: {type(error).__name__}: {str(error)[:300]}")

    def claim_none(self) -> None:
        assert not self.found, f"{len(self.found)} findings, the first of them:\n" + "\n".join(self.found[:20])


def corrupted(data: bytes, seed: int) -> bytes:
    """Give the bytes with one to four changes of the kinds that disks, cables and attackers make."""
    rng = random.Random(seed)  # noqa: S311  # no secret
    for _ in range(rng.choice((1, 1, 1, 2, 4))):
        data = rng.choice(CHANGES)(data or b"\0", rng)
    return data


def _flip(data: bytes, rng: random.Random) -> bytes:
    at = rng.randrange(len(data))
    return data[:at] + bytes([data[at] ^ 1 << rng.randrange(8)]) + data[at + 1 :]


def _cut(data: bytes, rng: random.Random) -> bytes:
    return data[: rng.randrange(len(data))]


def _drop(data: bytes, rng: random.Random) -> bytes:
    at = rng.randrange(len(data))
    return data[:at] + data[at + rng.randint(1, 64) :]


def _insert(data: bytes, rng: random.Random) -> bytes:
    at = rng.randrange(len(data) + 1)
    return data[:at] + rng.randbytes(rng.randint(1, 64)) + data[at:]


def _extreme(data: bytes, rng: random.Random) -> bytes:
    """Put a number that is likely to be at a limit in the place of other bytes."""
    number = rng.choice((0, 1, 2**7, 2**15, 2**31 - 1, 2**31, 2**32 - 1, 2**63, 2**64 - 1))
    put = number.to_bytes(8, rng.choice(("little", "big")))[: rng.choice((1, 2, 4, 8))]
    at = rng.randrange(len(data))
    return data[:at] + put + data[at + len(put) :]


def _digits(data: bytes, rng: random.Random) -> bytes:
    """Put another text where a number or word is."""
    at = rng.randrange(len(data))
    put = rng.choice((b"-1", b"nan", b"1e999", b"9" * 5000, b"null", b"[" * 3000, b'"', b"\xff", "²".encode(), b"\n"))
    return data[:at] + put + data[at + rng.randint(0, 8) :]


def _repeat(data: bytes, rng: random.Random) -> bytes:
    at = rng.randrange(len(data))
    piece = data[at : at + rng.randint(1, 512)]
    return data[:at] + piece * rng.randint(2, 50) + data[at:]


CHANGES: tuple[Callable[[bytes, random.Random], bytes], ...] = (
    _flip,
    _flip,
    _cut,
    _drop,
    _insert,
    _extreme,
    _digits,
    _repeat,
)
