"""Full disks, folders that cannot be written, clocks that jump: real ones, under every command.

    sudo python benchmarks/disks.py full readonly clock          all commands
    sudo python benchmarks/disks.py full --jobs run sweep --fills 40

Linux, as root, because it mounts file systems in memory (tmpfs) and, for `readonly`, makes folders
that not even root may change. `clock` needs no root but a C compiler, and never touches the clock
of the machine: a library of a few lines is loaded into the job and all its processes, and tells
them another time of day. (libfaketime does not do: it moves sleeps by the monotonic clock, too.)

full       A job writes into a file system that has room for a part of what it writes: for nothing,
           for so many parts in between, and for all but the last page. It must end with exit code
           2 and one line, leave every file whole and every earlier file as it was; then
           there is room, and the job goes on as its message says and finds the same.
readonly   The same on a file system that is mounted read-only, in an immutable folder, and over
           the finished job in it with --force.
clock      The clock goes back or forward by an hour and by a year while a job runs, and the files
           that it has written lie in the future: the result must be the same.

Prints a line for each trial that failed and one for each kind of job; exit code 1 if any failed.
"""

from __future__ import annotations

import argparse
import contextlib
import hashlib
import json
import os
import shutil
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import kill  # sets the numbers of threads, so it comes before all of ours
import sheetmorph as sm
from sheetmorph.design.presets import preset_text
from sheetmorph.study.simulate import simulate

PAGE = 4096
PATIENCE = 600.0
KEPT = "notes of the user.txt"
RESUMABLE = ("run", "sweep", "calibrate", "design")
JOBS = (*RESUMABLE, "compare", "fabricate", "branches", "paper", "new", "export")
JUMPS = {
    "an hour back": -3600,
    "a year back": -31_536_000,
    "an hour on": 3600,
    "a year on": 31_536_000,
}
CLOCKED = ("run", "sweep", "calibrate", "design")
SHIM = r"""
#define _GNU_SOURCE
#include <dlfcn.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/time.h>
#include <time.h>
static long long shift(void) {
  long long seconds = 0;
  FILE *file = fopen(getenv("TRIAL_CLOCK"), "r");
  if (file) { if (fscanf(file, "%lld", &seconds) != 1) seconds = 0; fclose(file); }
  return seconds;
}
int clock_gettime(clockid_t which, struct timespec *now) {
  static int (*real)(clockid_t, struct timespec *);
  if (!real) real = dlsym(RTLD_NEXT, "clock_gettime");
  int code = real(which, now);
  if (which == CLOCK_REALTIME || which == CLOCK_REALTIME_COARSE) now->tv_sec += shift();
  return code;
}
time_t time(time_t *where) {
  struct timespec now;
  clock_gettime(CLOCK_REALTIME, &now);
  if (where) *where = now.tv_sec;
  return now.tv_sec;
}
int gettimeofday(struct timeval *now, void *zone) {
  struct timespec exact;
  (void)zone;
  clock_gettime(CLOCK_REALTIME, &exact);
  now->tv_sec = exact.tv_sec;
  now->tv_usec = exact.tv_nsec / 1000;
  return 0;
}
"""
"""The time of day, moved by as many seconds as a file says."""


@dataclass(frozen=True)
class Ended:
    """How a command ended: exit code (None: it hung) and what it wrote to its errors."""

    code: int | None
    said: str

    @property
    def clean(self) -> bool:
        """Exit code 2 and one line that is an error of ours."""
        lines = [line for line in self.said.splitlines() if line.strip()]
        return self.code == 2 and len(lines) == 1 and lines[0].startswith("sheetmorph: ")


def inputs(place: Path) -> None:
    """All that the jobs read: those of kill.py, a run, and a design that draws pictures."""
    kill.inputs(place)
    drawn = preset_text("petals", "drawn").split("[outputs]")[0]
    design = sm.Design.from_toml(drawn).with_values({"mesh.size": "12 mm"})
    design.save(place / "drawn.toml")
    simulate(design).save(place / "shape")


