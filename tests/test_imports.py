"""The architecture as a test: imports go one way, and heavy ones stay where they belong."""

from __future__ import annotations

import ast
import subprocess
import sys
from pathlib import Path

HOME = Path(__file__).parent.parent / "vdoor"

LEAVES = {"errors", "say", "files", "places", "edits", "config", "record", "grid", "emit", "hold"}
MAY_IMPORT = {
    "errors": set(),
    "say": set(),
    "hold": set(),
    "files": {"errors"},
    "places": {"errors"},
    "edits": {"errors", "files", "places", "record"},
    "config": {"errors"},
    "record": {"errors"},
    "grid": {"record"},
    "emit": {"grid", "record", "hold"},
    "topology": {"errors", "record", "stages"},
    "stages": {"errors", "config", "edits", "places", "record", "grid", "topology"},
    "pipeline": {"baselines", "config", "errors", "emit", "record", "grid", "prepare", "stages", "topology"},
    "prepare": {"errors", "formats", "grid", "stages", "topology"},
    "formats": {"errors", "files", "record", "grid", "emit", "topology", "recording"},
    "recording": {"errors", "files", "record", "grid", "emit", "hold"},
    "viz": {
        "baselines",
        "say",
        "edits",
        "places",
        "history",
        "why",
        "evaluate",
        "formats",
        "config",
        "errors",
        "files",
        "record",
        "grid",
        "emit",
        "stages",
        "topology",
        "trials",
        "recording",
    },
    "export": {
        "emit",
        "errors",
        "evaluate",
        "files",
        "formats",
        "grid",
        "history",
        "pipeline",
        "prepare",
        "record",
        "recording",
        "stages",
        "topology",
        "viz",
    },
    "synth": {"errors", "files", "record", "grid"},
    "history": {
        "baselines",
        "errors",
        "config",
        "record",
        "grid",
        "emit",
        "pipeline",
        "stages",
        "topology",
        "recording",
    },
    "why": {"errors", "history", "record", "grid", "pipeline", "stages", "topology", "recording"},
    "evaluate": {"errors", "formats", "grid", "record"},
    "goldens": {
        "errors",
        "files",
        "grid",
        "emit",
        "config",
        "pipeline",
        "recording",
        "stages",
        "synth",
        "formats",
        "record",
    },
    "matching": {"config", "edits", "errors", "grid", "pipeline", "places", "record", "stages", "topology"},
    "outputs": {"errors", "say", "files", "record", "emit", "recording", "viz"},
    "baselines": {"config", "emit", "grid", "record", "stages", "topology"},
    "evidence": {
        "baselines",
        "config",
        "emit",
        "evaluate",
        "files",
        "grid",
        "outputs",
        "pipeline",
        "record",
        "stages",
        "study",
        "synth",
        "topology",
        "viz",
    },
    "train": {"errors", "files", "grid", "pipeline", "record", "stages", "synth", "trials"},
    "trials": {
        "config",
        "emit",
        "errors",
        "evaluate",
        "formats",
        "grid",
        "pipeline",
        "record",
        "stages",
        "synth",
        "topology",
    },
    "study": {"pipeline", "stages", "synth"},
    "benchmark": {"emit", "grid", "outputs", "pipeline", "stages", "synth"},
}
ONLY_IN = {
    "matplotlib": ("viz",),
    "rerun": ("viz",),
    "mcap": ("recording/mcap.py",),
    "rosbags": ("recording/ros.py", "formats/bag"),
    "typer": ("cli",),
}


def imports(path: Path) -> set[str]:
    """Modules a file imports, in functions and for type checking as well."""
    found: set[str] = set()
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module:
            found |= {f"{node.module}.{alias.name}" for alias in node.names} | {node.module}
    return found


def test_imports_go_one_way() -> None:
    wrong = []
    for path in HOME.rglob("*.py"):
        part = path.relative_to(HOME).parts[0].removesuffix(".py")
        if part in ("__init__", "cli"):
            continue
        ours = {name.split(".")[1] for name in imports(path) if name.startswith("vdoor.")} - {"__version__"}
        wrong += [f"{path.relative_to(HOME)} imports {name}" for name in ours - MAY_IMPORT[part] - {part}]
    assert not wrong


def test_outside_libraries_stay_in_their_place() -> None:
    for library, places in ONLY_IN.items():
        users = {
            path.relative_to(HOME).as_posix()
            for path in HOME.rglob("*.py")
            if any(name.split(".")[0] == library for name in imports(path))
        }
        assert users, library
        assert all(user.startswith(places) for user in users), (library, users)


def test_help_loads_nothing_heavy() -> None:
    script = "import sys; sys.argv[1:] = ['--help']\nimport vdoor.cli\ntry: vdoor.cli.main()\nexcept SystemExit: pass\n"
    script += "print([name for name in ('numpy', 'scipy', 'rerun', 'mcap', 'networkx', 'PIL') if name in sys.modules])"
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    assert done.stdout.splitlines()[-1] == "[]"
