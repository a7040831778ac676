"""The graded film: exact derivatives, descent, its file; and patterns cut from a field."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import shapely

from sheetmorph.design.spec import Design
from sheetmorph.inverse.evaluations import Evaluations
from sheetmorph.inverse.families import FREE, SIZE
from sheetmorph.inverse.flatten import flatten
from sheetmorph.inverse.graded import FIELD, GradedSheet, graded_sheet, optimise, outline_of
from sheetmorph.inverse.journal import Journal
from sheetmorph.inverse.limits import Limits, narrow_share
from sheetmorph.inverse.misfit import Job, shape_of
from sheetmorph.inverse.objective import apart
from sheetmorph.inverse.targets import read_target
from sheetmorph.inverse.threshold import SHARE, threshold_space
from sheetmorph.study.simulate import simulate

MESH = {"mesh.size": "14 mm"}
TARGET = read_target("canoe:1.5:0.3")
FLAT = flatten(TARGET.surface)


@pytest.fixture(scope="module")
def film() -> GradedSheet:
    return graded_sheet(TARGET.surface, FLAT, "film", MESH)


def test_distance_and_its_slope_by_the_nodes(film: GradedSheet) -> None:
    random = np.random.default_rng(0)
    positions = film.mesh.nodes + 2e-3 * random.normal(size=film.mesh.nodes.shape)
    here = apart(TARGET.surface, positions, film.mesh.triangles)
    along = here.slope / np.linalg.norm(here.slope)
    h = 1e-6
    ahead, behind = (
        apart(TARGET.surface, positions + s * h * along, film.mesh.triangles, here.pose).square
        for s in (1, -1)
    )
    assert (ahead - behind) / (2 * h) == pytest.approx((here.slope * along).sum(), rel=1e-3)
    assert np.abs(here.slope.sum(axis=0)).max() < 1e-3 * np.abs(here.slope).sum()


def test_objective_has_exact_derivatives_by_the_strain_of_faces(film: GradedSheet) -> None:
    first = film.evaluate(Job(FREE, tuple(film.first.tolist())))
    slope = np.array(first.residuals)
    along = slope / np.linalg.norm(slope)
    h = 2e-4
    ahead, behind = (
        film.evaluate(Job(FREE, tuple((film.first + s * h * along).tolist()), near=first.pose))
        for s in (1, -1)
    )
    assert (ahead.misfit - behind.misfit) / (2 * h) == pytest.approx(slope @ along, rel=1e-3)


def test_optimising_the_field_brings_the_film_closer_and_its_file_says_so(
    film: GradedSheet, tmp_path: Path
) -> None:
    evaluations = Evaluations(film, Journal(None, ""))
    first = film.evaluate(Job(FREE, tuple(film.first.tolist())))
    best = optimise(evaluations, film, steps=6)
    assert best.misfit < 0.5 * first.misfit
    strain = np.array(best.point)
    assert (strain.min() >= -0.8) and (strain.max() <= 0.0)
    (tmp_path / FIELD).write_bytes(film.file(strain))
    (tmp_path / "film.toml").write_text(film.text, encoding="utf-8")
    result = simulate(Design.load(tmp_path / "film.toml"))
    again = apart(TARGET.surface, result.positions[-1], result.mesh.triangles)
    assert np.sqrt(again.square) == pytest.approx(best.distance, rel=1e-3)
    assert shape_of(result).size == pytest.approx(TARGET.surface.size, rel=0.05)


def test_a_pattern_covers_the_share_that_was_asked_for_where_the_film_shrinks_least(
    film: GradedSheet,
) -> None:
    limits = Limits(minimum_width=3e-3)
    outline = outline_of(FLAT)
    space = threshold_space(film, film.first, outline, limits, MESH)
    assert [one.name for one in space.parameters] == [SIZE, SHARE, "eps_pre"]
    size = float(np.ptp(outline, axis=0).max())
    for share in (0.2, 0.5):
        design = space.design((size, share, -0.3), "cut")
        pattern = design.layout.pattern
        assert pattern.area / design.layout.sheet.area == pytest.approx(share, abs=0.03)
        assert narrow_share(pattern, 0.99 * 3e-3) == 0.0
        assert shapely.contains(pattern, shapely.Point(0.0, 0.0))  # a bowl is stiff in its middle
    large = space.design((1.1 * size, 0.5, -0.3), "cut")
    assert np.ptp(np.array(large.layout.sheet.bounds)[[0, 2]]) == pytest.approx(
        1.1 * size, rel=1e-3
    )
