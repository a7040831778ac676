"""Whether the studio stays healthy: many tabs, many changes, browsers that vanish.

    .venv/bin/python benchmarks/studio_soak.py [--tabs 20] [--changes 1000]

Opens tabs (as a browser does, by their sockets), warms up with a tenth of the changes, then makes
random changes of parameters in random tabs, some of them broken off in the middle of a solve.
Prints the memory (RSS) of the server and of its workers after the warm-up and at the end, and
fails when either has grown by more than a tenth.
"""

from __future__ import annotations

import argparse
import random
import sys
import tempfile
import time
from pathlib import Path

import psutil

ROOT = Path(__file__).resolve().parents[1]
sys.path[:0] = [str(ROOT / "tests" / room) for room in ("studio", "study")]

from driving import Running, Tab, open_tab, start_studio, stop_studio

ALLOWED = 0.10


def main() -> None:
    """Run and print."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--tabs", type=int, default=20)
    parser.add_argument("--changes", type=int, default=1000)
    asked = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        studio = start_studio(Path(folder))
        try:
            grown = soak(studio, asked.tabs, asked.changes, say=print)
        finally:
            stop_studio(studio)
    assert grown <= ALLOWED, f"memory has grown by {grown:.0%}"


def soak(studio: Running, tabs: int, changes: int, seed: int = 0, say=lambda text: None) -> float:  # type: ignore[no-untyped-def]
    """Make random changes in many tabs; the larger growth of memory of server and workers."""
    rng = random.Random(seed)  # noqa: S311
    opened = [open_tab(studio) for _ in range(tabs)]
    for tab in opened:
        tab.solved()
    began = time.monotonic()
    warm = max(changes // 10, 2 * tabs)
    broken = sum(change(studio, opened, rng) for _ in range(warm))
    before = memory(studio)
    broken += sum(change(studio, opened, rng) for _ in range(changes))
    after = memory(studio)
    for tab in opened:
        tab.socket.close()
    growth = [late / early - 1.0 for early, late in zip(before, after, strict=True)]
    say(
        f"{tabs} tabs, {warm} changes to warm up, then {changes}, {broken} broken off in the middle"
    )
    for what, early, late, more in zip(("server", "worker"), before, after, growth, strict=True):
        say(f"  {what}  {early / 2**20:.0f} MiB, then {late / 2**20:.0f} MiB ({more:+.1%})")
    say(f"  {time.monotonic() - began:.0f} s")
    return max(growth)


def change(studio: Running, tabs: list[Tab], rng: random.Random) -> bool:
    """Change something in one of the tabs; True where its connection was cut in the middle."""
    place = rng.randrange(len(tabs))
    tab = tabs[place]
    tab.seen.clear()
    key, low, high, unit = rng.choice(
        [
            ("pattern.0.half_width", 2.4, 4.0, " mm"),
            ("pattern.0.arm_length", 12.0, 18.0, " mm"),
            ("actuation.eps_pre", -0.45, -0.2, ""),
            ("layers.1.thickness", 0.5, 0.9, " mm"),
        ]
    )
    value = rng.uniform(low, high)
    tab.order(
        "edit", values={key: f"{value:.4f}{unit}" if unit else value}, drag=rng.random() < 0.3
    )
    if rng.random() < 0.05:
        tab.socket.socket.close()
        tabs[place] = open_tab(studio)
        tabs[place].solved()
        return True
    tab.wait("settled", 300)
    return False


def memory(studio: Running) -> tuple[int, int]:
    """Resident memory of the server, and of its workers together [bytes]."""
    server = psutil.Process(studio.process.pid)
    workers = [psutil.Process(pid) for pid in studio.children()]
    return server.memory_info().rss, sum(worker.memory_info().rss for worker in workers)


if __name__ == "__main__":
    main()
