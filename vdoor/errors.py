"""Errors that the user can fix, and how they are reported: one line on stderr."""

import contextlib
import difflib
import re
import sys
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path

LEAST_BEGUN = 3
"""Letters by which a name can be meant that begins with them."""


class VdoorError(ValueError):
    """Wrong use or input; the message gives the place, what was wanted, what was found, and the path last."""


class MapError(VdoorError):
    """A map file that cannot be read, or a map with nothing to divide."""


class MapWarning(UserWarning):
    """A map that can be read, but contains a likely mistake or left something to be assumed."""


class SettingError(VdoorError):
    """An unknown setting, or a value that the setting cannot have."""


class RecordingError(VdoorError):
    """A recording that is damaged, not vdoor's, or of another schema."""


@contextmanager
def naming(path: Path, kind: type[VdoorError] = VdoorError) -> Iterator[None]:
    """Append a file's path to errors of a kind about its content, unless they end with it."""
    try:
        yield
    except kind as error:
        text = str(error)
        raise type(error)(text if text.endswith(str(path)) else f"{text}: {path}") from error


def no_such(what: str, word: str, known: Iterable[str]) -> str:
    """Text for a word that is none of the known ones: the one that was probably meant, or all of them."""
    known = list(known)
    lower = {name.lower(): name for name in known}
    begun = [name for name in lower if len(word) >= LEAST_BEGUN and name.startswith(word.lower())]
    close = difflib.get_close_matches(word.lower(), lower, n=1) or begun
    meant = lower[close[0]] if close else ""
    hint = f"did you mean {meant!r}?" if meant else f"wanted one of {', '.join(known)}"
    return f"no {what} {word!r}; {hint}"


def say(text: str) -> None:
    """Write one line to stderr, prefixed with the program's name, without control codes that files may hold.

    Does nothing if there is no stderr or it cannot be written.
    """
    if sys.stderr is not None:
        with contextlib.suppress(OSError):
            sys.stderr.write(f"vdoor: {printable(' '.join(text.splitlines()))}\n")
            sys.stderr.flush()


NOT_PRINTABLE = re.compile(r"[^\t\n\x20-\x7e\xa0-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")
"""Characters that a terminal may interpret as control sequences, or that XML cannot contain."""


def printable(text: str) -> str:
    """Text with `NOT_PRINTABLE` characters, with which a file could control the terminal, replaced by ``?``."""
    return NOT_PRINTABLE.sub("?", text)
