"""What every test may ask for."""

from __future__ import annotations

import pytest
from commands import Command


@pytest.fixture
def command() -> Command:
    """The command, called in the test's process."""
    return Command()
