"""Every promise names a test that there is."""

from __future__ import annotations

import re

from project import HOME

PAGE = (HOME / "docs" / "promises.md").read_text()
TESTS = "\n".join(path.read_text() for path in (HOME / "tests").rglob("test_*.py"))


def test_every_promise_names_a_test_that_exists() -> None:
    rows = re.findall(r"^\| (?!promise|---)(.+?) \| (.+?) \|$", PAGE, re.MULTILINE)
    assert len(rows) >= 20
    for promise, tests in rows:
        names = re.findall(r"`([^`]+)`", tests)
        assert names, promise
        for name in names:
            assert is_there(name), (promise, name)


def is_there(name: str) -> bool:
    """Whether a name is a test's function, a test's file, or a command of the continuous integration."""
    if name.startswith("vdoor "):
        return name.removeprefix("vdoor ") in (HOME / ".ci" / "run").read_text()
    return (HOME / name).is_file() if name.startswith("tests/") else f"def {name}(" in TESTS
