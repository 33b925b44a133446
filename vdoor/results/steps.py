"""The steps of an editing page: each state of the edited files, kept on disk, so that any can be brought back.

The folder `undo` in the result holds the contents by their digests, and `steps.json`: the steps in order, which of them
the files are at, and whether the files are written. It is written before the files, so that a page that is killed
in between is finished by the next one.
"""

from __future__ import annotations

import contextlib
import dataclasses
import fcntl
import hashlib
import json
import os
import re
import zlib
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from vdoor.errors import VdoorError
from vdoor.files import make_folder, read_regular
from vdoor.partial import together, write_whole

FOLDER = "undo"
MOST_STEPS = 200
"""Older steps are forgotten."""
MOST_BYTES = 1 << 30
OPENED, ELSEWHERE = "as it was opened", "a change made elsewhere"
DIGEST = re.compile("[0-9a-f]{64}")


@dataclass(frozen=True)
class Step:
    """What was done, and the files after it: the digest of each by its name, None for a file that is missing."""

    said: str
    files: Mapping[str, str | None]


@dataclass(frozen=True)
class Steps:
    """All steps, the oldest first, never empty."""

    steps: tuple[Step, ...]
    at: int
    """The step that the files are at."""
    written: bool = True
    """False from before the files are written until all are."""

    @property
    def now(self) -> Step:
        """The step that the files are at."""
        return self.steps[self.at]

    @property
    def undoes(self) -> str:
        """What going back undoes; empty if there is nothing."""
        return self.now.said if self.at else ""

    @property
    def redoes(self) -> str:
        """What going on does again; empty if there is nothing."""
        return self.steps[self.at + 1].said if self.at + 1 < len(self.steps) else ""

    def followed_by(self, step: Step) -> Steps:
        """The steps up to now and one more, at which the files then are."""
        kept = (*self.steps[: self.at + 1], step)[-MOST_STEPS:]
        return Steps(kept, len(kept) - 1)


class StepsOnDisk:
    """The steps of some files of one folder."""

    def __init__(self, folder: Path, names: tuple[str, ...]) -> None:
        self.place = folder / FOLDER
        self._files = {name: folder / name for name in names}

    @contextmanager
    def only_here(self) -> Iterator[None]:
        """Refuse with `VdoorError` if another page has these steps open; a page that was killed has not."""
        make_folder(self.place)
        with contextlib.ExitStack() as stack:
            number = os.open(self.place / "lock", os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, 0o600)
            stack.callback(os.close, number)
            try:
                fcntl.flock(number, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except OSError:
                raise VdoorError(f"edit: this result is open in another page: {self.place.parent}") from None
            yield

    def current(self) -> Steps:
        """The steps with the files as they are now: a change made elsewhere is a step as well.

        Finishes what a page that was killed had begun.
        """
        steps = self._read()
        if steps is not None and not steps.written and self._all_known(steps):
            steps = self._write_files(steps)
        files = {name: self._keep(path.read_bytes() if path.is_file() else None) for name, path in self._files.items()}
        if steps is None:
            steps = Steps((Step(OPENED, files),), 0)
        elif files != steps.now.files:
            steps = steps.followed_by(Step(ELSEWHERE, files))
        else:
            return steps
        return self._store(steps)

    def do(self, steps: Steps, said: str, contents: Mapping[str, bytes]) -> Steps:
        """Write new contents of some files, as one more step."""
        changed = {name: self._keep(content) for name, content in contents.items()}
        return self._write_files(steps.followed_by(Step(said, {**steps.now.files, **changed})))

    def go(self, steps: Steps, by: int) -> Steps:
        """Bring the files back to the step before (-1) or after (1)."""
        at = steps.at + by
        if not 0 <= at < len(steps.steps):
            raise VdoorError("there is nothing to undo" if by < 0 else "there is nothing to redo")
        return self._write_files(dataclasses.replace(steps, at=at))

    def _all_known(self, steps: Steps) -> bool:
        """Whether each file is as it was at one of the steps, so that writing it loses nothing."""
        known = {name: {step.files[name] for step in steps.steps} for name in self._files}
        return all(_digest(path) in known[name] for name, path in self._files.items())

    def _write_files(self, steps: Steps) -> Steps:
        """Write the files as they are at the current step; that they will be is stored first."""
        contents = {name: self._kept(digest) for name, digest in steps.now.files.items()}
        self._store(dataclasses.replace(steps, written=False))
        with together() as staged:
            for name in sorted(contents, key=lambda name: name != "map.json"):  # it holds the checksums of the others
                content, path = contents[name], self._files[name]
                if content is not None and _digest(path) != steps.now.files[name]:
                    staged.add(path, content)
        for name, content in contents.items():
            if content is None:
                self._files[name].unlink(missing_ok=True)
        return self._store(dataclasses.replace(steps, written=True))

    def _keep(self, content: bytes | None) -> str | None:
        """Store a content, if it is not stored yet, and return its digest."""
        if content is None:
            return None
        digest = hashlib.sha256(content).hexdigest()
        path = self.place / digest
        if not path.exists():
            write_whole(make_folder(self.place) / digest, zlib.compress(content))
        return digest

    def _kept(self, digest: str | None) -> bytes | None:
        if digest is None:
            return None
        path = self.place / digest
        packed = read_regular(path, "a step of an editing page", limit=MOST_BYTES)
        try:
            content = zlib.decompressobj().decompress(packed, MOST_BYTES)
        except zlib.error:
            content = b""
        if hashlib.sha256(content).hexdigest() != digest:
            raise VdoorError(f"undo: wanted the content that was stored, found another: {path}")
        return content

    def _store(self, steps: Steps) -> Steps:
        """Write the list of steps, and drop contents that no step needs any more."""
        text = json.dumps(dataclasses.asdict(steps), indent=1, ensure_ascii=False)
        write_whole(self.place / "steps.json", text.encode())
        needed = {digest for step in steps.steps for digest in step.files.values()}
        for path in self.place.iterdir():
            if DIGEST.fullmatch(path.name) and path.name not in needed:
                path.unlink()
        return steps

    def _read(self) -> Steps | None:
        path = self.place / "steps.json"
        if not path.exists():
            return None
        try:
            table = json.loads(read_regular(path, "the steps of an editing page", limit=MOST_BYTES))
            return self._parsed(table)
        except (ValueError, KeyError, TypeError, AttributeError, RecursionError) as error:
            found = f"steps.json: wanted the steps of an editing page, found something else ({error})"
            raise VdoorError(f"{found}; without the folder a new list begins: {self.place}") from error

    def _parsed(self, table: Mapping[str, Any]) -> Steps:
        """The steps of a table; raises `ValueError` and similar exceptions for any other."""
        steps = tuple(Step(str(row["said"]), dict(row["files"])) for row in table["steps"])
        for step in steps:
            digests = [digest for digest in step.files.values() if digest is not None]
            if set(step.files) != set(self._files) or not all(DIGEST.fullmatch(digest) for digest in digests):
                raise ValueError("files")
        if type(table["at"]) is not int or not 0 <= table["at"] < len(steps):
            raise ValueError("at")
        return Steps(steps, table["at"], written=table["written"] is True)


def _digest(path: Path) -> str | None:
    return hashlib.sha256(path.read_bytes()).hexdigest() if path.is_file() else None
