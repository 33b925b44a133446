"""The Rerun recording: a sink that draws each record as it arrives, into a file or a live viewer."""

from __future__ import annotations

import hashlib
import json
import os
import subprocess
import uuid
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import BinaryIO
from urllib.parse import urlsplit

import rerun as rr
import rerun.blueprint as rrb

from vdoor.emit import RunInfo
from vdoor.errors import VdoorError, say
from vdoor.explain.stages import tabs_of
from vdoor.partial import Partial
from vdoor.pipeline import emitted
from vdoor.record import Record
from vdoor.viz.rerun.blueprint import blueprint, description, says, told
from vdoor.viz.rerun.draw import draw_record
from vdoor.viz.rerun.program import HOST, end, free_port, listening, start, wait_until_listening
from vdoor.viz.rerun.pump import Pump
from vdoor.viz.rerun.scene import Scene

APPLICATION = "vdoor"
GRPC_PORT, WEB_PORT = 9876, 9090
PATIENCE_S = 10.0
FLUSH_S = 60.0
"""Time limit of a flush."""
SWITCHED_OFF = ("0", "false", "off", "no")


class RerunSink:
    """Draws records on a Rerun stream; made by `to_file`, `connect`, `serve` or `spawn`."""

    def __init__(
        self,
        stream: rr.RecordingStream,
        info: RunInfo,
        *,
        server: subprocess.Popen[bytes] | None = None,
        path: Path | None = None,
        pump: Pump | None = None,
    ) -> None:
        self.path, self._pump = path, pump
        self.address = ""
        """URL for a browser, of a web server."""
        self._stream: rr.RecordingStream | None = stream
        self._server = server
        self._scene = Scene(stream)
        self._scene.threshold_deg = info.settings.get("candidates", {}).get("angle_deg", self._scene.threshold_deg)
        for tab in tabs_of(emitted(info), info.settings):
            self._scene.keep(says(tab), rr.TextDocument(told(tab), media_type="text/markdown"))
        self._scene.keep("description", rr.TextDocument(described(info), media_type="text/markdown"))

    @classmethod
    def to_file(cls, path: Path, info: RunInfo, file: BinaryIO | None = None) -> RerunSink:
        """Draw into `file`, a new one at `path` without it, with the blueprint; `VdoorError` if that fails."""
        with errors_at(path):
            stream, pump = new_stream(info), Pump(file or path.open("wb"))
            stream.save(pump.address, default_blueprint=blueprint(info))
            sink = cls(stream, info, path=path, pump=pump)
            try:
                sink.flush()
            except OSError:
                sink.end()
                raise
        return sink

    @classmethod
    def connect(cls, url: str, info: RunInfo) -> RerunSink:
        """Draw in a running viewer; `url` is host:port or rerun+http://host:port/proxy."""
        try:
            parts = urlsplit(url if "//" in url else f"//{url}")
            host, port = parts.hostname or HOST, parts.port or GRPC_PORT
        except ValueError as error:
            raise VdoorError(f"--connect: wanted HOST:PORT, found {url!r}") from error
        if not listening(host, port):
            raise VdoorError(f"--connect: wanted a Rerun viewer listening, found none: {host}:{port}")
        return cls._to(host, port, info)

    @classmethod
    def _to(cls, host: str, port: int, info: RunInfo, *, server: subprocess.Popen[bytes] | None = None) -> RerunSink:
        stream = new_stream(info, live=True)
        stream.connect_grpc(f"rerun+http://{host}:{port}/proxy", default_blueprint=blueprint(info))
        return cls(stream, info, server=server)

    @classmethod
    def spawn(cls, info: RunInfo) -> RerunSink:
        """Start a viewer and draw in it; the viewer stays open."""
        port = preferred(GRPC_PORT)
        start_viewer("--port", str(port), port=port)
        return cls._to(HOST, port, info)

    @classmethod
    def serve(cls, info: RunInfo) -> RerunSink:
        """Draw in a web viewer served from this machine; `close` waits until it is interrupted."""
        port, web_port = preferred(GRPC_PORT), preferred(WEB_PORT)
        server = start_viewer("--serve-web", "--port", str(port), "--web-viewer-port", str(web_port), port=port)
        sink = cls._to(HOST, port, info, server=server)
        sink.address = f"http://{HOST}:{web_port}?url=rerun%2Bhttp://{HOST}:{port}/proxy"
        return sink

    def write(self, step: int, record: Record) -> None:
        """Draw one record; in a file, it survives a kill once this returns."""
        if self._stream is None:
            raise VdoorError("recording: closed")
        with errors_at(self.path):
            self._scene.begin(step, record.topic)
            draw_record(self._scene, record)
            self.flush()

    def flush(self) -> None:
        """Wait until everything drawn so far is written; raises `OSError` or `RuntimeError` if it is not."""
        if self._stream is not None:
            self._stream.flush(timeout_sec=FLUSH_S)
        if self._pump is not None:
            self._pump.flush()

    def end(self) -> None:
        """Let go of the stream and close the file."""
        stream, self._stream = self._stream, None
        pump, self._pump = self._pump, None
        if stream is not None:
            stream.disconnect()
        del stream
        if pump is not None:
            pump.close()

    def close(self) -> None:
        """Write the footer; a server keeps running until Ctrl-C."""
        if self._stream is None:
            return
        with errors_at(self.path):
            try:
                self.flush()
            finally:
                self.end()
        if self._server is not None:
            try:
                say(f"open {self.address} in a browser; stop with Ctrl-C")
                self._server.wait()
            except (KeyboardInterrupt, SystemExit):
                pass  # the normal end of serving
            finally:
                end(self._server)


