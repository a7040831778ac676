"""The view of a result in a notebook: a page by itself that a browser shows without a network."""

from __future__ import annotations

import base64
import gzip
import html
import json
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import sheetmorph as sm
from sheetmorph.core.errors import InputError, OutputError
from sheetmorph.studio import bundle, notebook
from sheetmorph.studio.frames import arrays_of, head_of

pytest.importorskip("nicegui", reason="NiceGUI is not installed")

PETALS = Path(__file__).resolve().parents[2] / "examples" / "gallery" / "petals.toml"


@pytest.fixture(scope="module")
def result() -> sm.Result:
    design = sm.Design.load(PETALS)
    return sm.simulate(design.with_values({"mesh.size": "9 mm", "actuation.eps_pre": -0.3}))


def hidden(page: str, name: str) -> bytes:
    """What the page carries under a name."""
    found = re.search(rf'id="{name}">([\w+/=]+)<', page)
    assert found
    return gzip.decompress(base64.b64decode(found[1]))


def test_the_page_holds_the_result_and_every_script_in_order(result: sm.Result) -> None:
    page = result.show(field="mean").page
    packet = hidden(page, "packet")
    positions = arrays_of(packet)["positions"]
    assert np.allclose(positions[-1], 1e3 * result.positions[-1], rtol=0, atol=1e-4)
    assert head_of(packet)["numbers"]["status"] == "completed"
    seen: set[str] = set()
    for name, text in json.loads(hidden(page, "modules")):
        assert set(re.findall(r'from\s*"\./([\w.]+)"', text)) <= seen, name
        seen.add(name)
    assert {"three.js", "view.js", "notebook.js"} <= seen
    assert result.show().page == result.show().page  # the same bytes every time


def test_nothing_is_loaded_from_elsewhere(result: sm.Result) -> None:
    page = result.show().page
    assert not re.findall(r'(?:src|href)="|@import|url\(', page)
    assert len(page) < 1_000_000


def test_the_cell_holds_the_page_in_a_frame_of_the_wanted_height(result: sm.Result) -> None:
    shown = result.show(height=300)
    cell = shown._repr_html_()
    source = re.search(r'srcdoc="([^"]*)"', cell)
    assert source and html.unescape(source[1]) == shown.page
    assert "height: 300px" in cell and "MB" in repr(shown)


def test_a_view_is_saved_as_a_file(result: sm.Result, tmp_path: Path) -> None:
    path = result.show().save(tmp_path / "view.html")
    assert path.read_text("utf-8").startswith("<!doctype html>")
    with pytest.raises(OutputError):
        result.show().save(path / "view.html")  # a file is no folder


@pytest.mark.parametrize(
    ("options", "told"),
    [
        ({"field": "heigth"}, "did you mean height"),
        ({"height": 20}, "200 to 2000"),
        ({"theme": "blue"}, "light, dark"),
    ],
)
def test_wrong_arguments_are_told(result: sm.Result, options: dict[str, Any], told: str) -> None:
    with pytest.raises(InputError, match=told):
        notebook.view(result, **options)


def test_without_the_packages_of_the_studio_it_says_what_to_install(
    result: sm.Result, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(bundle, "find_spec", lambda name: None)
    with pytest.raises(InputError, match=r"pip install \"sheetmorph\[studio\]\""):
        result.show()


def test_a_browser_shows_it_and_scrubs(result: sm.Result, chromium: Any, tmp_path: Path) -> None:
    cell = tmp_path / "cell.html"
    cell.write_text(f"<p>before</p>{result.show(height=420)._repr_html_()}", "utf-8")
    context = chromium.new_context(viewport={"width": 900, "height": 520}, offline=True)
    page = context.new_page()
    errors: list[str] = []
    page.on("pageerror", lambda error: errors.append(str(error)))
    page.on("console", lambda line: line.type == "error" and errors.append(line.text))
    page.goto(cell.as_uri())
    frame = page.frame_locator("iframe")
    frame.locator("#state", has_text="completed").wait_for(timeout=20_000)
    frame.locator("#at", has_text="free strain −0.3").wait_for()
    final = frame.locator("#canvas").screenshot()
    frame.locator("#scrub").fill("0")
    frame.locator("#at", has_text="h/d 0").wait_for()
    flat = frame.locator("#canvas").screenshot()
    assert flat != final
    frame.locator("#field").select_option("height")
    frame.locator("#legend", has_text="Height z").wait_for()
    frame.locator("#play").click()
    frame.locator("#at", has_text="free strain −0.3").wait_for(timeout=10_000)
    frame.locator("#play", has_text="▶").wait_for()
    assert frame.locator("#canvas").screenshot() != final  # the same shape in other colours
    assert errors == []
    context.close()
