"""The server of the page: who may ask it, and what it answers."""

from __future__ import annotations

import http.client
import json
import os
import signal
import subprocess
import threading
import urllib.request
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import finished_maps
import pytest
from commands import Command
from project import VDOOR

from vdoor.editpage.server import MOST_BYTES, Server
from vdoor.editpage.session import Session


@pytest.fixture
def server(tmp_path: Path) -> Iterator[Server]:
    with Server(Session(finished_maps.result("one room", tmp_path / "r"))) as made:
        threading.Thread(target=made.serve_forever, daemon=True).start()
        yield made
        made.shutdown()


def ask(server: Server, method: str, name: str = "", body: Any = None, **headers: str) -> tuple[int, Any]:
    """The status and the content of an answer; TOKEN in a header or path stands for the token, PORT for the port."""
    connection = http.client.HTTPConnection("127.0.0.1", server.port, timeout=30)
    path = name if name.startswith("/") else f"/{server.token}/{name}"
    sent = {key.replace("_", "-"): value.replace("PORT", str(server.port)) for key, value in headers.items()}
    data = body if isinstance(body, str | None) else json.dumps(body)
    connection.request(method, path, data, {"Content-Type": "application/json"} | sent)
    answer = connection.getresponse()
    content = answer.read()
    is_json = answer.getheader("Content-Type") == "application/json"
    return answer.status, json.loads(content) if is_json else content.decode()


def renaming(server: Server) -> dict[str, Any]:
    return {"words": ["rename", "1", "Kitchen"], "seen": server.session.state()["edit"]["version"]}


def test_page_knows_its_result_and_needs_nothing_else(server: Server) -> None:
    status, page = ask(server, "GET")
    assert status == 200
    assert '"edit":{"version":' in page
    assert "connect-src 'self'" in page
    assert server.server_address[0] == "127.0.0.1"
    with urllib.request.urlopen(server.url) as answer:  # noqa: S310  # our own
        assert answer.headers["Content-Security-Policy"] == "frame-ancestors 'none'"
        assert answer.headers["Referrer-Policy"] == "no-referrer"
        assert answer.headers["Cache-Control"] == "no-store"


@pytest.mark.parametrize(
    ("path", "headers"),
    [
        ("/", {}),
        ("/do", {}),
        ("/wrong/do", {}),
        ("//do", {}),
        ("/%C3%A9/do", {}),
        ("do", {"Origin": "http://example.org"}),
        ("do", {"Origin": "null"}),
        ("do", {"Origin": "http://127.0.0.1"}),
        ("do", {"Origin": "https://127.0.0.1:PORT"}),
        ("do", {"Host": "example.org:PORT"}),
        ("do", {"Host": "127.0.0.1.example.org:PORT"}),
        ("do", {"Host": "example.org:PORT", "Origin": "http://example.org:PORT"}),
    ],
)
def test_strangers_get_403_and_change_nothing(path: str, headers: dict[str, str], server: Server) -> None:
    body = renaming(server)
    for method in ("GET", "POST"):
        status, told = ask(server, method, path, body, **headers)
        assert (status, set(told)) == (403, {"sentence"})
    assert not (server.session.result / "edits.toml").exists()


@pytest.mark.parametrize("origin", ["http://127.0.0.1:PORT", None])
def test_own_page_and_own_programs_may_edit(origin: str | None, server: Server) -> None:
    status, told = ask(server, "POST", "do", renaming(server), **({"Origin": origin} if origin else {}))
    assert (status, told["said"]) == (200, "room 1 is now named Kitchen")
    assert 'name = "Kitchen"' in (server.session.result / "edits.toml").read_text()
    status, told = ask(server, "POST", "undo", {"seen": told["edit"]["version"]})
    assert (status, told["said"]) == (200, "Undone: room 1 is now named Kitchen")
    assert not (server.session.result / "edits.toml").exists()
    assert ask(server, "POST", "redo", {"seen": told["edit"]["version"]})[1]["rooms"][0]["name"] == "Kitchen"
    assert ask(server, "GET", "state")[1]["edit"]["count"] == 1


