"""What can go wrong in a way the user can mend, and how the user is told: one line on stderr."""

import re
import sys


class VdoorError(ValueError):
    """Wrong use or input: the message names the place, what was wanted, what was found, the path last."""


class MapError(VdoorError):
    """A map file that cannot be read, or a map that has nothing to divide."""


class MapWarning(UserWarning):
    """A map that can be read but likely says what was not meant, or leaves something to be assumed."""


class SettingError(VdoorError):
    """A setting that does not exist or cannot have that value."""


class RecordingError(VdoorError):
    """A recording that is damaged, foreign or of another schema."""


def say(text: str) -> None:
    """One line on stderr, with the program's name before it."""
    sys.stderr.write(f"vdoor: {text}\n")


NOT_PRINTABLE = re.compile(r"[^\t\n\x20-\x7e\xa0-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")
"""What a terminal might take for a command, and XML does not hold."""


def printable(text: str) -> str:
    """Text without the characters that a file could use to play tricks on a terminal."""
    return NOT_PRINTABLE.sub("?", text)
