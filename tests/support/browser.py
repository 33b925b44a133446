"""A real headless browser, spoken to over its debugging pipe: JSON ended by zero bytes, on descriptors 3 and 4."""

from __future__ import annotations

import base64
import contextlib
import json
import os
import select
import shutil
import subprocess
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

NAMES = ("chromium", "chromium-browser", "google-chrome")
FLAGS = (
    "--headless",
    "--no-sandbox",
    "--disable-gpu",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--hide-scrollbars",
    "--window-size=1400,1000",
    "--remote-debugging-pipe",
)
MOST_S = 60.0


class Browser:
    """One page of a browser that runs, and what went wrong in it."""

    def __init__(self, to: int, answers: int) -> None:
        self._to, self._answers, self._buffer = to, answers, b""
        self._number, self._session = 0, ""
        self.requests: list[str] = []
        """Every address the page asked for."""
        self.problems: list[str] = []
        """Errors and warnings of the page's own script, its console and its security policy."""
        target = self.call("Target.createTarget", url="about:blank")["targetId"]
        self._session = self.call("Target.attachToTarget", targetId=target, flatten=True)["sessionId"]
        for part in ("Page", "Runtime", "Network", "Log"):
            self.call(f"{part}.enable")

    def call(self, method: str, **params: Any) -> Any:
        """Give what one call of the DevTools protocol answers."""
        self._number += 1
        message = {"id": self._number, "method": method, "params": params}
        if self._session:
            message["sessionId"] = self._session
        os.write(self._to, json.dumps(message).encode() + b"\0")
        while True:
            answer = self._next()
            if answer.get("id") == self._number:
                assert "error" not in answer, answer
                return answer["result"]
            self._note(answer)

    def open(self, path: Path) -> None:
        """Open a file and wait until it is loaded."""
        self.go(path.absolute().as_uri())

    def go(self, address: str) -> None:
        """Open an address and wait until it is loaded."""
        self.call("Page.navigate", url=address)
        self.wait("document.readyState === 'complete'")
        self.settle()

    def wait(self, script: str) -> None:
        """Wait until an expression holds in the page."""
        until = time.monotonic() + MOST_S
        while not self.run(script):
            assert time.monotonic() < until, f"never came: {script}"
            time.sleep(0.02)

    def run(self, script: str) -> Any:
        """Give what an expression is worth in the page."""
        told = self.call("Runtime.evaluate", expression=script, returnByValue=True, awaitPromise=True)
        assert "exceptionDetails" not in told, told
        return told["result"].get("value")

    def settle(self) -> None:
        """Let the page draw what has changed."""
        self.run("new Promise(done => requestAnimationFrame(() => requestAnimationFrame(() => done(1))))")

    def mouse(self, kind: str, x: float, y: float, **more: Any) -> None:
        """Move, press, release or turn the wheel at a place of the window."""
        self.call("Input.dispatchMouseEvent", type=f"mouse{kind}", x=x, y=y, **more)
        self.settle()

    def click(self, x: float, y: float) -> None:
        """Click at a place of the window."""
        self.drag((x, y), (x, y))

    def drag(self, start: tuple[float, float], end: tuple[float, float]) -> None:
        """Press at one place, move to another, release there."""
        self.mouse("Moved", *start)
        self.mouse("Pressed", *start, button="left", clickCount=1)
        if end != start:
            self.mouse("Moved", *end, button="left", buttons=1)
        self.mouse("Released", *end, button="left", clickCount=1)

    def write(self, text: str) -> None:
        """Type a text, and Enter behind it."""
        self.call("Input.insertText", text=text)
        enter = {"key": "Enter", "windowsVirtualKeyCode": 13}
        self.call("Input.dispatchKeyEvent", type="keyDown", text="\r", **enter)
        self.call("Input.dispatchKeyEvent", type="keyUp", **enter)

    def key(self, key: str) -> None:
        """Press a key and let it go."""
        text = {"text": key} if len(key) == 1 else {}
        self.call("Input.dispatchKeyEvent", type="keyDown", key=key, **text)
        self.call("Input.dispatchKeyEvent", type="keyUp", key=key)
        self.settle()

    def place(self, selector: str) -> tuple[float, float]:
        """Give the middle of an element in the window."""
        box = f"document.querySelector({json.dumps(selector)}).getBoundingClientRect()"
        x, y = self.run(f"(box => [box.x + box.width / 2, box.y + box.height / 2])({box})")
        return x, y

    def picture(self, selector: str) -> bytes:
        """Give a PNG of an element that is in sight."""
        box = f"document.querySelector({json.dumps(selector)}).getBoundingClientRect()"
        clip = self.run(f"(box => ({{x: box.x, y: box.y, width: box.width, height: box.height, scale: 1}}))({box})")
        return base64.b64decode(self.call("Page.captureScreenshot", format="png", clip=clip)["data"])

    def _next(self) -> Any:
        until = time.monotonic() + MOST_S
        while b"\0" not in self._buffer:
            ready, _, _ = select.select([self._answers], [], [], max(until - time.monotonic(), 0))
            piece = os.read(self._answers, 1 << 20) if ready else b""
            assert piece, "the browser does not answer"
            self._buffer += piece
        message, _, self._buffer = self._buffer.partition(b"\0")
        return json.loads(message)

    def _note(self, event: Any) -> None:
        method, params = event.get("method"), event.get("params", {})
        if method == "Network.requestWillBeSent":
            self.requests.append(params["request"]["url"])
        elif method == "Runtime.exceptionThrown":
            self.problems.append(json.dumps(params["exceptionDetails"]))
        elif method == "Log.entryAdded" and params["entry"]["level"] in ("error", "warning"):
            self.problems.append(params["entry"]["text"])
        elif method == "Runtime.consoleAPICalled" and params["type"] in ("error", "warning", "assert"):
            self.problems.append(json.dumps(params["args"]))


@contextlib.contextmanager
def browser(profile: Path) -> Iterator[Browser]:
    """A browser with an empty profile; the test is skipped where none is installed."""
    program = next(filter(None, map(shutil.which, NAMES)), None)
    if program is None:
        pytest.skip(f"no browser: wanted one of {', '.join(NAMES)} (Debian: apt-get install chromium)")
    read_by_it, to = os.pipe()
    answers, written_by_it = os.pipe()
    words = [program, *FLAGS, f"--user-data-dir={profile}"]
    # A shell puts the pipes where the browser looks for them.
    script = f'exec "$@" 3<&{read_by_it} 4>&{written_by_it}'
    started = subprocess.Popen(
        ["bash", "-c", script, "bash", *words],
        pass_fds=(read_by_it, written_by_it),
        stderr=subprocess.DEVNULL,
        start_new_session=True,
    )
    os.close(read_by_it)
    os.close(written_by_it)
    try:
        yield Browser(to, answers)
    finally:
        os.close(to)  # it ends with its pipe
        try:
            started.wait(10)
        except subprocess.TimeoutExpired:
            started.kill()
            started.wait()
        os.close(answers)
