"""How long the studio takes from a changed parameter to the new shape on the screen.

    .venv/bin/python benchmarks/studio.py [--preset bowl] [--changes 20]

Starts a studio and headless Chromium, changes the half-width of the arms again and again, and
takes the time, inside the page, from the event of the field to the end of the frame in which
WebGL has drawn the full mesh (not the preview). Wants Chromium and the packages of `dev`.
Printed besides: the share of the solver as the studio tells it, and the processor time of the
workers per change, which does not depend on what else the machine does.
"""

from __future__ import annotations

import argparse
import os
import shutil
import statistics
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

import psutil

ROOT = Path(__file__).resolve().parents[1]
sys.path[:0] = [str(ROOT / "tests" / room) for room in ("studio", "study")]

from driving import start_studio, stop_studio
from playwright.sync_api import expect, sync_playwright

from sheetmorph.design.presets import preset_text

CHROMIUM = os.environ.get("SHEETMORPH_CHROMIUM") or shutil.which("chromium") or "chromium"
FLAGS = (
    *("--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run"),
    *("--disable-background-networking", "--disable-component-update", "--disable-sync"),
    *("--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"),
)
WATCH = """async () => {
  const { shown } = await import("/page/view.js");
  const { on } = await import("/page/wire.js");
  let due = null;
  on("scene", (head) => {
    if (!head.preview && window.begun) due = [window.begun, head.numbers.seconds];
  });
  on("drawn", () => {
    if (!due) return;
    window.times.push([performance.now() - due[0], 1000 * due[1]]);
    due = window.begun = null;
  });
  window.times = [];
}"""
CHANGE = """(value) => {
  const field = document.querySelector('#groups [data-key="pattern.0.half_width"]');
  field.value = value;
  window.begun = performance.now();
  field.dispatchEvent(new Event("change"));
}"""


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--preset", default="bowl")
    parser.add_argument("--changes", type=int, default=20)
    asked = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder, sync_playwright() as playwright:
        studio = start_studio(Path(folder), text=preset_text(asked.preset))
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=list(FLAGS))
        try:
            page = browser.new_page(viewport={"width": 1280, "height": 720})
            page.goto(studio.address)
            expect(page.locator("#state")).to_have_text("solved", timeout=60_000)
            page.evaluate(WATCH)
            before = float(page.locator('#groups [data-key="pattern.0.half_width"]').input_value())
            change(page, before * 1.001)  # a preview comes before the first: the second is timed
            page.evaluate("() => { window.times.length = 0; }")
            began = spent(studio)
            for k in range(asked.changes):
                change(
                    page, round(before * (0.9 + 0.2 * ((7 * k) % asked.changes) / asked.changes), 4)
                )
            used = (spent(studio) - began) / asked.changes
            report(asked.preset, page.evaluate("() => window.times"), used)
        finally:
            browser.close()
            stop_studio(studio)


def change(page: Any, value: float) -> None:
    """Set the half-width of the arms [mm] and wait until its shape is drawn."""
    count = page.evaluate("() => window.times.length")
    page.evaluate(CHANGE, value)
    deadline = time.monotonic() + 60
    while page.evaluate("() => window.times.length") == count:
        assert time.monotonic() < deadline, page.locator("#lines").inner_text()
        time.sleep(0.005)


def spent(studio: Any) -> float:
    """Processor time of server and workers so far [s]."""
    server = psutil.Process(studio.process.pid)
    times = [process.cpu_times() for process in (server, *server.children())]
    return sum(one.user + one.system for one in times)


def report(preset: str, times: list[list[float]], used: float) -> None:
    """Print the numbers."""
    whole, solver = ([row[k] for row in times] for k in (0, 1))
    quartiles = statistics.quantiles(whole, n=4)
    print(f"{preset}: {len(times)} changes of the half-width of the arms, full mesh")
    print(
        f"  change to shape on screen  median {statistics.median(whole):.0f} ms, "
        f"quartiles {quartiles[0]:.0f} and {quartiles[2]:.0f} ms, longest {max(whole):.0f} ms"
    )
    print(
        f"  of which in the worker     median {statistics.median(solver):.0f} ms "
        "(reading, meshing, solving, fields)"
    )
    print(f"  processor time per change  {1000 * used:.0f} ms in server and workers")


if __name__ == "__main__":
    main()