def line_of(kind: str, inside: Path, folder: Path) -> list[str]:
    """The command line of a job, without what it says of earlier ones."""
    if kind in ("sweep", "calibrate"):
        return [part for part in kill.arguments(kind, inside, folder) if part != "--no-pictures"]
    scan = inside / "shape"
    return {
        "run": ["run", str(inside / "drawn.toml"), "-o", str(folder), "-q"],
        "design": [
            *("design", "saddle:0.4", "--family", "ring", "-o", str(folder), "-q"),
            *("--sheet", "100 mm", "--fix", "radius=0.9", "--set", "mesh.size=11 mm"),
            *("--budget", "8", "--descents", "0", "--workers", "1"),
        ],
        "compare": ["compare", str(scan), str(scan), "-o", str(folder), "--grid", "24", "-q"],
        "fabricate": ["fabricate", str(inside / "design.toml"), "-o", str(folder), "-q"],
        "branches": [
            *("branches", str(inside / "design.toml"), "-o", str(folder), "-q"),
            *("--random", "0", "--modes", "0", "--no-sectors"),
        ],
        "paper": ["paper", "--only", "constants", "-o", str(folder), "-q"],
        "new": ["new", str(folder / "fresh"), "--preset", "bowl"],
        "export": ["export", str(inside / "design.toml"), str(folder)],
    }[kind]


def command(line: list[str]) -> int:
    """The command line, and what the studio does when files are taken away."""
    if line[0] != "export":
        return kill.command(line)
    from sheetmorph.core.errors import SheetmorphError
    from sheetmorph.studio.exports import export

    class Desk:
        """Stands for the side of the browser."""

        def answer(self, *_about: object) -> None: ...

        def listen(self, _event: object) -> None: ...

    text = Path(line[1]).read_text("utf-8")
    job = {"text": text, "values": {}, "into": line[2], "what": ["run", "parts"]}
    try:
        export(job, Desk(), None)  # type: ignore[arg-type]
    except SheetmorphError as error:
        print(f"sheetmorph: {error}", file=sys.stderr)
        return error.exit_code
    return 0


def ended(line: list[str], seconds: float = PATIENCE) -> Ended:
    """Run a command in a fork, which saves the imports, with its errors caught."""
    if line[0] == "sweep":  # starts processes of its own, to which forks are strange
        return program(line)
    with tempfile.TemporaryFile() as errors:
        child = os.fork()
        if not child:
            os.setsid()
            code = 70
            try:
                os.dup2(errors.fileno(), 2)
                nowhere = os.open(os.devnull, os.O_WRONLY)
                os.dup2(nowhere, 1)
                sys.argv = ["sheetmorph", *line]
                code = command(line)
            except BaseException:
                import traceback

                traceback.print_exc()
            finally:
                os._exit(code)
        code = kill.finished(child, seconds)
        errors.seek(0)
        return Ended(code, errors.read().decode(errors="replace"))


def must(how: Ended) -> None:
    """End the trials where a job fails that nothing stands in the way of."""
    if how.code != 0:
        raise SystemExit(f"fails without trouble: {how}")


@contextlib.contextmanager
def memory_disk(point: Path, size: int) -> Iterator[Path]:
    """A file system of so many bytes in memory, gone at the end."""
    point.mkdir(exist_ok=True)
    # A page more, for the file of the user that lies there already.
    mount("-t", "tmpfs", "-o", f"size={size + PAGE}", "tmpfs", str(point))
    try:
        yield point
    finally:
        subprocess.run(["umount", "--lazy", str(point)], check=True)  # noqa: S603, S607


def mount(*options: str) -> None:
    """Call mount(8)."""
    subprocess.run(["mount", *options], check=True)  # noqa: S603, S607


def prints(folder: Path) -> dict[str, str]:
    """Fingerprints of the files in a folder."""
    return {
        str(file.relative_to(folder)): hashlib.sha256(file.read_bytes()).hexdigest()
        for file in folder.rglob("*")
        if file.is_file()
    }


def found(kind: str, folder: Path) -> object:
    """What a finished job found, without times."""
    if kind in ("run", "sweep", "calibrate"):
        return kill.content(kind, folder)
    if kind == "design":
        numbers = json.loads((folder / "inverse.json").read_text("utf-8"))
        del numbers["computed"]  # by this call, without those of the one that was stopped
        return json.dumps(kill.without_times(numbers), sort_keys=True)
    return sorted(str(file.relative_to(folder)) for file in folder.rglob("*"))


def leftovers(folder: Path) -> list[str]:
    """Files that no job may leave."""
    return [
        file.name
        for file in folder.rglob("*")
        if ".partial" in file.name or file.name == ".sheetmorph.lock"
    ]


