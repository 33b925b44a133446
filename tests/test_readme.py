"""The README keeps its word."""

from __future__ import annotations

import re
from pathlib import Path

HOME = Path(__file__).parent.parent
README = (HOME / "README.md").read_text()


def test_ci_runs_the_test_command_of_the_readme() -> None:
    command = next(line for line in README.splitlines() if "pytest" in line)
    assert command in (HOME / ".ci" / "run").read_text().splitlines()


def test_files_it_links_to_exist() -> None:
    for target in re.findall(r"\]\(([^)#]+)\)", README):
        assert (HOME / target).exists(), target
