"""The page in a real browser: the main stories, from the first look to a file in hand.

What was seen is left in results/studio-screenshots.
"""

from __future__ import annotations

import json
import zipfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh
from driving import SHOTS, Running, open_tab

import sheetmorph as sm

playwright = pytest.importorskip("playwright.sync_api", reason="Playwright is not installed")
expect = playwright.expect
expect.set_options(timeout=15_000)

PATIENCE = 90_000
Open = Callable[..., Any]


@pytest.fixture
def open_page(chromium: Any, studio: Running) -> Iterator[Open]:
    """Opens pages of the studio; a script error or a broken request fails the test."""
    contexts, wrong = [], []

    def opened(address: str = studio.address, **options: Any) -> Any:
        context = chromium.new_context(viewport={"width": 1280, "height": 720}, **options)
        contexts.append(context)
        page = context.new_page()
        page.set_default_timeout(PATIENCE)
        page.on("pageerror", lambda error: wrong.append(str(error)))
        page.on("request", lambda request: _own(request.url, address, wrong))
        page.goto(address)
        expect(page.locator("#state")).to_have_text("solved", timeout=PATIENCE)
        return page

    yield opened
    for context in contexts:
        context.close()
    assert wrong == []


def _own(url: str, address: str, wrong: list[str]) -> None:
    """The page asks nobody but its server."""
    if not url.startswith((address.split("?")[0], "blob:", "data:", "ws://127.0.0.1")):
        wrong.append(f"asked {url}")


def ratio(page: Any) -> float:
    """h/d as the page shows it."""
    text = page.locator("#numbers .lead dd").inner_text()
    return float(text.removeprefix("≈ "))


def pixels(page: Any) -> np.ndarray:  # type: ignore[type-arg]
    """What the canvas shows."""
    from io import BytesIO

    from PIL import Image

    shot = page.locator("#canvas").screenshot()
    return np.asarray(Image.open(BytesIO(shot)).convert("RGB"), dtype=float)


def shot(page: Any, name: str) -> None:
    SHOTS.mkdir(parents=True, exist_ok=True)
    page.screenshot(path=SHOTS / f"{name}.png")


def change(page: Any, key: str, value: str) -> None:
    field = page.locator(f'#groups [data-key="{key}"]').first
    field.fill(value)
    field.press("Enter")


@contextmanager
def resolved(page: Any) -> Iterator[None]:
    """Do something that is answered by another shape, and wait for it."""
    state = page.locator("#state")
    before = state.get_attribute("data-solved")
    yield
    expect(state).not_to_have_attribute("data-solved", str(before), timeout=PATIENCE)
    expect(state).to_have_text("solved", timeout=PATIENCE)


def listed(card: Any) -> dict[str, str]:
    """The numbers of a card by their labels."""
    labels, texts = (card.locator(tag).all_inner_texts() for tag in ("dt", "dd"))
    return dict(zip(labels, texts, strict=True))


def test_from_preset_to_a_valid_file(open_page: Open, tmp_path: Path) -> None:
    page = open_page()
    page.click("#presets")
    page.get_by_role("button", name="Petals").wait_for()
    shot(page, "presets")
    with resolved(page):
        page.get_by_role("button", name="Petals").click()
    expect(page.locator("#name")).to_have_text("petals")
    before, image = ratio(page), pixels(page)
    shot(page, "petals")

    with resolved(page):
        change(page, "pattern.0.half_width", "9")  # wider arms
    assert ratio(page) != before
    assert np.abs(pixels(page) - image).mean() > 1.0  # another shape is on the canvas
    wide = ratio(page)

    page.locator("#scrub").fill("0")
    expect(page.locator("#at")).to_contain_text("h/d 0")
    flat = pixels(page)
    page.locator("#scrub").fill("1")
    assert np.abs(pixels(page) - flat).mean() > 1.0

    page.click("#export")
    page.uncheck("#what-parts")
    page.click("#dialog-buttons .primary")
    with page.expect_download(timeout=120_000) as pending:
        page.locator("#zip").click(timeout=120_000)
    shot(page, "exported")
    file = tmp_path / "petals.zip"
    pending.value.save_as(file)
    assert pending.value.suggested_filename == "petals.zip"
    with zipfile.ZipFile(file) as archive:
        assert archive.testzip() is None
        archive.extractall(tmp_path)
    folder = tmp_path / "petals"
    result = sm.Result.load(folder / "run")
    assert result.design.pattern[0].half_width == 9e-3  # type: ignore[union-attr]
    assert result.summary["aspect_ratio"] == pytest.approx(wide, abs=6e-4)
    surface = trimesh.load_mesh(folder / "run" / "shape.stl")
    height = np.ptp(surface.vertices[:, 2])
    assert height == pytest.approx(result.summary["height_m"], rel=1e-4)
    assert sm.Design.load(folder / "petals.toml").hash == result.design.hash
    report = (folder / "run" / "report.html").read_text("utf-8")
    assert "petals" in report
    assert json.loads((folder / "run" / "summary.json").read_text("utf-8"))["stable"] is True


