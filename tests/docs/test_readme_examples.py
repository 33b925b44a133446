"""Every example of the README and of docs/ runs, a page in one folder: code blocks, and commands within the text."""

from __future__ import annotations

import subprocess
import sys
import tomllib
from pathlib import Path

import pytest
import yaml
from project import HOME, PAGES

sys.path.insert(0, str(HOME / "docs"))
import blocks  # of the site, which shows what the same steps print

READ_ONLY = ("text", "toml", "yaml", "output")


@pytest.mark.parametrize("page", [page for page in PAGES if blocks.steps(page.read_text())], ids=lambda page: page.name)
def test_page_runs(page: Path, tmp_path: Path) -> None:
    text = page.read_text()
    blocks.ready(tmp_path)
    for step in blocks.steps(text):
        try:
            blocks.run(step, tmp_path)
        except Exception as error:
            line = text[: step.start].count("\n") + 1
            raise AssertionError(f"{page.name}, line {line}: {error}") from error


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_blocks_that_do_not_run_are_well_formed(page: Path) -> None:
    for step in blocks.steps(page.read_text()):
        assert step.kind in ("sh", "python", "inline", *READ_ONLY), step
        if step.kind == "toml":
            tomllib.loads(step.text)
        if step.kind == "yaml":
            yaml.safe_load(step.text)


def one(text: str, folder: Path) -> str:
    (step,) = blocks.steps(text)
    return blocks.run(step, folder)


def test_block_runs_as_its_reader_would(tmp_path: Path) -> None:
    assert one("```sh\necho one | tr a-z A-Z > there && cat there # says ONE\n```\n", tmp_path) == "ONE\n"
    assert one("```python\nprint(1 + 1)\n```\n", tmp_path) == "2\n"
    assert one("see `vdoor config --preset paper`", tmp_path).startswith("# Resample")
    assert one("```text\nfalse\n```\n", tmp_path) == ""


@pytest.mark.parametrize(
    "text",
    [
        "```sh\nfalse\n```\n",
        "```sh\ntrue # exit code 1\n```\n",
        "```sh\nvdoor run no_such_map.yaml\n```\n",
        "`vdoor show no_such_file.mcap`",
        "`vdoor view --no-such-option out.mcap`",
        "`vdoor shot out.mcap`",
        "`vdoor no-such-command x`",
        "```python\nassert False\n```\n",
    ],
)
def test_block_that_fails_is_noticed(text: str, tmp_path: Path) -> None:
    with pytest.raises((AssertionError, subprocess.SubprocessError)):
        one(text, tmp_path)
