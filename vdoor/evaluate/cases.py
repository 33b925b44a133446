"""Pairing results with references, by name if there are several."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path

from vdoor.errors import VdoorError
from vdoor.evaluate.division import is_result
from vdoor.evaluate.label_files import LABEL_SUFFIXES, read_table
from vdoor.evaluate.reference import ENDINGS, bare_name
from vdoor.formats.valetudo_json import is_valetudo

REFERENCE_SUFFIXES = (*LABEL_SUFFIXES, ".json")
OF_BATCH = "results/*/*/rooms.png"
"""The results in the folder of `vdoor batch`."""
References = dict[str, tuple[Path, str | None]]
"""Map name -> the file of its reference, and the map's key within the file if that holds several maps."""


@dataclass(frozen=True, kw_only=True)
class Case:
    """A result and the reference it is measured against."""

    name: str
    result: Path
    reference: Path
    key: str | None = None
    """The map's key in a reference that holds several maps."""


@dataclass(frozen=True, kw_only=True)
class Cases:
    """All pairs, and the names of results and references left without a partner."""

    cases: list[Case]
    without_reference: list[str] = field(default_factory=list)
    without_result: list[str] = field(default_factory=list)


def matched(result: Path, reference: Path) -> Cases:
    """Results paired with the references of the same name; a single result and reference are always a pair.

    A result without a reference of its own name gets the one with the longest name that, followed by an underscore,
    begins the result's: the reference `lab` also serves `lab_furnished`. Raises `VdoorError` if nothing matches.
    """
    results, references = _results(result), references_in(reference)
    if results == [result] and [*references.values()] == [(reference, None)]:
        return Cases(cases=[Case(name=_names(result)[0], result=result, reference=reference)])
    cases, without = [], []
    for path in results:
        found = next((known for name in _names(path) if (known := serving(name, references))), None)
        if found is None:
            without.append(_names(path)[0])
            continue
        file, key = references[found]
        cases.append(Case(name=_names(path)[0], result=path, reference=file, key=key))
    if not cases:
        wanted = ", ".join(without[:5])
        raise VdoorError(f"reference: wanted one for {wanted}, found {', '.join([*references][:5])}: {reference}")
    used = {(case.reference, case.key) for case in cases}
    unused = [name for name, place in references.items() if place not in used]
    return Cases(cases=cases, without_reference=without, without_result=unused)


def serving(name: str, references: References) -> str | None:
    """The name of the reference for a result of that name; None if there is none."""
    fitting = [known for known in references if name == known or name.startswith(f"{known}_")]
    return max(fitting, key=len, default=None)


def _results(path: Path) -> list[Path]:
    """The result itself, or the results and label images in a folder or batch, sorted by name."""
    if not path.is_dir() or is_result(path):
        return [path]
    found = sorted(entry for entry in path.iterdir() if is_result(entry) or entry.suffix.lower() in LABEL_SUFFIXES)
    found = found or sorted(entry.parent for entry in path.glob(OF_BATCH))
    if not found:
        raise VdoorError(f"result: wanted rooms.png, or results or label images in the folder, found none: {path}")
    return found


def _names(result: Path) -> list[str]:
    """The names of a result: its own, then that of the map it was made from."""
    if not is_result(result):
        return [result.stem]
    own = result.resolve().name
    try:
        return [own, Path(read_table(result / "map.json")["source"]["files"][0]["name"]).stem]
    except (KeyError, IndexError, TypeError):
        return [own]


def references_in(path: Path) -> References:
    """The references in a file or folder, by map name; raises `VdoorError` if there are none."""
    if path.is_dir() and not is_result(path):
        return {bare_name(entry): (entry, None) for entry in _reference_files(path)}
    if path.suffix.lower() != ".json":
        return {bare_name(path): (path, None)}
    table = read_table(path)
    if "schema" in table or "doors" in table or is_valetudo(table):
        return {bare_name(path): (path, None)}
    several = {name: (path, name) for name, entry in table.items() if isinstance(entry, dict) and "doors" in entry}
    if not several:
        raise VdoorError(f"reference: wanted doors, or maps with doors, found none: {path}")
    return dict(several)


def _reference_files(folder: Path) -> list[Path]:
    """Files named like a reference or, if none is, all of a suitable type; no PNG that has a JSON file of its name."""
    could = [e for e in sorted(folder.iterdir()) if is_result(e) or e.suffix.lower() in REFERENCE_SUFFIXES]
    named = [entry for entry in could if entry.stem.endswith(ENDINGS)] or could
    files = [entry for entry in named if not (entry.suffix == ".png" and entry.with_suffix(".json") in named)]
    if not files:
        raise VdoorError(f"reference: wanted label images or JSON in the folder, found none: {folder}")
    return files
