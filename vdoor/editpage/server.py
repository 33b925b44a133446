"""The server of the page: on 127.0.0.1 only, for those who know its address with the token in it."""

from __future__ import annotations

import json
import secrets
from collections.abc import Callable, Mapping
from functools import partial
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler
from socketserver import TCPServer, ThreadingMixIn
from typing import Any

from vdoor.editpage.session import Session, StaleError
from vdoor.errors import SettingError, VdoorError
from vdoor.export.report.document import as_json

HOST = "127.0.0.1"
MOST_BYTES = 10_000
"""Longer requests are refused."""
WAIT_S = 30.0
HEADERS = {
    "Cache-Control": "no-store",
    "Content-Security-Policy": "frame-ancestors 'none'",  # the page's own policy has all that it can say itself
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Referrer-Policy": "no-referrer",
    "X-Content-Type-Options": "nosniff",
    "X-Frame-Options": "DENY",
}
Table = Mapping[str, Any]


class Refusal(Exception):  # noqa: N818  # an answer, not a mistake of the program
    """An answer other than what was asked for."""

    def __init__(self, status: HTTPStatus, sentence: str) -> None:
        super().__init__(sentence)
        self.status = status


class Server(ThreadingMixIn, TCPServer):
    """A server of one session; raises `SettingError` if the port is taken.

    Not the library's HTTP server, which asks the network for the name of this machine.
    """

    daemon_threads = True
    allow_reuse_address = True

    def __init__(self, session: Session, port: int = 0) -> None:
        self.session = session
        self.token = secrets.token_urlsafe(24)
        try:
            super().__init__((HOST, port), Handler)
        except OSError as error:
            raise SettingError(f"--port: cannot be used ({error.strerror}): {port}") from error

    @property
    def url(self) -> str:
        """The address of the page."""
        return f"http://{HOST}:{self.port}/{self.token}/"

    @property
    def port(self) -> int:
        """The port in use."""
        return int(self.server_address[1])


class Handler(BaseHTTPRequestHandler):
    """One request."""

    server: Server
    server_version, sys_version = "vdoor", ""
    timeout = WAIT_S

    def do_GET(self) -> None:
        """Answer with the page, or with the state of the result."""
        self._answer({"": self._page, "state": lambda: self._json(self.server.session.state())})

    def do_POST(self) -> None:
        """Do an edit, undo or redo one."""
        self._answer({name: partial(self._edited, do) for name, do in EDITS.items()})

    def log_message(self, format: str, *args: Any) -> None:  # noqa: A002  # the name that the library gives
        """Stay silent."""

    def _answer(self, known: Mapping[str, Callable[[], None]]) -> None:
        try:
            known[self._name(known)]()
        except Refusal as refusal:
            self._json({"sentence": str(refusal)}, refusal.status)
        except VdoorError as error:
            self._json({"sentence": self.server.session.sentence(error)}, HTTPStatus.INTERNAL_SERVER_ERROR)

    def _name(self, known: Mapping[str, Any]) -> str:
        """What is asked for; refused unless the request comes from this page or from this machine's user."""
        own = [f"{name}:{self.server.port}" for name in (HOST, "localhost")]
        host, origin = self.headers.get("Host", ""), self.headers.get("Origin")
        _, token, name = [*self.path.split("/", 2), "", ""][:3]
        if host not in own or origin not in (None, f"http://{host}"):
            raise Refusal(HTTPStatus.FORBIDDEN, "This page is for this machine only.")
        if not secrets.compare_digest(token.encode(), self.server.token.encode()):
            raise Refusal(HTTPStatus.FORBIDDEN, "Wanted the address that `vdoor edit` printed.")
        if name not in known:
            raise Refusal(HTTPStatus.NOT_FOUND, "There is nothing here.")
        return name

    def _edited(self, do: Callable[[Session, Table], dict[str, Any]]) -> None:
        """Do what was asked for; if it cannot be done, say so, with the result as it is."""
        session, table = self.server.session, self._table()
        try:
            self._json(do(session, table))
        except StaleError as error:
            self._json(session.state() | {"sentence": str(error)})
        except VdoorError as error:
            self._json({"sentence": session.sentence(error)})

    def _table(self) -> Table:
        """The body: a small JSON object, sent as such, which no form of another page can do."""
        length = self.headers.get("Content-Length", "")
        if not length.isdecimal() or int(length) > MOST_BYTES:
            raise Refusal(HTTPStatus.REQUEST_ENTITY_TOO_LARGE, f"Wanted at most {MOST_BYTES} bytes.")
        if self.headers.get_content_type() != "application/json":
            raise Refusal(HTTPStatus.UNSUPPORTED_MEDIA_TYPE, "Wanted JSON.")
        try:
            table = json.loads(self.rfile.read(int(length)))
        except (ValueError, RecursionError):
            table = None
        if not isinstance(table, dict) or not isinstance(table.get("seen"), str):
            raise Refusal(HTTPStatus.BAD_REQUEST, "Wanted a JSON object with what the page has seen.")
        return table

    def _page(self) -> None:
        self._send(self.server.session.page().encode(), "text/html; charset=utf-8")

    def _json(self, table: Table, status: HTTPStatus = HTTPStatus.OK) -> None:
        self._send(as_json(table).encode(), "application/json", status)

    def _send(self, content: bytes, kind: str, status: HTTPStatus = HTTPStatus.OK) -> None:
        self.close_connection = True
        self.send_response(status)
        for name, value in {**HEADERS, "Content-Type": kind, "Content-Length": str(len(content))}.items():
            self.send_header(name, value)
        self.end_headers()
        self.wfile.write(content)


def _do(session: Session, table: Table) -> dict[str, Any]:
    words = table.get("words")
    if not isinstance(words, list) or not words or not all(isinstance(word, str) for word in words):
        raise Refusal(HTTPStatus.BAD_REQUEST, "Wanted the words of an edit.")
    action, *rest = words
    return session.do(action, rest, seen=table["seen"])


EDITS: Mapping[str, Callable[[Session, Table], dict[str, Any]]] = {
    "do": _do,
    "undo": lambda session, table: session.go(-1, seen=table["seen"]),
    "redo": lambda session, table: session.go(1, seen=table["seen"]),
}
"""What can be posted."""
