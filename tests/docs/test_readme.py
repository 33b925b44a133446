"""The README keeps its word, and pages lead where they say."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from project import HOME, PAGES

README = (HOME / "README.md").read_text()
MOST_LINES = 150


def test_ci_runs_the_test_command_of_the_readme() -> None:
    command = next(line for line in README.splitlines() if "pytest" in line)
    assert command in (HOME / ".ci" / "run").read_text().splitlines()
    assert command in (HOME / "CONTRIBUTING.md").read_text().splitlines()


def test_readme_is_short() -> None:
    assert len(README.splitlines()) <= MOST_LINES


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_files_it_links_to_exist(page: Path) -> None:
    for target in re.findall(r"\]\(([^)#:]+)(?:#[^)]*)?\)", page.read_text()):
        assert (page.parent / target).exists(), target
