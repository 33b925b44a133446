"""Screenshots of a recording on a machine without a screen, by Rerun's headless viewer."""

from __future__ import annotations

import subprocess
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rerun.experimental import ViewerClient

from vdoor.errors import VdoorError
from vdoor.viz.rerun.program import HOST, end, free_port, start, wait_until_listening

START_S, LOAD_S, STEADY_S = 30.0, 120.0, 60.0
NO_RENDERER = (
    "pictures: no software renderer (Vulkan) was found; on Debian or Ubuntu: apt install mesa-vulkan-drivers libvulkan1"
)


@dataclass(frozen=True)
class Shot:
    """One screenshot."""

    tab: str
    number: int
    """Index of the tab, from the left."""
    png: bytes
    problems: tuple[str, ...]
    """Errors that views reported."""


def shots(
    recording: Path, *, tabs: Sequence[str] | None = None, size: tuple[int, int] = (1600, 1000)
) -> Iterator[Shot]:
    """Screenshots of each tab, or of `tabs`, at the end of the recording; `VdoorError` if they cannot be made."""
    with headless(recording, size) as client:
        yield from shots_in(client, tabs)


def shots_in(client: ViewerClient, tabs: Sequence[str] | None = None) -> Iterator[Shot]:
    """Screenshots of each tab, or of some, of the recording that a viewer has loaded."""
    current = client.get_state().recordings[0]
    last = next((line.end for line in current.timelines if line.name == "step"), None) or 0
    client.set_time("step", sequence=last, play_state="paused")
    names = list(tabs_in(client))
    for tab in tabs or names:
        open_tab(client, tab)
        png = steady(client)
        reports = [f"{view.name}: {report.summary}" for view in client.get_state().views for report in view.reports]
        yield Shot(tab, names.index(tab), png, tuple(reports))


def open_tab(client: ViewerClient, tab: str) -> None:
    """Bring a tab of the recording's blueprint to the front; `VdoorError` if there is no such tab."""
    known = tabs_in(client)
    if tab not in known:
        raise VdoorError(f"pictures: wanted one of the recording's tabs, {', '.join(known)}, found {tab!r}")
    layout = client.get_blueprint(of="recording").blueprint
    layout[root_of(layout)]["ContainerBlueprint"]["active_tab"] = known[tab]
    client.set_blueprint(layout, of="recording")


def tabs_in(client: ViewerClient) -> dict[str, str]:
    """Entities of the tabs of the recording's blueprint, by name, from left to right."""
    layout = client.get_blueprint(of="recording").blueprint
    paths = layout[root_of(layout)]["ContainerBlueprint"]["contents"]
    return {layout[path]["ContainerBlueprint"]["display_name"]: path for path in paths}


def root_of(layout: Mapping[str, Any]) -> str:
    """Entity of the root container."""
    return "/container/" + str(layout["/viewport"]["ViewportBlueprint"]["root_container"])


@contextmanager
def headless(recording: Path, size: tuple[int, int]) -> Iterator[ViewerClient]:
    """A viewer without a window that has loaded the recording."""
    if not recording.is_file():
        raise VdoorError(f"pictures: wanted a recording, found none: {recording}")
    port = free_port()
    window = ("--window-size", f"{size[0]}x{size[1]}")
    process = start("--headless", "--port", str(port), *window, "--memory-limit", "4GB", "--", recording)
    try:
        if not wait_until_listening(process, port, START_S):
            raise VdoorError(NO_RENDERER)
        client = ViewerClient.connect(f"rerun+http://{HOST}:{port}/proxy")
        wait_until_loaded(client, process, recording)
        yield client
    finally:
        end(process)


def wait_until_loaded(client: ViewerClient, process: subprocess.Popen[bytes], recording: Path) -> None:
    """Return when the viewer has read the whole recording."""
    until = time.monotonic() + LOAD_S
    while time.monotonic() < until:
        if process.poll() is not None:
            raise VdoorError(NO_RENDERER)
        try:
            state = client.get_state()
        except (RuntimeError, ConnectionError, ValueError):
            state = None  # it accepts connections before it answers
        if state and state.recordings and not state.loading:
            return
        time.sleep(0.1)
    raise VdoorError(f"pictures: the viewer did not load the recording within {LOAD_S:.0f} s: {recording}")


def steady(client: ViewerClient) -> bytes:
    """A screenshot that equals the one before it, so that drawing has finished; the last one if time is up."""
    until = time.monotonic() + STEADY_S
    before = b""
    while time.monotonic() < until:
        png = client.take_screenshot()
        if png == before:
            return png
        before = png
        time.sleep(0.1)
    return before