def goes_on(kind: str, folder: Path) -> list[str]:
    """What the message of the job tells to add; nothing where it left nothing."""
    if kind in ("run", "sweep", "calibrate"):
        wanted = kill.goes_on(kind, folder)
        return [] if wanted == ["--force"] and not any(folder.glob("*")) else wanted
    if kind == "design" and (folder / "evaluations.jsonl").exists():
        return ["--resume"]
    return ["--force"] if kind in ("compare", "fabricate", "branches", "paper", "new") else []


def peak(kind: str, inside: Path, place: Path) -> int:
    """Most bytes that a job takes up on a disk that has room."""
    with memory_disk(place / "disk", 1 << 29) as disk:
        most, done = 0, threading.Event()

        def watch() -> None:
            nonlocal most
            while not done.wait(0.002):
                most = max(most, shutil.disk_usage(disk).used)

        watcher = threading.Thread(target=watch)
        watcher.start()
        try:
            how = ended(line_of(kind, inside, disk / "job"))
        finally:
            done.set()
            watcher.join()
        must(how)
        return max(most, shutil.disk_usage(disk).used)


def full(kind: str, inside: Path, place: Path, fills: int) -> tuple[str, list[str]]:
    """A disk with room for a part of the job."""
    whole = place / "whole"
    must(ended(line_of(kind, inside, whole)))
    wanted, most = found(kind, whole), peak(kind, inside, place)
    rooms = sorted({0, *(most * k // fills for k in range(1, fills)), most - PAGE})
    wrong: list[str] = []
    stopped = resumed = fitted = 0
    for room in rooms:
        with memory_disk(place / "disk", room) as disk:
            folder = disk / "job"
            mine = disk / KEPT
            mine.write_text("mine")
            how = ended(line_of(kind, inside, folder))
            where = f"{kind}, room for {room} of {most} bytes"
            wrong += [f"{where}: {one}" for one in judged(how, disk, mine)]
            fitted += how.code == 0
            stopped += how.clean
            options = goes_on(kind, folder) if how.code != 0 else []
            mount("-o", f"remount,size={1 << 29}", str(disk))
            if how.code != 0:
                if kind == "export":  # the studio gives every export a folder of its own
                    shutil.rmtree(folder, ignore_errors=True)
                again = ended([*line_of(kind, inside, folder), *options])
                resumed += "--resume" in options
                if again.code != 0:
                    wrong.append(f"{where}: does not go on with {options}: {again.said.strip()}")
                    continue
            if found(kind, folder) != wanted:
                wrong.append(f"{where}: another result after {options}")
    told = f"{len(rooms)} rooms below {most} bytes: {stopped} ended with one line, {fitted} fitted"
    return told + (f", {resumed} gone on with --resume" if kind in RESUMABLE else ""), wrong


def judged(how: Ended, disk: Path, mine: Path) -> list[str]:
    """What is wrong after a job on a full disk."""
    wrong = []
    if how.code is None:
        wrong.append(f"had not ended after {PATIENCE:.0f} s")
    elif how.code != 0 and not how.clean:
        wrong.append(f"exit code {how.code}, said: {how.said.strip()[-600:]!r}")
    if how.code == 0 and how.said.strip():
        wrong.append(f"finished, but said: {how.said.strip()[-300:]!r}")
    try:
        kill.whole(disk)
    except (AssertionError, OSError, ValueError, KeyError) as error:
        wrong.append(f"a file is not whole ({error})")
    if left := leftovers(disk):
        wrong.append(f"left {left}")
    if mine.read_text() != "mine":
        wrong.append("the file of the user has changed")
    return wrong


def readonly(kind: str, inside: Path, place: Path, _fills: int) -> tuple[str, list[str]]:
    """Places in which nothing can be written, empty and with a finished job in them."""
    wrong: list[str] = []
    trials = 0
    with memory_disk(place / "disk", 1 << 29) as disk:
        empty, there = disk / "empty", disk / "there"
        empty.mkdir()
        must(ended(line_of(kind, inside, there)))
        before = prints(disk)
        targets = [(empty, []), (disk / "new", []), (there, []), (there, ["--force"])]
        if kind == "export":
            targets = targets[:2]
        if kind in RESUMABLE:
            targets.append((there, ["--resume"]))
        for how_closed in ("mounted read-only", "immutable"):
            with closed(disk, how_closed):
                for folder, options in targets:
                    how = ended([*line_of(kind, inside, folder), *options])
                    trials += 1
                    name = f"{kind}, {folder.name} {' '.join(options)} {how_closed}"
                    finished = options == ["--resume"] and how.code == 0  # nothing was to be done
                    if not how.clean and not finished:
                        wrong.append(f"{name}: exit code {how.code}, {how.said.strip()[-500:]!r}")
                    if prints(disk) != before:
                        wrong.append(f"{name}: files have changed")
    return f"{trials} trials, each ended with one line, nothing changed", wrong


@contextlib.contextmanager
def closed(disk: Path, how: str) -> Iterator[None]:
    """Make everything below a folder impossible to write, even for root."""
    if how == "immutable":
        folders = [disk, *(path for path in disk.rglob("*"))]
        subprocess.run(["chattr", "+i", *map(str, folders)], check=True)  # noqa: S603, S607
        try:
            yield
        finally:
            subprocess.run(["chattr", "-i", *map(str, folders)], check=True)  # noqa: S603, S607
        return
    mount("-o", "remount,ro", str(disk))
    try:
        yield
    finally:
        mount("-o", "remount,rw", str(disk))


def clock(kind: str, inside: Path, place: Path, _fills: int) -> tuple[str, list[str]]:
    """The clock jumps while the job runs; then it is cut off, jumps again, and goes on."""
    library = place / "clock.so"
    source = place / "clock.c"
    source.write_text(SHIM)
    subprocess.run(["cc", "-shared", "-fPIC", "-o", str(library), str(source), "-ldl"], check=True)  # noqa: S603, S607
    whole = place / "whole"
    began = time.monotonic()
    must(program(line_of(kind, inside, whole)))
    took = time.monotonic() - began
    wanted = found(kind, whole)
    wrong: list[str] = []
    for name, seconds in JUMPS.items():
        folder = place / name.replace(" ", "-")
        turned = place / "clock"
        turned.write_text("0\n")
        environment = {"LD_PRELOAD": str(library), "TRIAL_CLOCK": str(turned)}
        jump = threading.Timer(0.6 * took, turn, (turned, folder, seconds))
        jump.start()
        how = program(line_of(kind, inside, folder), environment)
        jump.join()
        if how.code != 0 or how.said.strip():
            wrong.append(f"{kind}, {name}: exit code {how.code}, {how.said.strip()[-500:]!r}")
        elif found(kind, folder) != wanted:
            wrong.append(f"{kind}, {name}: another result")
    return f"{len(JUMPS)} jumps in a job of {took:.1f} s, all results the same", wrong


def turn(clock_file: Path, folder: Path, seconds: int) -> None:
    """Turn the clock of a job; its files now have the times that they had by the old clock."""
    beside = clock_file.with_suffix(".new")
    beside.write_text(f"{seconds}\n")
    beside.replace(clock_file)
    for file in folder.rglob("*"):
        with contextlib.suppress(OSError):  # renamed meanwhile
            when = file.stat().st_mtime - seconds
            os.utime(file, (when, when))


def program(line: list[str], environment: dict[str, str] | None = None) -> Ended:
    """Run a command as a program of its own."""
    done = subprocess.run(  # noqa: S603
        [sys.executable, "-m", "sheetmorph", *line],
        env={**os.environ, **(environment or {})},
        capture_output=True,
        text=True,
        timeout=PATIENCE,
        check=False,
    )
    return Ended(done.returncode, done.stderr)


def main() -> int:
    """Run the chosen trials."""
    parser = argparse.ArgumentParser(description=__doc__)
    kinds = {"full": full, "readonly": readonly, "clock": clock}
    parser.add_argument("troubles", nargs="+", choices=kinds)
    parser.add_argument("--jobs", nargs="+", choices=JOBS, default=JOBS)
    parser.add_argument("--fills", type=int, default=12, help="rooms between none and all")
    chosen = parser.parse_args()
    if os.geteuid() != 0 and set(chosen.troubles) != {"clock"}:
        raise SystemExit("full and readonly mount file systems: run this as root")
    failed = False
    with tempfile.TemporaryDirectory() as name:
        inputs(Path(name))
        for trouble in chosen.troubles:
            for kind in chosen.jobs:
                if trouble == "clock" and kind not in CLOCKED:
                    continue
                with tempfile.TemporaryDirectory() as place:
                    told, wrong = kinds[trouble](kind, Path(name), Path(place), chosen.fills)
                for one in wrong:
                    print(f"  {one}", flush=True)
                print(f"{trouble} {kind}: " + (f"{len(wrong)} wrong; " if wrong else "") + told)
                sys.stdout.flush()
                failed = failed or bool(wrong)
    return int(failed)


if __name__ == "__main__":
    sys.exit(main())