def test_dragging_a_handle_shows_previews_and_then_the_shape(open_page: Open) -> None:
    page = open_page()
    before = ratio(page)
    handle = page.locator('.handle[data-key="pattern.0.arm_length"]')
    box = handle.locator("circle").last.bounding_box()
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    page.mouse.move(x, y)
    page.mouse.down()
    for step in range(1, 6):
        page.mouse.move(x - 5 * step, y + 3)
        page.wait_for_timeout(60)
    shot(page, "dragging")
    with resolved(page):
        page.mouse.up()
    expect(page.locator("#undo")).to_be_enabled()
    length = float(page.locator('#groups [data-key="pattern.0.arm_length"]').input_value())
    assert 8.0 < length < 15.5
    assert ratio(page) != before
    with resolved(page):
        page.keyboard.press("Control+z")
    expect(page.locator('#groups [data-key="pattern.0.arm_length"]')).to_have_value("16")
    assert ratio(page) == before


def test_the_keyboard_alone_is_enough(open_page: Open) -> None:
    page = open_page()
    handle = page.get_by_role("slider", name="Star: half width")
    handle.focus()
    with resolved(page):
        for _ in range(2):
            page.keyboard.press("ArrowUp")
        expect(page.locator('#groups [data-key="pattern.0.half_width"]')).to_have_value("4")
    expect(page.locator(".handle:focus")).to_have_attribute("data-key", "pattern.0.half_width")
    page.locator("#canvas").focus()
    image = pixels(page)
    page.keyboard.press("ArrowLeft")
    page.wait_for_timeout(150)
    assert np.abs(pixels(page) - image).mean() > 0.5
    page.keyboard.press("d")
    expect(page.locator("#labels")).to_contain_text("h =")
    page.keyboard.press("?")
    expect(page.locator("#dialog")).to_contain_text("Ctrl S")
    page.keyboard.press("Escape")
    expect(page.locator("#dialog")).not_to_be_visible()


def test_measuring_clipping_and_playing(open_page: Open) -> None:
    page = open_page()
    page.click("#top")
    page.click("#measure")
    box = page.locator("#canvas").bounding_box()
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    for side in (-60, 60):
        page.mouse.click(x + side, y)
    label = page.locator("#labels span")
    expect(label).to_contain_text("mm")
    assert 3.0 < float(label.inner_text().split()[0]) < 40.0
    page.click("#measure")
    expect(label).to_have_count(0)
    page.click("#home")
    whole = pixels(page)
    page.locator("#clip").select_option("x")
    assert np.abs(pixels(page) - whole).mean() > 1.0
    page.locator("#clip").select_option("")
    page.click("#play")
    expect(page.locator("#play")).to_have_attribute("aria-label", "Stop")
    expect(page.locator("#play")).to_have_attribute("aria-label", "Play the actuation")
    expect(page.locator("#scrub")).to_have_value("1")


def test_everything_that_acts_has_a_name(open_page: Open) -> None:
    page = open_page()
    nameless = page.evaluate(
        """() => [...document.querySelectorAll('button, select, input, canvas, [role=slider], svg')]
        .filter((e) => !e.hidden && !e.closest('[hidden]') && e.type !== 'hidden')
        .filter((e) => !(e.getAttribute('aria-label') || e.labels?.length || e.textContent.trim()))
        .map((e) => e.outerHTML.slice(0, 80))"""
    )
    assert nameless == []
    heads = page.evaluate("() => [document.documentElement.lang, document.title]")
    assert heads == ["en", "small – sheetmorph studio"]


def test_wrong_values_and_broken_drawings_are_told(open_page: Open, tmp_path: Path) -> None:
    page = open_page()
    change(page, "pattern.0.half_width", "-3")
    row = page.locator('.row:has([data-key="pattern.0.half_width"])')
    expect(row.locator(".why")).to_contain_text("out of range")
    shot(page, "wrong-value")
    with resolved(page):
        change(page, "pattern.0.half_width", "3.5")
    expect(row.locator(".why")).to_have_count(0)
    broken = tmp_path / "broken.svg"
    broken.write_text("<svg><path d='M 0 0 L", encoding="utf-8")
    page.set_input_files("#picker", broken)
    expect(page.locator("#toast")).to_contain_text("damaged", timeout=PATIENCE)
    shot(page, "broken-drawing")
    page.set_input_files("#picker", files=[{"name": "x.exe", "mimeType": "", "buffer": b"MZ"}])
    expect(page.locator("#toast")).to_contain_text("nothing that the studio reads")
    expect(page.locator("#state")).to_have_text("solved")