@pytest.mark.parametrize(
    ("request_line", "body", "kind", "status"),
    [
        ("GET do", None, "", 404),
        ("GET ../../etc/passwd", None, "", 404),
        ("POST state", {"seen": ""}, "", 404),
        ("PUT do", {"seen": ""}, "", 501),
        ("POST do", {"seen": ""}, "text/plain", 415),
        ("POST do", " " * (MOST_BYTES + 1), "", 413),
        ("POST do", "{", "", 400),
        ("POST do", "[]", "", 400),
        ("POST do", {"words": ["rename", "1", "A"]}, "", 400),
        ("POST do", {"words": "rename", "seen": ""}, "", 400),
        ("POST do", {"words": ["rename", 1], "seen": ""}, "", 400),
        ("POST do", {"words": [], "seen": ""}, "", 400),
    ],
)
def test_other_requests_are_refused(request_line: str, body: Any, kind: str, status: int, server: Server) -> None:
    method, name = request_line.split()
    assert ask(server, method, name, body, **({"Content_Type": kind} if kind else {}))[0] == status
    assert not (server.session.result / "edits.toml").exists()


def test_what_cannot_be_done_is_said_with_what_is_there(server: Server) -> None:
    seen = renaming(server)["seen"]
    status, told = ask(server, "POST", "do", {"words": ["merge", "1", "7"], "seen": seen})
    assert (status, told) == (200, {"sentence": "room: wanted one of 1, found 7"})
    status, told = ask(server, "POST", "do", renaming(server) | {"seen": "another"})
    assert (status, told["sentence"], len(told["rooms"])) == (
        200,
        "The result has changed since; this is how it is now.",
        1,
    )
    assert ask(server, "POST", "undo", {"seen": seen})[1] == {"sentence": "there is nothing to undo"}


def test_a_result_that_is_gone_is_said(server: Server) -> None:
    (server.session.result / "map.json").write_text("{")
    status, told = ask(server, "GET", "state")
    assert (status, set(told)) == (500, {"sentence"})


def test_command_says_what_it_cannot_serve(tmp_path: Path, server: Server, command: Command) -> None:
    (tmp_path / "r.mcap").write_bytes(b"")
    for words, says in (
        ((tmp_path / "r.mcap",), "edit: wanted a folder from `vdoor run --out`, found a file"),
        ((tmp_path / "none",), "edit: wanted a folder from `vdoor run --out`, found none"),
        ((tmp_path,), "found no map.json in it"),
        ((server.session.result, "--port", str(server.port)), "--port: cannot be used"),
    ):
        done = command("edit", *words)
        assert (done.code, done.out, done.err.count("\n")) == (2, "", 1)
        assert says in done.err
    with server.session.opened():
        assert "open in another page" in command("edit", server.session.result).err


def test_page_ends_by_ctrl_c_and_loses_nothing_when_it_is_killed(tmp_path: Path) -> None:
    folder = finished_maps.result("one room", tmp_path / "r")
    for ending in (signal.SIGKILL, signal.SIGINT):
        with subprocess.Popen([VDOOR, "edit", folder], stdout=subprocess.PIPE, stderr=subprocess.PIPE) as started:
            assert started.stdout is not None
            address = started.stdout.readline().decode().strip()
            with urllib.request.urlopen(f"{address}state") as answer:  # noqa: S310  # our own
                state = json.loads(answer.read())
            name = f"{state['rooms'][0]['name']}x"
            body = json.dumps({"words": ["rename", "1", name], "seen": state["edit"]["version"]}).encode()
            request = urllib.request.Request(  # noqa: S310  # our own
                f"{address}do", body, {"Content-Type": "application/json"}
            )
            with urllib.request.urlopen(request) as answer:  # noqa: S310  # our own
                assert json.loads(answer.read())["rooms"][0]["name"] == name
            os.kill(started.pid, ending)
            _, said = started.communicate(timeout=60)
        assert started.returncode == (0 if ending == signal.SIGINT else -signal.SIGKILL)
        assert b"Traceback" not in said
    state = Session(folder).state()
    assert (state["rooms"][0]["name"], state["edit"]["count"]) == ("xx", 2)
