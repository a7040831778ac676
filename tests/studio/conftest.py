"""A studio in a process of its own, and a browser where there is one."""

from __future__ import annotations

import os
import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from driving import Running, Tab, open_tab, start_studio, stop_studio

CHROMIUM = os.environ.get("SHEETMORPH_CHROMIUM") or shutil.which("chromium") or "/usr/bin/chromium"
FLAGS = (
    *("--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run"),
    *("--disable-background-networking", "--disable-component-update", "--disable-sync"),
    *("--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"),
)


@pytest.fixture(scope="session")
def studio(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Running]:
    """A studio with the small design, for all tests of a process."""
    running = start_studio(tmp_path_factory.mktemp("studio"))
    yield running
    code, errors = stop_studio(running)
    assert (code, errors.strip()) in ((0, ""), (130, "sheetmorph: interrupted"))


@pytest.fixture
def tab(studio: Running) -> Iterator[Tab]:
    """A tab that shows the small design."""
    opened = open_tab(studio)
    opened.wait("hello")
    opened.solved()
    opened.seen.clear()
    yield opened
    opened.socket.close()


@pytest.fixture(scope="module")
def chromium() -> Iterator[Any]:
    """Chromium; tests are skipped where it is missing.

    Not longer than a module: Playwright keeps an event loop in this thread, beside which no other
    test could start one.
    """
    from playwright.sync_api import sync_playwright

    if not Path(CHROMIUM).exists():
        pytest.skip(f"no Chromium at {CHROMIUM} (set SHEETMORPH_CHROMIUM)")
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=list(FLAGS))
        yield browser
        browser.close()


@pytest.fixture
def chromium_command(tmp_path: Path) -> list[str]:
    """Chromium as a program of its own, that may be killed."""
    if not Path(CHROMIUM).exists():
        pytest.skip(f"no Chromium at {CHROMIUM} (set SHEETMORPH_CHROMIUM)")
    return [CHROMIUM, *FLAGS, "--remote-debugging-port=0", f"--user-data-dir={tmp_path / 'user'}"]
