"""Running CalculiX: finding it, watching it, stopping it in time."""

from __future__ import annotations

import os
import re
import shutil
import signal
import subprocess
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from time import monotonic
from typing import Literal

from sheetmorph.core.errors import InputError

VARIABLE = "SHEETMORPH_CCX"
"""Environment variable that names the program, where it is not `ccx` on the path."""
INSTALL = (
    "CalculiX (ccx) is not installed; on Debian and Ubuntu: sudo apt-get install calculix-ccx; "
    f"elsewhere see www.calculix.de, and let {VARIABLE} name the program"
)
PAUSE = 0.2
_RUN = ("frd", "sta", "cvg", "dat", "12d")

Ending = Literal["completed", "time_limit", "stopped"]


@dataclass(frozen=True)
class Ran:
    """How a run of the solver ended.

    Attributes:
        ending: "completed"; "time_limit" when it was stopped in time; "stopped" when it gave up.
        message: its last error, empty where there is none.
        seconds: it took.
        times: of its converged increments, all steps together.
        iterations: of its converged increments.
        processor_seconds: it used, on all its threads; 0 where the system does not tell.
    """

    ending: Ending
    message: str
    seconds: float
    times: tuple[float, ...]
    iterations: int
    processor_seconds: float = 0.0


def find_program() -> str:
    """Path of the solver.

    Raises:
        InputError: there is none; says how to install it.
    """
    wanted = os.environ.get(VARIABLE, "").strip() or "ccx"
    found = shutil.which(wanted)
    if found is None:
        if wanted == "ccx":
            raise InputError(INSTALL)
        raise InputError("there is no such program", key=VARIABLE, value=wanted)
    return found


def version(program: str) -> str:
    """What the solver says of its version, such as "2.20"; empty where it says nothing."""
    try:
        told = subprocess.run(  # noqa: S603
            [program, "-v"], capture_output=True, text=True, timeout=30, check=False
        ).stdout
    except (OSError, subprocess.TimeoutExpired):
        return ""
    found = re.search(r"[Vv]ersion\s+(\S+)", told)
    return found.group(1) if found else ""


def run(
    program: str,
    folder: Path,
    job: str,
    *,
    time_limit: float,
    threads: int = 1,
    on_time: Callable[[float], None] = lambda _time: None,
) -> Ran:
    """Solve `folder/job.inp`; its files lie beside it, and what it says in `job.log`.

    The program is stopped at the time limit, and when this process is interrupted. What it
    had reached by then stays in its files.

    Args:
        program: path of the solver.
        folder: where the deck lies.
        job: name of the deck without its ending.
        time_limit: [s].
        threads: it may use.
        on_time: is told the time of the last converged increment.

    Raises:
        InputError: the program cannot be started.
    """
    for suffix in _RUN:
        (folder / f"{job}.{suffix}").unlink(missing_ok=True)
    environment = os.environ | {
        name: str(threads)
        for name in ("OMP_NUM_THREADS", "CCX_NPROC_STIFFNESS", "CCX_NPROC_EQUATION_SOLVER")
    }
    began, used = monotonic(), _children()
    with (folder / f"{job}.log").open("wb") as log:
        try:
            process = subprocess.Popen(  # noqa: S603
                [program, job],
                cwd=folder,
                stdin=subprocess.DEVNULL,
                stdout=log,
                stderr=subprocess.STDOUT,
                env=environment,
                start_new_session=True,
            )
        except OSError as error:
            raise InputError(f"cannot be started ({error.strerror})", value=program) from None
        late = False
        try:
            while process.poll() is None and not late:
                late = monotonic() - began > time_limit
                _wait(process)
                times = _increments(folder / f"{job}.sta")[0]
                on_time(times[-1] if times else 0.0)
        finally:
            _stop(process)
    seconds = monotonic() - began
    said = (folder / f"{job}.log").read_text("latin-1")
    times, iterations = _increments(folder / f"{job}.sta")
    finished = process.returncode == 0 and "Job finished" in said
    ending: Ending = "completed" if finished else "time_limit" if late else "stopped"
    message = "" if finished else _last_error(said)
    return Ran(ending, message, seconds, times, iterations, _children() - used)


def _children() -> float:
    """Processor time of the processes that this one has seen end [s]."""
    told = os.times()
    return told.children_user + told.children_system


def _wait(process: subprocess.Popen[bytes]) -> None:
    try:
        process.wait(PAUSE)
    except subprocess.TimeoutExpired:
        return


def _stop(process: subprocess.Popen[bytes]) -> None:
    """End the program and all that it started."""
    if process.poll() is not None:
        return
    if hasattr(os, "killpg"):
        os.killpg(process.pid, signal.SIGKILL)
    else:
        process.kill()
    process.wait()


def _increments(status: Path) -> tuple[tuple[float, ...], int]:
    """Times of the converged increments in a status file, and the iterations they took.

    Its columns are step, increment, attempt, iterations, total time, step time, increment. An
    attempt that did not converge is marked by a letter.
    """
    try:
        lines = status.read_text("latin-1").splitlines()
    except OSError:
        return (), 0
    times, iterations = [], 0
    for line in lines:
        cells = line.split()
        if len(cells) == 7 and all(cell.isdigit() for cell in cells[:4]):
            try:
                times.append(float(cells[4]))
            except ValueError:
                continue  # the line is being written
            iterations += int(cells[3])
    return tuple(times), iterations


def _last_error(said: str) -> str:
    """The last error that the solver printed, on one line."""
    found = re.findall(r"\*ERROR:?\s*(.*(?:\n\s{6,}\S.*)*)", said)
    return " ".join(found[-1].split()) if found else ""
