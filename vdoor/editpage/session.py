"""What the page asks for, answered from the result on disk: the page itself, and edits, one step each."""

from __future__ import annotations

import hashlib
import json
import threading
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from importlib import resources
from pathlib import Path
from typing import Any

from vdoor.editing.edits import read_edits
from vdoor.errors import SettingError, VdoorError
from vdoor.export.geometry import refuse_not_finite
from vdoor.export.report import title_of
from vdoor.export.report.data import page_data, result_data
from vdoor.export.report.document import Addition, document
from vdoor.results.editor import ACTIONS, EDITS, RefusedError, ResultEditor
from vdoor.results.reading import read_finished
from vdoor.results.steps import Steps, StepsOnDisk
from vdoor.results.writing import NAMES
from vdoor.topology import TopologicalMap

STYLES = ("edit.css",)
SCRIPTS = ("server.js", "tools.js", "form.js", "gestures.js", "begin.js")
FILES = (*NAMES, EDITS)
"""The files of a result: edits change some, and another run into the folder all."""
SENTENCES = {
    "no room there": "There is no room at this place.",
    "no door there": "There is no door within half a metre of this place.",
    "rooms do not touch": "These rooms have no door between them, so they cannot become one.",
    "parts nothing": "This line does not part the room: it must reach from wall to wall, with 0.25 m² on either side.",
}
"""What is said of an edit that cannot be done, by its verdict."""
MOST_LISTED = 200


class StaleError(VdoorError):
    """The page shows a result that has changed since."""


class Session:
    """One result that is edited."""

    def __init__(self, result: Path) -> None:
        if not result.is_dir():
            wanted = "a folder from `vdoor run --out`"
            raise SettingError(f"edit: wanted {wanted}, found {'a file' if result.exists() else 'none'}: {result}")
        self._provenance = read_finished(result, provenance=True).provenance
        self._grid: str | None = None
        """The digest of the map that the provenance is of."""
        self.result = result
        self._disk = StepsOnDisk(result, FILES)
        self._one_at_a_time = threading.Lock()

    @contextmanager
    def opened(self) -> Iterator[None]:
        """Keep other pages from this result; finish what a killed one has begun."""
        with self._disk.only_here():
            self._disk.current()
            yield

    def page(self) -> str:
        """The report with the tools."""
        with self._one_at_a_time:
            steps = self._disk.current()
            finished = read_finished(self.result, provenance=True)
        refuse_not_finite(finished.topology)
        data = page_data(finished.topology, finished.provenance, finished.annotations)
        place = resources.files("vdoor.editpage") / "page"
        addition = Addition(place, STYLES, SCRIPTS, "tools.html")
        return document(title_of(finished.provenance), data | {"edit": self._about(steps)}, addition)

    def state(self) -> dict[str, Any]:
        """What the page shows of the result as it is now."""
        with self._one_at_a_time:
            return self._state(self._disk.current())

    def do(self, action: str, words: Sequence[str], *, seen: str) -> dict[str, Any]:
        """The state after an edit with the words of its command, which is then on disk, and what was done.

        Raises `VdoorError` with a sentence if it cannot be done, and `StaleError` if the page has seen another state.
        """
        if action not in ACTIONS or len(words) != ACTIONS[action].words:
            raise SettingError(f"wanted one of {', '.join(ACTIONS)} with its words, found {action!r}")
        with self._one_at_a_time:
            steps = self._seen(seen)
            change = ACTIONS[action].change(ResultEditor(self.result), *words)
            if not change.files:
                return self._state(steps) | {"said": "Nothing to change."}
            steps = self._disk.do(steps, change.said, {path.name: content for path, content in change.files})
            return self._shown(steps, change.topology) | {"said": change.said}

    def go(self, by: int, *, seen: str) -> dict[str, Any]:
        """The state after undoing (-1) or redoing (1) a step."""
        with self._one_at_a_time:
            before = self._seen(seen)
            steps = self._disk.go(before, by)
            said = f"Undone: {before.undoes}" if by < 0 else f"Done again: {before.redoes}"
            return self._state(steps) | {"said": said}

    def sentence(self, error: VdoorError) -> str:
        """An error as a sentence for the page, without the folder's path."""
        if isinstance(error, RefusedError):
            return SENTENCES[error.verdict]
        return str(error).removesuffix(f": {self.result}")

    def _seen(self, version: str) -> Steps:
        steps = self._disk.current()
        if version != _version(steps):
            raise StaleError("The result has changed since; this is how it is now.")
        return steps

    def _state(self, steps: Steps) -> dict[str, Any]:
        return self._shown(steps, read_finished(self.result).topology)

    def _shown(self, steps: Steps, topology: TopologicalMap) -> dict[str, Any]:
        refuse_not_finite(topology)
        if self._grid != (now := steps.now.files["grid.png"]):
            self._provenance, self._grid = read_finished(self.result, provenance=True).provenance, now
        return {**result_data(topology, self._provenance), "edit": self._about(steps)}

    def _about(self, steps: Steps) -> dict[str, Any]:
        file = self.result / EDITS
        edits = [str(edit) for edit in read_edits(file)] if file.exists() else []
        about = {
            "version": _version(steps),
            "grid": steps.now.files["grid.png"],
            "undo": steps.undoes,
            "redo": steps.redoes,
            "file": str(file),
        }
        return about | {"edits": edits[-MOST_LISTED:], "count": len(edits)}


def _version(steps: Steps) -> str:
    """A digest of all files that edits change."""
    return hashlib.sha256(json.dumps(dict(steps.now.files), sort_keys=True).encode()).hexdigest()