def new_stream(info: RunInfo, *, live: bool = False) -> rr.RecordingStream:
    """A stream without clock times. In a file its id is derived from the run, so that equal runs have equal ids.

    For a live viewer each run has a random id, as the viewer would merge runs with equal ids.
    """
    if os.environ.get("RERUN", "").lower() in SWITCHED_OFF:
        raise VdoorError(f"recording: Rerun is switched off by RERUN={os.environ['RERUN']} in the environment")
    rr.set_strict_mode(True)
    name = uuid.uuid4().hex if live else recording_id(info)
    stream = rr.RecordingStream(APPLICATION, recording_id=name, send_properties=False)
    stream.set_log_time_enabled(False)
    stream.set_log_tick_enabled(False)
    return stream


def recording_id(info: RunInfo) -> str:
    """Thirty-two hex digits derived from the map's bytes, the version, the settings and the seed."""
    digest = hashlib.sha256(json.dumps([info.version, info.preset, info.seed, info.settings], sort_keys=True).encode())
    for name, data in info.source.files:
        digest.update(name.encode() + b"\0" + data)
    return digest.hexdigest()[:32]


def described(info: RunInfo) -> str:
    """Guide to the views, and the run's version, preset, seed and map."""
    files = ", ".join(name for name, _ in info.source.files) or "an array"
    return f"{description(info)}\nvdoor {info.version}, preset `{info.preset}`, seed {info.seed}, map: {files}\n"


@contextmanager
def errors_at(path: Path | None) -> Iterator[None]:
    """Turn file errors into a `VdoorError` with the path."""
    try:
        yield
    except (OSError, RuntimeError) as error:
        reason = getattr(error, "strerror", None) or str(error).splitlines()[0]
        raise VdoorError(f"recording: cannot be written ({reason}): {path or 'live viewer'}") from error


def open_viewer(recording: Path) -> None:
    """Show a recording in a viewer on this machine's screen, until the viewer is closed."""
    if start("--", recording, quiet=False).wait():
        raise VdoorError(f"view: the viewer did not start or failed: {recording}")


def preferred(port: int) -> int:
    """The given port, or a free one if it is in use."""
    return free_port() if listening(HOST, port) else port


def start_viewer(*words: str, port: int) -> subprocess.Popen[bytes]:
    """A viewer or server that accepts connections; `VdoorError` if it does not start."""
    process = start(*words)
    if not wait_until_listening(process, port, PATIENCE_S):
        end(process)
        raise VdoorError(
            "viewer: the program `rerun` did not start; without a screen use --save, or --serve and a browser"
        )
    return process


@contextmanager
def whole_recording(path: Path, info: RunInfo, blueprint: rrb.Blueprint) -> Iterator[Scene]:
    """A scene to draw on; the file is complete when the block ends. `VdoorError` if it cannot be written."""
    partial = Partial(path)
    try:
        with errors_at(path):
            stream, pump = new_stream(info), Pump(partial.stream())
            stream.save(pump.address, default_blueprint=blueprint)
            try:
                yield Scene(stream)
                stream.flush(timeout_sec=FLUSH_S)
            finally:
                stream.disconnect()
                pump.close()
        partial.give_name()
    finally:
        partial.remove()
