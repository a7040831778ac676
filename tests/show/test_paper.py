"""The page of the redone paper carries all it needs; its figures are drawn."""

from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from sheetmorph.core.errors import InputError
from sheetmorph.paper.redo import Paper, redo_paper
from sheetmorph.paper.rows import Bare, Curve, CurveFigure, MapFigure, ShapeFigure
from sheetmorph.paper.runs import Outcomes, Run, Setting, perform
from sheetmorph.show import style
from sheetmorph.show.paper import check_paper_folder, value_text, write_paper
from sheetmorph.show.paper_figures import draw_figure
from sheetmorph.show.render import RenderWorker


@pytest.fixture(scope="module")
def small_paper() -> Paper:
    sections = ["thermal", "constants", "elements"]
    return redo_paper(Setting(coarsen=2.5), only=sections, workers=1)


@pytest.fixture(scope="module")
def page(small_paper: Paper, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("paper")
    with RenderWorker("drawn", (), 1.0) as worker:
        path, notes = write_paper(small_paper, folder / "report", worker, started=0.0)
    assert notes == []
    return path


def test_the_page_refers_to_nothing_outside_itself(page: Path) -> None:
    text = page.read_text("utf-8")
    assert len(text) < 15e6
    sources = re.findall(r'(?:src|srcset)="([^"]{0,40})', text)
    assert len(sources) == 2
    assert all(source.startswith("data:image/png;base64,") for source in sources)
    assert "http" not in re.sub(r"http-equiv", "", text)
    assert "<script" not in text
    links = re.findall(r'href="([^"]*)"', text)
    assert links
    assert all(link.startswith("#") for link in links)
    targets = re.findall(r'id="([^"]*)"', text)
    assert len(set(targets)) == len(targets)
    assert {link[1:] for link in links} <= set(targets)


def test_the_page_says_what_it_was_made_of(page: Path, small_paper: Paper) -> None:
    text = page.read_text("utf-8")
    assert "meshes made here, not the paper" in text
    assert "Processor seconds" in text
    assert "{{" not in text
    assert text.count('id="row-') == len(small_paper.rows)


def test_the_numbers_lie_beside_it(page: Path, small_paper: Paper) -> None:
    text = (page.parent / "paper.json").read_text("utf-8")
    data = json.loads(text, parse_constant=lambda name: pytest.fail(f"{name} in JSON"))
    assert sum(data["verdicts"].values()) == len(data["rows"]) == len(small_paper.rows)
    assert data["drawing_seconds"] >= 0
    assert sorted(p.name for p in page.parent.iterdir()) == ["paper.html", "paper.json"]


def test_reports_are_replaced_by_force_alone(page: Path, tmp_path: Path) -> None:
    with pytest.raises(InputError, match="--force"):
        check_paper_folder(page.parent)
    check_paper_folder(page.parent, force=True)
    check_paper_folder(tmp_path / "new")
    (tmp_path / "paper.html").write_text("my own")
    with pytest.raises(InputError, match="no report wrote it"):
        check_paper_folder(tmp_path, force=True)
    (tmp_path / "paper.json").write_text("[" * 100_000)
    with pytest.raises(InputError, match="no report wrote it"):
        check_paper_folder(tmp_path, force=True)
    with pytest.raises(InputError, match="is a file"):
        check_paper_folder(tmp_path / "paper.html")


@pytest.fixture(scope="module")
def outcomes() -> Outcomes:
    setting = Setting(coarsen=2.5)
    runs = [Run.of("petals", {"actuation.eps_pre": eps}) for eps in (-0.1, -0.4)]
    return {run: perform(run, setting) for run in runs}


def test_shapes_stand_side_by_side(outcomes: Outcomes, tmp_path: Path) -> None:
    mild, strong = outcomes
    corner = np.array([[0, 0, 0], [0.1, 0, 0], [0, 0.1, 0.05], [0.1, 0.1, 0.0]])
    bare = Bare(corner, np.array([[0, 1, 2], [1, 3, 2]], dtype=np.int32))
    columns = (("mild", mild), ("strong", strong), ("scan", bare))
    figure = ShapeFigure("all", "", columns, ("shape", "angle", "strain", "top"), across=2)
    path = tmp_path / "shapes.png"
    with style.style(), RenderWorker("drawn", (), 1.0) as worker:
        draw_figure(figure, outcomes, worker, path)
    with Image.open(path) as image:
        pixels = np.asarray(image.convert("RGB"))
    assert pixels.shape[1] == 44 + 2 * 300 + 130
    # Two bands of four rows each; the last place of the second band is empty.
    half = pixels.shape[0] // 2
    assert (pixels[half + 60 : -20, 44 + 310 : -140] == 255).all()
    assert (pixels[half + 60 : -20, 60:340] != 255).any()
    assert (pixels[60:half, 44 + 310 : -140] != 255).any()


def test_diagrams_and_maps_are_drawn(outcomes: Outcomes, tmp_path: Path) -> None:
    x = np.linspace(0, -0.5, 20)
    curves = (
        Curve("line", x, x**2),
        Curve("dots", x[::4], x[::4] ** 2, "dots"),
        Curve("dashed", x, -x, "dashed"),
    )
    diagram = CurveFigure("d", "", "ε_pre", "h/d", curves, ((0.2, "stated"),))
    ramp = np.tile(np.linspace(0, 1, 64)[:, None], (1, 64))
    field = MapFigure("m", "", (("one", ramp), ("other", 1 - ramp)), (0.0, 1.0), "SSIM")
    with style.style(), RenderWorker("drawn", (), 1.0) as worker:
        for figure in (diagram, field):
            path = draw_figure(figure, outcomes, worker, tmp_path / f"{figure.name}.png")
            with Image.open(path) as image:
                colours = np.unique(np.asarray(image.convert("RGB")).reshape(-1, 3), axis=0)
            assert len(colours) > 20
    with Image.open(tmp_path / "m.png") as image:
        pixels = np.asarray(image.convert("RGB")).astype(int)
    # x grows to the right: dark (0) at the left of the first map, bright (1) at its right.
    middle = pixels[pixels.shape[0] // 2]
    assert middle[48].sum() < middle[44 + 370].sum()


@pytest.mark.parametrize(
    ("value", "unit", "text"),
    [
        (None, "", "–"),
        ("words", "s", "words"),
        (-0.5, "", "−0.5"),
        (420.0, "s", "420 s"),
        (0.86286, "", "0.8629"),
        (2.2893e-6, "1/Pa", "2.29 · 10⁻⁶ 1/Pa"),
        (0.0, "m", "0 m"),
        (1e-14, "m⁴", "10⁻¹⁴ m⁴"),
    ],
)
def test_numbers_as_text(value: float | str | None, unit: str, text: str) -> None:
    assert value_text(value, unit) == text
