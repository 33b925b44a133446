"""Settings as a TOML file or as ``stage.field=value``, applied to frozen dataclasses. Independent of the stages."""

from __future__ import annotations

import ast
import dataclasses
import inspect
import itertools
import json
import math
import textwrap
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any, TypeVar, get_args, get_type_hints

from vdoor.errors import SettingError, no_such
from vdoor.files import read_regular

T = TypeVar("T")
Choices = Mapping[str, Mapping[str, type]]
"""Stages with alternative classes: stage -> value of its ``method`` -> class."""

METHOD = "method"
MOST_BYTES = 1 << 24
"""Largest size of a settings file."""
DEFAULT_PRESET = "default"
"""The preset used if none is named, in the command and in Python."""


@dataclasses.dataclass(frozen=True)
class Within:
    """The range of a setting, inclusive: ``cell_m: Annotated[float, Within(0, 10)] = 0.2``."""

    low: float
    high: float


def check_range(value: Any, low: float, high: float, place: str) -> None:
    """Raise `SettingError` unless the value lies between the two, ends included; nan does not."""
    if not low <= value <= high:
        raise SettingError(f"{place}: wanted {low:g} to {high:g}, found {value!r}")


def settings_of(pipeline: object, choices: Choices) -> dict[str, dict[str, Any]]:
    """The settings of a run's stages as nested tables; `with_settings` reads them back.

    Stages that are not part of the run, having `asked` false, are left out.
    """
    tables = all_settings_of(pipeline, choices)
    return {name: table for name, table in tables.items() if getattr(getattr(pipeline, name), "asked", True)}


def full_names(settings: Mapping[str, Mapping[str, Any]], field: str) -> list[str]:
    """The settings of that name, each as `stage.field`."""
    return [f"{stage}.{field}" for stage, table in settings.items() if field in table]


def all_settings_of(pipeline: object, choices: Choices) -> dict[str, dict[str, Any]]:
    """The settings of all stages as nested tables, whether a run has them or not."""
    tables: dict[str, dict[str, Any]] = {}
    for field in dataclasses.fields(pipeline):  # type: ignore[arg-type]  # any pipeline dataclass
        stage = getattr(pipeline, field.name)
        values = {part.name: _plain(getattr(stage, part.name)) for part in dataclasses.fields(stage)}
        if field.name in choices:
            names = {kind: name for name, kind in choices[field.name].items()}
            values = {METHOD: names[type(stage)], **values}
        tables[field.name] = values
    return tables


def with_settings(pipeline: T, tables: Mapping[str, Any], choices: Choices, *, place: str = "settings") -> T:
    """The pipeline with some settings replaced; raises SettingError naming `place`, the setting and valid values."""
    stages = {field.name: getattr(pipeline, field.name) for field in dataclasses.fields(pipeline)}  # type: ignore[arg-type]  # any pipeline dataclass
    changed = {}
    for name, table in tables.items():
        _check_name(name, stages, place, "stage")
        if not isinstance(table, Mapping):
            raise SettingError(f"{place}: {name}: wanted a table of settings, found {table!r}")
        stage, values = stages[name], dict(table)
        if METHOD in values and name in choices:
            method = values.pop(METHOD)
            _check_name(str(method), choices[name], f"{place}: {name}", METHOD)
            if type(stage) is not choices[name][method]:
                stage = choices[name][method]()
        changed[name] = replaced(stage, values, f"{place}: {name}")
    return dataclasses.replace(pipeline, **changed)  # type: ignore[type-var]  # any pipeline dataclass


def replaced(stage: Any, values: Mapping[str, Any], place: str) -> Any:
    """A stage dataclass with some settings replaced; types and ranges are checked."""
    current = {field.name: getattr(stage, field.name) for field in dataclasses.fields(stage)}
    ranges, hints = ranges_of(type(stage)), get_type_hints(type(stage))
    for name, value in values.items():
        _check_name(name, current, place, "setting")
        if hints[name] == tuple[str, ...]:
            current[name] = _strings(value, f"{place}.{name}")
            continue
        current[name] = _converted(current[name], value, f"{place}.{name}")
        if name in ranges:
            check_range(current[name], ranges[name].low, ranges[name].high, f"{place}.{name}")
    return type(stage)(**current)


def _converted(default: Any, value: Any, place: str) -> Any:
    """The value converted to the type of the default; integers are accepted for floats."""
    if isinstance(default, bool) or isinstance(value, bool):
        good = isinstance(default, bool) and isinstance(value, bool)
    elif isinstance(default, float):
        good, value = isinstance(value, (int, float)), float(value) if isinstance(value, (int, float)) else value
        good = good and math.isfinite(value)
    elif isinstance(default, tuple):
        good = isinstance(value, (list, tuple)) and all(type(part) in (int, float) for part in value)
        good = good and all(map(math.isfinite, value))
        value = tuple(map(float, value)) if good else value
    else:
        good = isinstance(value, type(default))
    if not good:
        raise SettingError(f"{place}: wanted {_kind(default)}, found {value!r}")
    return value


