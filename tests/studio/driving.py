"""Driving a studio from outside, as a browser does."""

from __future__ import annotations

import contextlib
import json
import re
import secrets
import signal
import subprocess
import sys
import time
import urllib.error
import urllib.request
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import psutil
from small import SMALL
from websockets.sync.client import ClientConnection, connect

from sheetmorph.studio.frames import arrays_of, head_of

SHOTS = Path(__file__).resolve().parents[2] / "results" / "studio-screenshots"
"""Where the browser tests leave what they saw; not under version control."""


@dataclass
class Running:
    """A studio that runs: its process, its address, its design file."""

    process: subprocess.Popen[str]
    address: str
    file: Path

    @property
    def host(self) -> str:
        return self.address.split("//")[1].split("/")[0]

    def children(self, which: str = "studio.worker") -> list[int]:
        """Process numbers of its workers; with "--warm" of those that solve."""
        found = []
        for one in psutil.Process(self.process.pid).children():
            with contextlib.suppress(psutil.Error):  # it ended between the two looks
                if which in " ".join(one.cmdline()):
                    found.append(one.pid)
        return found

    def request(
        self, path: str, data: bytes | None = None, **headers: str
    ) -> tuple[int, bytes, dict[str, str]]:
        """Status, body and headers of a GET, or of a POST with data."""
        base = self.address.split("?")[0].rstrip("/")
        ask = urllib.request.Request(f"{base}{path}", data=data, headers=headers)  # noqa: S310
        try:
            with urllib.request.urlopen(ask, timeout=30) as answer:  # noqa: S310
                return answer.status, answer.read(), dict(answer.headers)
        except urllib.error.HTTPError as error:
            return error.code, error.read(), dict(error.headers)


def start_studio(folder: Path, *options: str, text: str = SMALL) -> Running:
    """Start a studio with a design file in a folder."""
    file = folder / "small.toml"
    file.write_text(text, encoding="utf-8")
    command = [sys.executable, "-m", "sheetmorph", "studio", str(file), "--no-browser"]
    process = subprocess.Popen(
        [*command, "--port", "0", "--workers", "1", *options],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        encoding="utf-8",
    )
    assert process.stdout is not None
    line = process.stdout.readline()
    found = re.search(r"http://\S+", line)
    if found is None:
        process.kill()
        raise AssertionError(f"{line}{process.communicate()[1]}")
    return Running(process, found[0], file)


def stop_studio(studio: Running) -> tuple[int, str]:
    """Interrupt a studio as Ctrl-C does; its exit code and what it said."""
    studio.process.send_signal(signal.SIGINT)
    _, errors = studio.process.communicate(timeout=90)
    return studio.process.returncode, errors


@dataclass
class Tab:
    """What a page does, without a page."""

    studio: Running
    socket: ClientConnection
    name: str
    seen: list[dict[str, Any]] = field(default_factory=list)
    arrays: dict[str, np.ndarray[Any, Any]] = field(default_factory=dict)
    shape: np.ndarray[Any, Any] = field(default_factory=lambda: np.zeros((0, 3)))

    def order(self, do: str, **more: object) -> None:
        self.socket.send(json.dumps({"do": do, **more}))

    def wait(self, kind: str, seconds: float = 90.0) -> dict[str, Any]:
        """The next packet of a kind; what comes before it is kept in `seen`."""
        deadline = time.monotonic() + seconds
        while True:
            packet = self.socket.recv(max(0.01, deadline - time.monotonic()))
            assert isinstance(packet, bytes)
            head = head_of(packet)
            self.seen.append(head)
            if head["kind"] == kind:
                self.arrays = arrays_of(packet)
                if kind == "scene":
                    self.shape = self.arrays["positions"][-1]
                return head

    def solved(self) -> dict[str, Any]:
        """The next shape on the full mesh."""
        while True:
            head = self.wait("scene")
            if not head["preview"]:
                self.wait("settled")
                return head

    def upload(self, what: str, name: str, data: bytes) -> tuple[int, dict[str, Any]]:
        """Send a file as the page does."""
        status, body, _ = self.studio.request(
            f"/upload/{self.name}/{what}?name={name}", data, Origin=f"http://{self.studio.host}"
        )
        return status, json.loads(body)


def open_tab(studio: Running, name: str | None = None, query: str = "", **headers: str) -> Tab:
    """Open a tab on a studio."""
    name = name or secrets.token_hex(16)
    # The test closes it; some tests break it off instead.
    socket = connect(
        f"ws://{studio.host}/live/{name}{query}",
        origin=f"http://{studio.host}",  # type: ignore[arg-type]
        additional_headers=headers,
        max_size=None,
        ping_interval=None,
    ).__enter__()
    return Tab(studio, socket, name)
