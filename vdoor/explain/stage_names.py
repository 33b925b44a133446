"""Stages by name, for all commands alike: the name that `vdoor show` lists, or that of a tab of the viewer."""

from __future__ import annotations

from typing import Never

from vdoor.errors import SettingError, no_such
from vdoor.explain.stages import OVERVIEW, tabs_of, view_of
from vdoor.history.records import RECORD_OF, STAGES


def tab_names() -> tuple[str, ...]:
    """All tabs, in order."""
    return tabs_of(RECORD_OF.values(), {})


def stages_named(word: str) -> tuple[str, ...]:
    """The stage of that name, or all that the tab of that name shows, in any case of letters.

    Raises `SettingError` if there is neither.
    """
    if word.lower() in STAGES:
        return (word.lower(),)
    found = tuple(stage for stage in STAGES if view_of(RECORD_OF[stage]).tab.lower() == word.lower())
    return found or _refuse(word)


def tab_named(word: str) -> str:
    """The tab of that name, or the one that shows the stage of that name, in any case of letters.

    Raises `SettingError` if there is neither.
    """
    tab = next((tab for tab in tab_names() if tab.lower() == word.lower()), "")
    record = RECORD_OF.get(word.lower())
    return tab or (view_of(record).tab if record else _refuse(word))


def _refuse(word: str) -> Never:
    only_tabs = [tab for tab in tab_names() if tab != OVERVIEW and tab.lower() not in STAGES]
    raise SettingError(f"--stage: {no_such('stage', word, [*STAGES, *only_tabs])}")
