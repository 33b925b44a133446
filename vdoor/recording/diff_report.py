"""Results of a comparison as text, JSON and JUnit XML."""

from __future__ import annotations

import dataclasses
import json
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from xml.etree import ElementTree as ET

from vdoor.errors import printable
from vdoor.recording.compare import Difference, Value, Worst
from vdoor.recording.diff import Mismatch, Report, Setting, Stage

Names = tuple[str, str]
"""Names of the two runs in the text."""
RECORDED: Names = ("recorded", "now")
EXIT_CODES = {"equal": 0, "differs": 1, "unreadable": 2}


@dataclass(frozen=True, kw_only=True)
class Result:
    """Result of verifying one file."""

    path: Path
    report: Report | None = None
    error: str = ""
    """Why it could not be read or run again."""
    changes: tuple[str, ...] | None = None
    """What changed in the final map, a line each, if only that counts; None if all records do."""

    @property
    def equal(self) -> bool:
        """Whether all that counts is equal."""
        if self.report is None or self.changes is None:
            return self.report is not None and self.report.equal
        return not (self.changes or self.report.stopped)

    @property
    def lines(self) -> list[str]:
        """What differs, a line each."""
        if self.report is None:
            return []
        return [*self.changes, *stopped(self.report)] if self.changes is not None else [*lines(self.report, RECORDED)]

    @property
    def verdict(self) -> str:
        """One of equal, differs and unreadable."""
        if self.report is None:
            return "unreadable"
        return "equal" if self.equal else "differs"

    @property
    def table(self) -> dict[str, Any]:
        """Fields for JSON."""
        return {"path": self.path, "verdict": self.verdict, "error": self.error, "comparison": self.report} | (
            {} if self.changes is None else {"changes": self.changes}
        )


def exit_code(results: Sequence[Result]) -> int:
    """0 if all are equal, 1 if one differs, 2 if one could not be read."""
    return max((EXIT_CODES[result.verdict] for result in results), default=0)


def table(results: Sequence[Result]) -> Iterator[str]:
    """One line per file, then the differences, file by file."""
    width = max((len(str(result.path)) for result in results), default=0)
    for result in results:
        yield printable(f"{result.verdict:10s}  {result.path!s:{width}s}  {_summary(result)}".rstrip())
    for result in results:
        if result.verdict == "differs":
            yield ""
            yield printable(f"{result.path}:")
            yield from (f"  {line}" for line in result.lines)


def _summary(result: Result) -> str:
    if result.report is None:
        return result.error
    if result.changes is not None:
        return result.report.stopped or f"{len(result.changes)} changes of the map"
    first = result.report.first
    if first is not None:
        return f"from {first.topic} on"
    return result.report.stopped or f"{sum(stage.expected for stage in result.report.stages)} records"


def lines(report: Report, names: Names) -> Iterator[str]:
    """Full differences of the first stage that differs, and counts for later ones; nothing if all is equal."""
    first = report.first
    for stage in report.stages:
        if stage is first:
            yield f"{stage.topic} differs first: {_counts(stage, names)}"
            yield from (f"  {line}" for line in _mismatch(stage, names))
        elif not stage.equal:
            yield f"{stage.topic} differs too: {_counts(stage, names)}"
    yield from stopped(report, names)


def stopped(report: Report, names: Names = RECORDED) -> Iterator[str]:
    """Why the second run stopped early; nothing if it did not."""
    if report.stopped:
        yield printable(f"{names[1]} the run stopped: {report.stopped}")


def _counts(stage: Stage, names: Names) -> str:
    elements = f"{stage.elements} element{'s' * (stage.elements != 1)}"
    if stage.expected == stage.found == 1:
        return elements
    if stage.expected == stage.found:
        return f"{stage.differing} of {stage.expected} records, {elements}"
    return f"{names[0]} {stage.expected}, {names[1]} {stage.found} records; {stage.differing} differ, {elements}"


def _mismatch(stage: Stage, names: Names) -> Iterator[str]:
    assert isinstance(stage.first, Mismatch)
    if max(stage.expected, stage.found) > 1:
        yield f"in record {stage.first.rank} of this stage:"
    if not stage.first.differences:
        yield f"only {names[0] if stage.expected > stage.found else names[1]}"
    for difference in stage.first.differences:
        yield printable(describe(difference, names))


def describe(difference: Difference, names: Names) -> str:
    """One line about a field: number of elements that differ, the worst one, its position, both values."""
    worst = difference.worst
    where = ", ".join(map(str, worst.index))
    place = f" ({_place(worst)})" if worst.cell is not None else ""
    at = f", {'worst' if worst.difference is not None else 'first'} at {where}{place}" if worst.index else ""
    if worst.unit == "rows":
        many, at = f"count differs by {difference.count}", f", first difference at {where}{place}"
    else:
        many = f"{difference.count} of {difference.total} differ" if difference.total > 1 else "differs"
    apart = "" if worst.difference is None else f", {worst.difference:.6g} {worst.unit}".rstrip() + " apart"
    values = f"{names[0]} {_shown(worst.expected)}, {names[1]} {_shown(worst.found)}"
    return f"{difference.field}: {many}{at}: {values}{apart}"


def _place(worst: Worst) -> str:
    assert worst.cell is not None
    cell = ",".join(f"{value:g}" for value in worst.cell)
    point = ",".join(f"{value:.3f}" for value in worst.place_m or ())
    return f"cell {cell}; {point} m"


def _shown(value: Value) -> str:
    return "(" + ", ".join(map(str, value)) + ")" if isinstance(value, tuple) else str(value)


def setting_line(setting: Setting, names: Names) -> str:
    """One line about a setting that differs."""
    values = (setting.expected, setting.found)
    one, other = ("not set" if value is None else json.dumps(value, ensure_ascii=False) for value in values)
    return printable(f"{setting.name}: {names[0]} {one}, {names[1]} {other}")


def to_json(value: Any) -> str:
    """Dataclasses, paths and numbers as JSON; infinities and nans, which JSON does not have, as text."""
    return json.dumps(_plain(value), indent=1)


def _plain(value: Any) -> Any:
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        return {field.name: _plain(getattr(value, field.name)) for field in dataclasses.fields(value)}
    if isinstance(value, dict):
        return {name: _plain(part) for name, part in value.items()}
    if isinstance(value, (list, tuple)):
        return [_plain(part) for part in value]
    if isinstance(value, float) and not math.isfinite(value):
        return str(value)
    return str(value) if isinstance(value, Path) else value


def junit(results: Sequence[Result]) -> bytes:
    """JUnit XML: one test per file, with a failure if it differs and an error if it could not be read."""
    verdicts = [result.verdict for result in results]
    counts = {"tests": len(results), "failures": verdicts.count("differs"), "errors": verdicts.count("unreadable")}
    suite = ET.Element("testsuite", {"name": "vdoor verify"} | {name: str(count) for name, count in counts.items()})
    for result in results:
        case = ET.SubElement(suite, "testcase", classname="vdoor.verify", name=printable(str(result.path)))
        if result.report is None:
            ET.SubElement(case, "error", message=printable(result.error))
        elif not result.equal:
            failure = ET.SubElement(case, "failure", message=printable(_summary(result)))
            failure.text = "\n".join(result.lines)
    root = ET.Element("testsuites")
    root.append(suite)
    ET.indent(root)
    return bytes(ET.tostring(root, encoding="utf-8", xml_declaration=True)) + b"\n"
