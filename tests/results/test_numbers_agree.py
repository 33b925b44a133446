"""Numbers of a result wherever they are printed or written: the same, and as exact as they are worth."""

from __future__ import annotations

import json
import re
from pathlib import Path

import commands
import finished_maps
import networkx as nx
import numpy as np
import pytest
import report_pages

from vdoor.export import WRITERS
from vdoor.grid import OCCUPIED

TEXTS = [writer.name for writer in WRITERS if not writer.image]
CELLS = {1: 4096 - 2, 2: 4096 - 5, 3: 4096 - 1}
"""Free cells of each room without its doorways, of 0.0025 m2."""
LONG = re.compile(r"\d\.\d{7,}")
"""A number with more decimals than any is written with."""


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a result and a recording of the same run, what was printed, and every export of both."""
    place = tmp_path_factory.mktemp("run")
    cells = finished_maps.house(3, (1, 6, 4), (2, 10, 4)).repeat(4, axis=0).repeat(4, axis=1)
    for room, cells_less in enumerate((2, 5, 1)):
        cells[12, 20 + 72 * room : 20 + 72 * room + cells_less] = OCCUPIED
    np.save(place / "house.npy", cells)
    words = ("--resolution", "0.05", "--out", place / "res", "--mcap", place / "res.mcap", "--quiet")
    (place / "run.txt").write_text(commands.call("run", place / "house.npy", *words).out)
    for result in ("res", "res.mcap"):
        for name in TEXTS:
            (place / f"{result}-{name}").write_text(commands.call("export", place / result, "--to", name).out)
    return place


def written_m2(run: Path) -> dict[str, dict[int, float]]:
    """The area of each room, by where it is written."""
    read = {name: (run / f"res-{name}").read_text() for name in TEXTS}
    route = [item["properties"].get("metadata", {}) for item in json.loads(read["nav2-route"])["features"]]
    shapes = [item["properties"] for item in json.loads(read["geojson"])["features"]]
    tables = {
        "map.json": json.loads((run / "res" / "map.json").read_text())["rooms"],
        "rooms --json": commands.call("rooms", run / "res.mcap", "--json").json["rooms"],
        "json": json.loads(read["json"])["nodes"],
        "report": report_pages.told(read["report"])["rooms"],
        "geojson": [{**row, "id": row["room"]} for row in shapes if row["type"] == "room"],
        "nav2-route": [{**row, "id": row["room"]} for row in route if "area_m2" in row],
    }
    graph = nx.read_graphml(run / "res-graphml", node_type=int, force_multigraph=True)
    return {name: {row["id"]: row["area_m2"] for row in rows} for name, rows in tables.items()} | {
        "graphml": dict(graph.nodes(data="area_m2"))
    }


def printed_m2(run: Path) -> dict[str, dict[int, str]]:
    """The area of each room, by which command prints it."""
    texts = {
        "run": (r"^room +(\d+) +([\d.]+) m2", (run / "run.txt").read_text()),
        "rooms": (r"^(\d+) +([\d.]+) ", commands.call("rooms", run / "res").out),
        "show": (r"^(\d+) +([\d.]+) +[\d.]+,", commands.call("show", run / "res.mcap", "--stage", "map").out),
    }
    return {
        name: {int(room): area for room, area in re.findall(pattern, text, re.MULTILINE)}
        for name, (pattern, text) in texts.items()
    }


def test_areas_agree_wherever_they_are_written(run: Path) -> None:
    written = written_m2(run)
    areas_m2 = written["map.json"]
    doorways = sum(round(area / 0.0025) for area in areas_m2.values()) - sum(CELLS.values())
    assert doorways == 2 * 16 * 8
    assert all(abs(area * 400 - round(area * 400)) < 1e-9 for area in areas_m2.values())
    assert written == dict.fromkeys(written, areas_m2)
    in_words = {room: f"{area:.2f}" for room, area in areas_m2.items()}
    for name, found_in_words in printed_m2(run).items():
        assert found_in_words == in_words, name


def test_the_sum_of_areas_agrees_wherever_it_is_printed(run: Path) -> None:
    total = f"{sum(written_m2(run)['map.json'].values()):.1f}"
    commands.call("batch", run / "house.npy", "--resolution", "0.05", "--out", run / "batch")
    page = report_pages.told((run / "res-report").read_text())
    assert (run / "run.txt").read_text().splitlines()[0] == f"3 rooms, 2 doors, {total} m2"
    assert f"3 rooms, 2 doors, {total} m2" in commands.call("show", run / "res.mcap", "--stage", "map").out
    assert f"{total} m²" in json.dumps(page, ensure_ascii=False)
    assert f",{float(total):.1f}" in (run / "batch" / "index.csv").read_text()


def test_a_folder_and_a_recording_of_one_run_give_the_same_exports_and_no_long_numbers(run: Path) -> None:
    for name in TEXTS:
        text = (run / f"res-{name}").read_text()
        assert not LONG.findall(text), name
        if name != "report":  # that of a recording shows its stages as well
            assert text == (run / f"res.mcap-{name}").read_text(), name
    assert not LONG.findall((run / "res" / "map.json").read_text())


def test_what_commands_print_as_json_has_no_long_numbers(run: Path) -> None:
    for words in (("route", "1", "3"), ("order",), ("cover", "--room", "1"), ("room-at", "1,1")):
        assert not LONG.findall(commands.call(words[0], run / "res", *words[1:], "--json").out), words
    assert not LONG.findall(commands.call("why", run / "res.mcap", "--door", "1", "--json").out)
