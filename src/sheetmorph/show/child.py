"""The process beside this one that draws with VTK, seen from this side."""

from __future__ import annotations

import contextlib
import errno
import json
import os
import queue
import signal
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Sequence
from pathlib import Path
from typing import IO, Any, cast

import numpy as np

from sheetmorph.show.render_worker import view_parameters
from sheetmorph.show.scene import Image, Job

EGL_MISSING = "libEGL.so.1 is missing"


class RenderError(Exception):
    """The child does not draw. The message says why and what to install, in one line."""

    def __init__(self, reason: str, errors: str = "") -> None:
        super().__init__(f"{reason}; {remedy(reason + errors)}")


class Child:
    """A running child, its pipes and the folder through which arrays travel.

    Args:
        command: the program to start.
        patience: seconds without a picture after which the child is given up.

    Raises:
        RenderError: the program cannot be started.
    """

    def __init__(self, command: Sequence[str], patience: float) -> None:
        self._patience = patience
        self._jobs = 0
        self._done: set[tuple[int, int]] = set()
        self._answers: queue.SimpleQueue[dict[str, Any] | None] = queue.SimpleQueue()
        try:
            self._folder = tempfile.TemporaryDirectory(
                prefix="sheetmorph-", ignore_cleanup_errors=True
            )
        except OSError as error:
            raise RenderError(f"it has no room for its files ({error.strerror})") from error
        self._path = Path(self._folder.name)
        try:
            with (self._path / "errors.txt").open("w") as errors:
                self._process = subprocess.Popen(  # noqa: S603
                    list(command),
                    stdin=subprocess.PIPE,
                    stdout=subprocess.PIPE,
                    stderr=errors,
                    text=True,
                    encoding="utf-8",
                )
        except OSError as error:
            self._folder.cleanup()
            raise RenderError(f"it cannot be started ({error.strerror or error})") from error
        self._jobs_in = cast(IO[str], self._process.stdin)
        self._answers_out = cast(IO[str], self._process.stdout)
        self._listener = threading.Thread(target=self._listen, daemon=True)
        self._listener.start()

    def send(self, job: Job) -> int:
        """Hand over a job; returns its number.

        Raises:
            RenderError: the child has ended.
        """
        number, self._jobs = self._jobs, self._jobs + 1
        textures: dict[str, Any] = {f"texture{k}": t for k, t in enumerate(job.textures)}
        file = self._path / f"{number}.npz"
        line = {
            "job": number,
            "file": str(file),
            "textures": len(job.textures),
            "views": [view_parameters(view) for view in job.views],
        }
        try:
            np.savez(
                file,
                allow_pickle=False,
                triangles=job.triangles,
                uv=job.uv,
                points=np.array([view.points for view in job.views], dtype=np.float32),
                colours=np.array([view.colours for view in job.views], dtype=np.uint8),
                **textures,
            )
            self._jobs_in.write(json.dumps(line) + "\n")
            self._jobs_in.flush()
        except BrokenPipeError as error:
            raise self._failure(f"{error.strerror or error}") from error
        except OSError as error:
            raise RenderError(f"it has no room for its files ({error.strerror})") from error
        return number

    def receive(self, number: int, view: int) -> Image:
        """The picture of one view of a job, shape (height, width, 3); waits for it.

        Raises:
            RenderError: the child has ended or is silent for too long.
        """
        deadline = time.monotonic() + self._patience
        while (number, view) not in self._done:
            try:
                answer = self._answers.get(timeout=max(0.0, deadline - time.monotonic()))
            except queue.Empty:
                reason = f"it was silent for {self._patience:g} s"
                raise RenderError(reason) from None
            if answer is None:
                raise self._failure("it ended too early")
            deadline = time.monotonic() + self._patience
            if "view" in answer:
                self._done.add((answer["job"], answer["view"]))
        file = self._path / f"{number}-{view}.npy"
        try:
            image = cast(Image, np.load(file, allow_pickle=False))
        except (OSError, ValueError) as error:
            raise RenderError("its picture cannot be read") from error
        file.unlink(missing_ok=True)
        return image

    def close(self) -> None:
        """End the child and remove the folder."""
        with contextlib.suppress(OSError):
            self._jobs_in.close()
        self._process.terminate()
        try:
            self._process.wait(timeout=2.0)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
        self._listener.join(timeout=2.0)
        self._answers_out.close()
        self._folder.cleanup()

    def _listen(self) -> None:
        with contextlib.suppress(OSError, ValueError):
            for line in self._answers_out:
                self._answers.put(json.loads(line))
        self._answers.put(None)

    def _failure(self, reason: str) -> RenderError:
        """Why the child does not draw, as far as its end and its last words tell."""
        text = (self._path / "errors.txt").read_text(encoding="utf-8", errors="replace")
        with contextlib.suppress(subprocess.TimeoutExpired):
            code = self._process.wait(timeout=2.0)
            number = -code if code < 0 else code - 128
            if number > 0:
                with contextlib.suppress(ValueError):
                    return RenderError(f"it crashed with {signal.Signals(number).name}", text)
            last = text.strip().splitlines()[-1:]
            reason = f"it ended with status {code}" + "".join(f" ({line[:120]})" for line in last)
        return RenderError(reason, text)


def remedy(errors: str) -> str:
    """What to do so that VTK draws, given what was said."""
    if "no room" in errors or os.strerror(errno.ENOSPC) in errors:
        return "free some space in the folder of temporary files, or name another by TMPDIR"
    if "No module named 'vtk" in errors:
        return "install it with: pip install vtk"
    if not sys.platform.startswith("linux"):
        return "update the graphics driver"
    install = "apt-get install libegl1 libgl1-mesa-dri"
    if EGL_MISSING in errors:
        return f"{EGL_MISSING}; on Debian or Ubuntu: {install}"
    return f"on Debian or Ubuntu try: {install}"
