"""Plots of a sweep show what is in its table."""

from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np
import pytest
from many import STARS, written
from PIL import Image

import sheetmorph as sm
from sheetmorph.show import sweep_columns
from sheetmorph.show.render import RenderWorker
from sheetmorph.show.sweep_columns import read_column
from sheetmorph.show.sweep_parallel import usual_columns, write_parallel
from sheetmorph.show.sweep_scatter import draw_scatter
from sheetmorph.show.sweep_shapes import draw_shapes
from sheetmorph.sweep.dataset import Sweep
from sheetmorph.sweep.plan import Plan
from sheetmorph.sweep.states import write_states
from sheetmorph.sweep.table import write_table
from sheetmorph.sweep.task import solve

MIXED = STARS.replace('["0.5 mm", "0.9 mm"]', '["0.5 mm", "0.9 mm", "-1 mm"]')


@pytest.fixture(scope="module")
def sweep(tmp_path_factory: pytest.TempPathFactory) -> Sweep:
    """Six designs, two of which are refused."""
    place = tmp_path_factory.mktemp("<b>sweep")
    plan = Plan.load(written(place, MIXED))
    outcomes = [solve(plan.task(k)) for k in range(6)]
    write_table(plan, lambda: (o.row for o in outcomes), place / "results.parquet", complete=True)
    arrays = ((k, o.arrays) for k, o in enumerate(outcomes))
    write_states(arrays, 6, plan.fingerprint, place / "states.h5")
    return Sweep.load(place)


def test_columns_are_scaled_and_labelled(sweep: Sweep) -> None:
    thickness = read_column(sweep, "layers.print.thickness")
    assert thickness.label == "layers.print.thickness  [mm]"
    assert thickness.values.tolist() == [0.5, 0.9, -1.0] * 2
    assert thickness.text(2) == "−1"
    status = read_column(sweep, "status")
    assert status.names == ("completed", "refused")
    assert status.text(5) == "refused"
    height = read_column(sweep, "aspect_ratio")
    assert np.isnan(height.values).tolist() == [False, False, True] * 2
    assert height.text(2) == "–"


@pytest.mark.parametrize("colour", [None, "layers.print.thickness", "status"])
def test_a_dot_stands_where_its_design_is(sweep: Sweep, tmp_path: Path, colour: str | None) -> None:
    path = draw_scatter(sweep, "actuation.eps_pre", "aspect_ratio", colour, tmp_path / "a.png")
    pixels = np.asarray(Image.open(path)).astype(int)
    inside = pixels[94:560, 114:746]  # the axes, without their lines
    coloured = np.ptp(inside, axis=2) > 60
    # Two columns of dots, at −0.2 and −0.1.
    columns = np.flatnonzero(coloured.any(axis=0))
    groups = np.split(columns, np.flatnonzero(np.diff(columns) > 5) + 1)
    assert len(groups) == 2
    # The left ones are higher: more shrinkage, taller shape.
    rows = [np.flatnonzero(coloured[:, group].any(axis=1)).mean() for group in groups]
    assert rows[0] < rows[1]


def test_texts_that_cannot_be_told_apart(sweep: Sweep, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sweep_columns, "MOST_NAMES", 5)
    with pytest.raises(sm.InputError, match="6 different texts"):
        read_column(sweep, "id")


def test_a_scatter_of_nothing_is_refused(sweep: Sweep, tmp_path: Path) -> None:
    with pytest.raises(sm.InputError, match="did you mean height_m"):
        draw_scatter(sweep, "actuation.eps_pre", "heigth_m", None, tmp_path / "a.png")
    assert list(tmp_path.iterdir()) == []


def test_the_contact_sheet_has_a_shape_for_each(
    sweep: Sweep, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("SHEETMORPH_RENDERER", "drawn")
    with RenderWorker.start() as worker:
        path = draw_shapes(sweep, 24, "aspect_ratio", worker, tmp_path / "shapes.png")
        pixels = np.asarray(Image.open(path)).astype(int)
        film = (pixels[..., 0] - pixels[..., 2]) > 80  # the yellow of the film
        found = [film[:, 20 + 200 * k : 220 + 200 * k].any() for k in range(4)]
        assert found == [True] * 4
        assert not film[:, 820:].any()
        with pytest.raises(sm.InputError, match="--shapes"):
            draw_shapes(sweep, 121, None, worker, tmp_path / "b.png")


def test_the_page_is_whole_and_has_a_line_for_each(sweep: Sweep, tmp_path: Path) -> None:
    page = write_parallel(sweep, (), tmp_path / "p.html").read_text("utf-8")
    assert usual_columns(sweep) == [
        "actuation.eps_pre", "layers.print.thickness", "energy_J.total", "height_m",
        "aspect_ratio",
    ]  # fmt: skip
    lines = re.findall(r'<path d="([^"]*)"', page)
    assert len(lines) == 6
    assert all(line.count("L") == 4 for line in (lines[0], lines[4]))
    assert lines[2].count("L") == 1  # inputs alone: nothing came of it
    assert page.count('class="failed"') == 2
    places = json.loads(re.search(r"const places = (\[.*?\]), cells", page).group(1))  # type: ignore[union-attr]
    assert places[0][0] == pytest.approx(62.0)  # −0.1, the top of the first axis
    assert places[3][0] == pytest.approx(460.0)
    assert places[2][4] is None
    assert "<b>sweep" not in page
    assert "script-src 'unsafe-inline'" in page
    assert re.findall(r'(?:src|href)="(?!data:)', page) == []
    with pytest.raises(sm.InputError, match="too many"):
        write_parallel(sweep, ["aspect_ratio"] * 13, tmp_path / "q.html")
