"""Pages that are made from the code: settings, the command line, what a recording holds, the Python API."""

# ruff: noqa: INP001  # part of the site, not of a package
from __future__ import annotations

import dataclasses
import importlib
import inspect
import json
import re
from collections.abc import Iterator, Mapping
from typing import Any

import typer

import vdoor.cli
from vdoor.config import METHOD, Within, field_docs, ranges_of
from vdoor.explain.stages import STAGE_VIEWS
from vdoor.pipeline import METHODS, PRESETS, RECORDS
from vdoor.record import Record, Spec, specs
from vdoor.recording.codec import PREFIX, parts

MAIN = ("default", "paper")
"""The presets whose settings stand side by side."""
MANY = 1000
"""Numbers from this on are written with commas."""


def settings() -> str:
    """Every stage of every preset with its settings: what the presets set them to, their range and meaning."""
    return "\n\n".join(part for stage in _stages() for part in _stage(stage))


def _stages() -> list[str]:
    """Names of all stages that any preset has, the method's own first."""
    ordered = [*MAIN, *PRESETS]
    return list(dict.fromkeys(field.name for name in ordered for field in dataclasses.fields(PRESETS[name])))


def _stage(stage: str) -> Iterator[str]:
    """One stage: for each way of doing it what it does, and a table of its settings."""
    users = {name: getattr(preset, stage) for name, preset in PRESETS.items() if hasattr(preset, stage)}
    ways: Mapping[str, type] = METHODS.get(stage, {"": type(next(iter(users.values())))})
    yield f"## `{stage}`"
    if len(ways) > 1:
        chosen = {name: _way(ways, type(one)) for name, one in users.items() if type(one) in ways.values()}
        said = ", ".join(f"`{way}` in preset `{name}`" for name, way in chosen.items())
        yield f"Ways of doing it, chosen by `{stage}.{METHOD}`: {', '.join(f'`{way}`' for way in ways)}. It is {said}."
    elif len(users) < len(PRESETS):
        yield f"Only in preset {' and '.join(f'`{name}`' for name in users)}."
    for way, kind in ways.items():
        if way:
            yield f"### `{stage}.{METHOD} = {json.dumps(way)}`"
        yield _first_line(kind)
        table = _table(kind, {name: one for name, one in users.items() if type(one) is kind})
        if table:
            yield table


def _way(ways: Mapping[str, type], kind: type) -> str:
    return next(way for way, one in ways.items() if one is kind)


def _table(kind: type, users: Mapping[str, Any]) -> str:
    """Settings of one class, with the values of the presets that use it; of the class itself where none does."""
    fields = dataclasses.fields(kind)
    if not fields:
        return ""
    meaning, ranges = field_docs(kind), ranges_of(kind)
    columns: Mapping[str, Any] = {name: users[name] for name in MAIN if name in users}
    columns = columns or dict(list(users.items())[:1]) or {"value": kind()}
    heads = [name if name == "value" else f"`{name}`" for name in columns]
    lines = [f"| setting | {' | '.join(heads)} | range | meaning |", "|---|" + "---|" * (len(heads) + 2)]
    for field in fields:
        values = [getattr(one, field.name) for one in columns.values()]
        shown = " | ".join(f"`{_shown(value)}`" for value in values)
        span = _span(ranges.get(field.name), values[0])
        lines.append(f"| `{field.name}` | {shown} | {span} | {_cell(meaning.get(field.name, ''))} |")
    return "\n".join(lines)


def _shown(value: Any) -> str:
    return json.dumps(list(value) if isinstance(value, tuple) else value, ensure_ascii=False)


def _span(within: Within | None, value: Any) -> str:
    """What a setting may be: its range, or else what it is."""
    if within:
        return f"{within.low:,g} to {within.high:,.0f}" if within.high >= MANY else f"{within.low:g} to {within.high:g}"
    return {bool: "`true` or `false`", str: "text", tuple: "a list"}.get(type(value), "")


def _first_line(kind: type) -> str:
    return (inspect.getdoc(kind) or "").splitlines()[0]


def _cell(text: str) -> str:
    """Text that may stand in a table."""
    return text.replace("|", "\\|").replace("\n", " ")


def commands() -> str:
    """Every command with its arguments and options, as `--help` has them."""
    group: Any = typer.main.get_command(vdoor.cli.app)
    return "\n\n".join(part for name in group.commands for part in _command(name, group.commands[name]))


def _command(name: str, command: Any) -> Iterator[str]:
    context = command.context_class(command, info_name=f"vdoor {name}")
    yield f"## `vdoor {name}`"
    yield _paragraphs(command.help)
    usage = " ".join(command.collect_usage_pieces(context)).replace("{", "").replace("}", "")
    yield f"```text\nvdoor {name} {usage}\n```"
    records = [(parameter, parameter.get_help_record(context)) for parameter in command.get_params(context)]
    rows = [_row(*record) for parameter, record in records if record and parameter.name != "help"]
    if rows:
        yield "\n".join(["| argument or option | meaning |", "|---|---|", *rows])
    if command.epilog:
        yield f"```text\n{command.epilog.removeprefix('Example: ').replace('; ', chr(10))}\n```"


def _row(names: str, meaning: str) -> str:
    names = re.sub(r" <[^>]*>", "", names)  # Python's type
    return f"| `{_cell(names)}` | {_cell(meaning).strip()} |"


def _paragraphs(text: str) -> str:
    """Help as Markdown: what help leaves as it is becomes a block."""
    shown = []
    for part in text.split("\n\n"):
        kept = part.startswith("\b")
        shown.append(f"```text\n{part.lstrip(chr(8)).strip(chr(10))}\n```" if kept else part)
    return "\n\n".join(shown)


def records() -> str:
    """Every record that runs emit: its topics and its fields."""
    return "\n\n".join(part for record in RECORDS for part in _record(record))


def _record(record: type[Record]) -> Iterator[str]:
    yield f"## {record.__name__}"
    yield _first_line(record)
    topics = [f"| `{PREFIX}/{record.topic}/{name}` | {part.message} |" for name, part in parts(record).items()]
    yield "\n".join(["| topic | type |", "|---|---|", *topics])
    meaning = field_docs(record)
    rows = [
        f"| `{name}` | {_kind(spec, dtype)} | {spec.unit} | {_cell(_meaning(spec, meaning.get(name, '')))} |"
        for name, (spec, dtype) in specs(record).items()
    ]
    yield "\n".join(["| field | holds | unit | meaning |", "|---|---|---|---|", *rows])
    words = {word: said for view in STAGE_VIEWS if view.record is record for word, said in view.words.items()}
    if words:
        yield "\n".join(
            ["| word | means |", "|---|---|", *(f"| {word} | {_cell(said)} |" for word, said in words.items())]
        )


def _kind(spec: Spec, dtype: Any) -> str:
    shape = f" ({', '.join(spec.axes)})" if spec.axes else ""
    return f"{spec.kind}{f', {dtype}' if dtype is not None else ''}{shape}"


def _meaning(spec: Spec, text: str) -> str:
    words = f"One of: {', '.join(spec.words)}." if spec.words else ""
    rows = f"Rows of `{spec.of}`{', -1 for none' if spec.or_none else ''}." if spec.of else ""
    return " ".join(filter(None, (text, words, rows)))


def api(module: str) -> str:
    """A place for the documentation of every public name of a module, functions first."""
    home = importlib.import_module(module)
    names = sorted(home.__all__, key=lambda name: (inspect.isclass(getattr(home, name)), name.lower()))
    return "\n\n".join(f"::: {module}.{name}" for name in names)
