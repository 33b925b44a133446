"""Text of files that others may have made, fit to be shown."""

from __future__ import annotations

import re

NOT_PRINTABLE = re.compile(r"[^\t\n\x20-\x7e\xa0-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")
"""What a terminal might take for a command, and XML does not hold."""


def printable(text: str) -> str:
    """Text without the characters that a file could use to play tricks on a terminal."""
    return NOT_PRINTABLE.sub("?", text)