def _strings(value: Any, place: str) -> tuple[str, ...]:
    """The value as a tuple of strings."""
    if not isinstance(value, (list, tuple)) or not all(isinstance(part, str) for part in value):
        raise SettingError(f"{place}: wanted a list of strings, found {value!r}")
    return tuple(value)


def _kind(default: Any) -> str:
    names = {bool: "true or false", int: "a whole number", float: "a finite number", tuple: "a list of finite numbers"}
    return names.get(type(default), "a string")


def _check_name(name: str, known: Iterable[str], place: str, what: str) -> None:
    known = list(known)
    if name not in known:
        raise SettingError(f"{place}: {no_such(what, name, known)}")


def read_toml(path: Path) -> dict[str, Any]:
    """The tables of a TOML settings file; raises SettingError if it cannot be read."""
    import tomllib  # noqa: PLC0415  # its grammar is compiled when it is loaded

    try:
        return tomllib.loads(read_regular(path, "settings as TOML", limit=MOST_BYTES, error=SettingError).decode())
    except SettingError:
        raise
    except (ValueError, RecursionError) as error:  # ValueError: also for a number with thousands of digits
        raise SettingError(f"settings file: wanted TOML, found: {error}: {path}") from error


def parse_assignments(assignments: Iterable[str]) -> dict[str, dict[str, Any]]:
    """Tables from ``stage.field=value``; values are TOML, bare words are strings."""
    import tomllib  # noqa: PLC0415  # its grammar is compiled when it is loaded

    tables: dict[str, dict[str, Any]] = {}
    for text in assignments:
        name, equals, value = text.partition("=")
        stage, dot, field = name.strip().partition(".")
        if not (equals and dot and stage and field):
            raise SettingError(f"--set: wanted stage.field=value, found {text!r}")
        try:
            parsed = tomllib.loads(f"value = {value}")["value"]
        except (ValueError, RecursionError):
            parsed = value.strip()
        tables.setdefault(stage, {})[field] = parsed
    return tables


def to_toml(pipeline: object, choices: Choices) -> str:
    """All settings as a TOML file, each below a comment with its meaning."""
    parts = []
    for name, table in all_settings_of(pipeline, choices).items():
        if not table:
            continue
        stage = getattr(pipeline, name)
        lines = [f"# {(inspect.getdoc(stage) or '').splitlines()[0]}", f"[{name}]"]
        if METHOD in table and name in choices:
            lines += [f"# One of {', '.join(choices[name])}", f"{METHOD} = {json.dumps(table[METHOD])}"]
        parts.append("\n".join([*lines, *commented(stage)]))
    return "\n\n".join(parts) + "\n"


def commented(stage: Any) -> list[str]:
    """Lines of TOML for the settings of one dataclass, each below a comment with its meaning and range."""
    meaning, ranges = field_docs(type(stage)), ranges_of(type(stage))
    lines = []
    for field in dataclasses.fields(stage):
        span = f"{ranges[field.name].low:g} to {ranges[field.name].high:g}" if field.name in ranges else ""
        note = " ".join(part for part in (meaning.get(field.name), span and f"({span})") if part)
        lines += [f"# {line}" for line in textwrap.wrap(note, 100)]
        lines.append(f"{field.name} = {json.dumps(_plain(getattr(stage, field.name)), ensure_ascii=False)}")
    return lines


def ranges_of(kind: type) -> dict[str, Within]:
    """The range of each setting that has one."""
    hints = get_type_hints(kind, include_extras=True)
    return {name: note for name, hint in hints.items() for note in get_args(hint)[1:] if isinstance(note, Within)}


def field_docs(kind: type) -> dict[str, str]:
    """The docstring below each field of a class, by field name."""
    body = ast.parse(textwrap.dedent(inspect.getsource(kind))).body[0]
    docs: dict[str, str] = {}
    statements = body.body if isinstance(body, ast.ClassDef) else []
    for field, below in itertools.pairwise(statements):
        if isinstance(field, ast.AnnAssign) and isinstance(field.target, ast.Name) and isinstance(below, ast.Expr):
            docs[field.target.id] = " ".join(str(ast.literal_eval(below.value)).split())
    return docs


def _plain(value: Any) -> Any:
    return list(value) if isinstance(value, tuple) else value
