"""What axe-core finds in a page, if it is installed."""

from __future__ import annotations

import importlib.util
from pathlib import Path

import pytest
from browser import Browser


def serious_findings(window: Browser) -> list[str]:
    """The rules of axe-core that the page breaks seriously, with the first place; the test is skipped without it."""
    package = importlib.util.find_spec("axe_core_python")
    if package is None or package.origin is None:
        pytest.skip("no axe-core: wanted the package axe-core-python, which the extra `dev` installs")
    window.run(f"{(Path(package.origin).parent / 'axe.min.js').read_text('utf-8')};0")
    found = window.run("axe.run().then(told => told.violations)")
    return [
        f"{rule['id']}: {rule['nodes'][0]['html'][:100]}" for rule in found if rule["impact"] in ("serious", "critical")
    ]
