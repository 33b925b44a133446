"""The architecture as a test: imports go one way, by the tables in ARCHITECTURE.md."""

from __future__ import annotations

import ast
import functools
import re
import subprocess
import sys
from pathlib import Path

import networkx as nx
from project import HOME

PACKAGE = HOME / "vdoor"
MODULES = {
    ".".join(path.relative_to(HOME).with_suffix("").parts).removesuffix(".__init__") for path in PACKAGE.rglob("*.py")
}


def table(heading: str) -> dict[str, list[str]]:
    """The table of ARCHITECTURE.md whose first column has that heading: first column, and the words of the last."""
    text = (HOME / "ARCHITECTURE.md").read_text()
    lines = text[text.index(f"| {heading} |") :].partition("\n\n")[0].splitlines()[2:]
    rows = [[cell.strip() for cell in re.split(r"(?<!\\)\|", line)[1:-1]] for line in lines]
    return {row[0]: row[-1].split() for row in rows}


@functools.cache
def imported(path: Path) -> frozenset[str]:
    """Modules that a file imports, in functions and for type checking as well; ours by their own names."""
    found: set[str] = set()
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module:
            names = {f"{node.module}.{alias.name}" for alias in node.names}
            found |= {name if name in MODULES else node.module for name in names}
    return frozenset(found)


def part_of(path: Path) -> str:
    return path.relative_to(PACKAGE).parts[0].removesuffix(".py")


def test_parts_import_only_what_the_table_allows() -> None:
    may_import = table("part")
    assert set(may_import) == {part_of(path) for path in PACKAGE.rglob("*.py")} - {"__init__", "__main__"}
    wrong = []
    for path in PACKAGE.rglob("*.py"):
        part = part_of(path)
        if part in ("__init__", "__main__", "cli"):
            continue
        ours = {name.split(".")[1] for name in imported(path) if name.startswith("vdoor.")}
        wrong += [f"{path.relative_to(PACKAGE)} imports {name}" for name in ours - {part, *may_import[part]}]
    assert not wrong


def test_the_table_goes_one_way_and_allows_no_more_than_is_used() -> None:
    allowed = {part: set(parts) for part, parts in table("part").items() if part != "cli"}
    graph = nx.DiGraph([(part, other) for part, others in allowed.items() for other in others])
    assert nx.is_directed_acyclic_graph(graph)
    used: dict[str, set[str]] = {part: set() for part in allowed}
    for path in PACKAGE.rglob("*.py"):
        if (part := part_of(path)) in used:
            used[part] |= {name.split(".")[1] for name in imported(path) if name.startswith("vdoor.")} - {part}
    assert used == allowed


def test_no_module_imports_itself_by_a_circle() -> None:
    graph: nx.DiGraph[str] = nx.DiGraph()
    for path in PACKAGE.rglob("*.py"):
        own = ".".join(path.relative_to(HOME).with_suffix("").parts).removesuffix(".__init__")
        if own == "vdoor":
            continue  # its front page loads a name when it is asked for, so that any part may read the version from it
        graph.add_edges_from((own, name) for name in imported(path) if name in MODULES and name != own)
    assert [sorted(group) for group in nx.strongly_connected_components(graph) if len(group) > 1] == []


def test_outside_libraries_stay_in_their_place() -> None:
    for library, places in table("library").items():
        users = {
            path.relative_to(PACKAGE).as_posix()
            for path in PACKAGE.rglob("*.py")
            if any(name.split(".")[0] == library for name in imported(path))
        }
        assert users, library
        assert all(user.startswith(tuple(places)) for user in users), (library, users)


def test_help_loads_nothing_heavy() -> None:
    script = "import sys; sys.argv[1:] = ['--help']\nimport vdoor.cli\ntry: vdoor.cli.main()\nexcept SystemExit: pass\n"
    script += "print([name for name in ('numpy', 'scipy', 'rerun', 'mcap', 'networkx', 'PIL') if name in sys.modules])"
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    assert done.stdout.splitlines()[-1] == "[]"


DOORS = ("__init__.py", "__main__.py")


def test_files_are_neither_scraps_nor_scrolls() -> None:
    lengths = {path: len(path.read_text().splitlines()) for path in PACKAGE.rglob("*.py")}
    assert {path.name: length for path, length in lengths.items() if length > 400} == {}
    assert {path.name: length for path, length in lengths.items() if length < 25 and path.name not in DOORS} == {}