def test_a_drawing_becomes_sheet_and_pattern(open_page: Open) -> None:
    page = open_page()
    drawing = """<svg xmlns="http://www.w3.org/2000/svg" width="60mm" height="40mm"
        viewBox="0 0 60 40"><ellipse id="sheet" cx="30" cy="20" rx="28" ry="18" fill="none"
        stroke="black" stroke-width="0.1"/><g id="pattern"><rect x="8" y="17" width="44"
        height="6"/><rect x="27" y="6" width="6" height="28"/></g></svg>"""
    entry = {"name": "../../cross.svg", "mimeType": "image/svg+xml", "buffer": drawing.encode()}
    page.set_input_files("#picker", files=[entry])
    expect(page.locator("#role-sheet")).to_have_value("sheet", timeout=PATIENCE)
    expect(page.locator("#role-pattern")).to_have_value("pattern")
    shot(page, "drawing")
    with resolved(page):
        page.click("#dialog-buttons .primary")
    expect(page.locator("#groups")).to_contain_text("Sheet: Polygon")
    assert page.locator("#numbers").inner_text().count("stable") == 1
    shot(page, "from-drawing")


def test_a_scan_is_laid_over_the_shape(
    open_page: Open, tmp_path: Path, small_result: sm.Result
) -> None:
    from sheetmorph.geometry.writers import write_stl

    file = tmp_path / "scan.stl"
    turned = small_result.positions[-1] @ np.array([[0, -1, 0], [1, 0, 0], [0, 0, 1.0]]) * 1.01
    write_stl(file, small_result.mesh.triangles, 1e3 * (turned + 0.02))
    page = open_page(color_scheme="dark")
    page.set_input_files("#picker", file)
    page.locator("#scan-unit").select_option("mm")
    card = page.locator("#scan")
    with resolved(page):
        page.click("#dialog-buttons .primary")
        expect(card).to_be_visible(timeout=PATIENCE)
    numbers = listed(card)
    assert float(numbers["SSIM when compared"]) > 0.9
    assert float(numbers["now: r.m.s. distance"].split()[0]) < 0.3
    expect(page.locator("#field")).to_have_value("scan")
    expect(page.locator("#legend")).to_contain_text("Distance to scan")
    shot(page, "scan-dark")
    close = float(numbers["now: r.m.s. distance"].split()[0])
    with resolved(page):
        change(page, "actuation.eps_pre", "-0.2")
    after = listed(card)
    assert float(after["now: r.m.s. distance"].split()[0]) > 2 * close


def test_two_tabs_and_both_themes(open_page: Open) -> None:
    light, dark = open_page(color_scheme="light"), open_page(color_scheme="dark")
    for name, page in (("light", light), ("dark", dark)):
        assert page.evaluate("() => document.documentElement.dataset.theme") == name
    with resolved(light):
        change(light, "actuation.eps_pre", "-0.2")
    assert ratio(light) != ratio(dark)
    expect(dark.locator('#groups [data-key="actuation.eps_pre"]')).to_have_value("-0.4")
    for name, page in (("light", light), ("dark", dark)):
        for field in ("angle", "strain"):
            page.locator("#field").select_option(field)
            expect(page.locator("#legend")).to_contain_text("[")
        page.locator("#layout").select_option("over")
        page.click("#sizes")
        page.locator("#clip").select_option("x")
        expect(page.locator("#cut")).to_be_visible()
        shot(page, f"fields-{name}")
        wide = page.evaluate("() => [document.body.scrollWidth, document.body.scrollHeight]")
        assert wide == [1280, 720]
    dark.click("#theme")
    assert dark.evaluate("() => document.documentElement.dataset.theme") == "light"


def test_up_and_down_bend_opposite_ways(open_page: Open) -> None:
    page = open_page()
    page.click("#presets")
    with resolved(page):
        page.get_by_role("button", name="Petals").click()
    expect(page.locator("#name")).to_have_text("petals")
    page.locator("#field").select_option("height")
    ends = page.locator("#legend li")
    assert float(ends.first.inner_text()) > 40.0
    with resolved(page):
        page.click("#down")
    expect(page.locator("#down")).to_have_attribute("aria-pressed", "true")
    assert float(ends.last.inner_text().replace("−", "-")) < -40.0


def test_a_tab_whose_server_forgot_it_brings_its_design(open_page: Open, studio: Running) -> None:
    """As after a restart of the studio: the name of the tab is new to the server."""
    page = open_page()
    with resolved(page):
        change(page, "actuation.eps_pre", "-0.25")
    name = page.evaluate("() => sessionStorage.getItem('tab')")
    with resolved(page):
        thief = open_tab(studio, name)
    assert page.evaluate("() => sessionStorage.getItem('tab')") != name
    field = page.locator('#groups [data-key="actuation.eps_pre"]')
    expect(field).to_have_value("-0.25", timeout=PATIENCE)
    thief.socket.close()
