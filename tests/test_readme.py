"""The README keeps its word."""

from __future__ import annotations

import re
from pathlib import Path

HOME = Path(__file__).parent.parent
README = (HOME / "README.md").read_text()


def test_ci_runs_the_test_command_of_the_readme() -> None:
    command = next(line for line in README.splitlines() if "pytest" in line)
    assert command in (HOME / ".ci" / "run").read_text().splitlines()


def test_python_example_runs() -> None:
    example = re.search(r"```python\n(.*?)```", README, re.DOTALL)
    assert example
    names: dict[str, object] = {}
    exec(example[1].replace('"recordings/', f'"{HOME}/recordings/'), names)  # noqa: S102  # the README's own words
    assert names["graph"].number_of_edges() == len(names["topology"].doors) > 0  # type: ignore[attr-defined]  # checked by running


def test_files_it_links_to_exist() -> None:
    for target in re.findall(r"\]\(([^)#]+)\)", README):
        assert (HOME / target).exists(), target
