"""The one way something is said on stderr."""

import sys


def say(text: str) -> None:
    """One line on stderr, with the program's name before it."""
    sys.stderr.write(f"vdoor: {text}\n")
