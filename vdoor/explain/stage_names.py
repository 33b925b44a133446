"""Stages by name, for all commands alike: the name that `vdoor show` lists, or that of a tab of the viewer."""

from __future__ import annotations

from typing import Never

from vdoor.errors import SettingError, no_such
from vdoor.explain.stages import OVERVIEW, tabs_of, view_of
from vdoor.pipeline import RECORDS


def tab_names() -> tuple[str, ...]:
    """All tabs, in order."""
    return tabs_of(RECORDS, {})


def stage_names() -> tuple[str, ...]:
    """All stages, in order."""
    return tuple(record.topic for record in RECORDS)


def stages_named(word: str) -> tuple[str, ...]:
    """The stage of that name, or all that the tab of that name shows, in any case of letters.

    Raises `SettingError` if there is neither.
    """
    if word.lower() in stage_names():
        return (word.lower(),)
    found = tuple(record.topic for record in RECORDS if view_of(record).tab.lower() == word.lower())
    return found or _refuse(word)


def tab_named(word: str) -> str:
    """The tab of that name, or the one that shows the stage of that name, in any case of letters.

    Raises `SettingError` if there is neither.
    """
    tab = next((tab for tab in tab_names() if tab.lower() == word.lower()), "")
    record = next((record for record in RECORDS if record.topic == word.lower()), None)
    return tab or (view_of(record).tab if record else _refuse(word))


def _refuse(word: str) -> Never:
    only_tabs = [tab for tab in tab_names() if tab != OVERVIEW and tab.lower() not in stage_names()]
    raise SettingError(f"--stage: {no_such('stage', word, [*stage_names(), *only_tabs])}")
