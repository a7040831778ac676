"""Whole comparisons: the reference scan, its numbers, options, and what is told."""

from __future__ import annotations

import json
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import sheetmorph as sm
from sheetmorph.compare import comparison
from sheetmorph.compare.align import Effort, align
from sheetmorph.compare.comparison import CompareOptions, Comparison, compare_surfaces
from sheetmorph.compare.pose import Similarity
from sheetmorph.compare.scan import Scan, read_surface
from sheetmorph.compare.surface import Surface
from sheetmorph.core.errors import InputError
from sheetmorph.core.events import Event, Progress, Started

EXAMPLES = Path(__file__).resolve().parents[2] / "examples" / "published"
QUICK = CompareOptions(grid=24, window=5)


@pytest.fixture(scope="module")
def states(reference: Path) -> tuple[Surface, Surface]:
    """The published petals, flat and at −0.50."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("SHEETMORPH_REFERENCE_DATA", str(reference))
        result = sm.simulate(sm.Design.load(EXAMPLES / "petals.toml"))
    return tuple(Surface(result.positions[k], result.mesh.triangles) for k in (0, -1))  # type: ignore[return-value]


@pytest.fixture(scope="module")
def outer(reference: Path, states: tuple[Surface, Surface]) -> Comparison:
    scan = read_surface(reference / "petals_scan_outer.stl")
    return compare_surfaces(states[1], scan, flat=states[0])


@pytest.fixture
def brisk(monkeypatch: pytest.MonkeyPatch) -> None:
    """Fewer points in the alignment, for surfaces that need no more."""
    effort = Effort(starts=96, kept=6, points=1000)
    monkeypatch.setattr(comparison, "align", partial(align, effort=effort))


def dome(cells: int = 16) -> Surface:
    x, y = np.meshgrid(*[np.linspace(-1, 1, cells + 1)] * 2, indexing="ij")
    z = 0.5 * x * y - 0.4 * x**2 - 0.2 * y**2 + 0.15 * x**3
    a = (np.arange(cells)[:, None] * (cells + 1) + np.arange(cells)).ravel()
    b, c, d = a + cells + 1, a + cells + 2, a + 1
    triangles = np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)])
    return Surface(0.05 * np.stack([x, y, z], axis=-1).reshape(-1, 3), triangles)


def posed(surface: Surface, scale: float, seed: int = 0) -> Surface:
    rng = np.random.default_rng(seed)
    turn = Rotation.from_quat(rng.normal(size=4)).as_matrix()
    return surface.moved(Similarity(scale, turn, rng.normal(size=3)))


def test_the_reference_scan_and_the_published_petals(outer: Comparison) -> None:
    assert outer.similarity.value >= 0.87
    assert (outer.similarity.grid, outer.similarity.window) == (64, 10)
    assert outer.scan_to_shape.rms <= 2.4e-3
    assert outer.unit_length == pytest.approx(0.190, abs=0.003)
    assert not outer.scale_known
    assert not outer.alignment.mirrored
    assert outer.face == "single"
    # What they were when this was written.
    assert outer.similarity.value == pytest.approx(0.8817, abs=0.002)
    assert outer.scan_to_shape.rms == pytest.approx(2.066e-3, abs=2e-5)
    assert outer.shape_to_scan.rms == pytest.approx(1.886e-3, abs=2e-5)
    assert [(other.grid, other.window) for other in outer.others] == [(10, 7), (10, 3)]


def test_the_prediction_beats_the_baselines(outer: Comparison) -> None:
    assert set(outer.baselines) == {"flat_sheet", "spherical_cap"}
    flat, cap = outer.baselines["flat_sheet"], outer.baselines["spherical_cap"]
    assert flat.ssim < cap.ssim < outer.similarity.value - 0.1
    assert flat.rms > cap.rms > outer.scan_to_shape.rms
    assert 0.5 < cap.opening_angle < 2.5


def test_json_is_finite_and_complete(outer: Comparison) -> None:
    text = json.dumps(outer.to_json(), allow_nan=False)
    values = json.loads(text)
    ways = {"scan_to_shape", "shape_to_scan"}
    for name in ("rms", "mean", "p95", "hausdorff"):
        for unit in ("mm", "percent_of_size"):
            assert set(values[f"{name}_{unit}"]) == ways
        percent = 100 * values[f"{name}_mm"]["scan_to_shape"] / values["size_mm"]
        assert values[f"{name}_percent_of_size"]["scan_to_shape"] == pytest.approx(percent)
    assert set(values["ssim_baselines"]) == {"flat_sheet", "spherical_cap"}
    turn = np.array(values["rotation"])
    np.testing.assert_allclose(turn @ turn.T, np.eye(3), atol=1e-12)
    assert len(values["translation_m"]) == 3
    for key in ("ssim", "grid", "window", "scale", "seconds", "confidence", "face", "notes"):
        assert key in values
    assert values["mean_mm"]["scan_to_shape"] < values["rms_mm"]["scan_to_shape"]
    assert values["p95_mm"]["scan_to_shape"] < values["hausdorff_mm"]["scan_to_shape"]
    assert 0 < values["normal_deviation_deg"]["scan_to_shape"]["rms"] < 45
    assert values["curvature_deviation_per_m"]["scan_to_shape"] > 0
    assert abs(values["aspect_ratio"]["relative_error"]) < 0.2


@pytest.mark.slow
def test_both_faces_of_the_raw_scan(reference: Path, states: tuple[Surface, Surface]) -> None:
    scan = read_surface(reference / "petals_scan.stl")
    both = compare_surfaces(states[1], scan, flat=states[0])
    assert both.face == "both"
    assert both.similarity.value >= 0.86
    assert both.scan_to_shape.rms <= 2.6e-3
    assert both.thickness == pytest.approx(1.47e-3, abs=0.1e-3)
    assert any("thick" in note for note in both.notes)


@pytest.mark.slow
def test_the_outer_face_of_the_raw_scan(
    reference: Path, states: tuple[Surface, Surface], outer: Comparison
) -> None:
    scan = read_surface(reference / "petals_scan.stl")
    options = CompareOptions(face="outer", grid=32)
    face = compare_surfaces(states[1], scan, options=options)
    assert face.face == "outer"
    assert face.scan_to_shape.rms == pytest.approx(outer.scan_to_shape.rms, rel=0.03)
    assert face.unit_length == pytest.approx(outer.unit_length, rel=0.01)


@pytest.mark.usefixtures("brisk")
def test_a_copy_is_the_same() -> None:
    shape = dome()
    result = compare_surfaces(shape, posed(shape, 40.0), options=QUICK)
    assert result.similarity.value == pytest.approx(1.0, abs=1e-6)
    assert result.scan_to_shape.maximum < 1e-6
    assert result.shape_to_scan.maximum < 1e-6
    assert np.degrees(result.scan_to_shape.normal_rms) < 2.0
    assert result.aspect_ratio.relative_error == pytest.approx(0.0, abs=1e-5)
    assert result.unit_length == pytest.approx(1 / 40.0, rel=1e-6)
    assert result.alignment.confidence > 0.99


@pytest.mark.usefixtures("brisk")
def test_the_unit_makes_the_scale_known() -> None:
    shape = dome()
    millimetres = posed(shape, 1e3)
    result = compare_surfaces(shape, millimetres, options=CompareOptions("mm", grid=16, window=4))
    assert result.unit_length == pytest.approx(1e-3, rel=1e-9)
    assert result.scale_known
    assert result.scan_to_shape.rms < 1e-6
    assert any("scale was held" in note for note in result.notes)
    assert not any("wrong" in note for note in result.notes)
    read = Scan(posed(shape, 1.1), "scan.stl", (), 1e-3)
    other = compare_surfaces(shape, read, options=CompareOptions(grid=16, window=4))
    assert other.unit_length == pytest.approx(1e-3)
    assert other.alignment.pose.scale == pytest.approx(1.0)
    assert other.scan_to_shape.rms > 1e-4
    assert any("0.909 times" in note for note in other.notes)


@pytest.mark.usefixtures("brisk")
def test_a_unit_is_recognised_and_a_wrong_one_is_told() -> None:
    shape = dome(12)
    inches = posed(shape, 1 / 0.0254)
    fitted = compare_surfaces(shape, inches, options=QUICK)
    assert any("nearly 1 in" in note for note in fitted.notes)
    wrong = compare_surfaces(shape, inches, options=replace(QUICK, unit="mm"))
    assert wrong.unit_length == pytest.approx(1e-3, rel=1e-9)
    assert any("unit or the scale given is wrong" in note for note in wrong.notes)


@pytest.mark.slow
@pytest.mark.usefixtures("brisk")
def test_what_is_no_scan_of_the_sheet_is_told() -> None:
    rng = np.random.default_rng(0)
    points = rng.normal(size=(300, 3))
    stick = Surface(points * [30.0, 1.0, 1.0], rng.integers(0, 300, (60, 3)))
    result = compare_surfaces(dome(), stick, options=QUICK)
    assert any("does not fit" in note for note in result.notes)
    json.dumps(result.to_json(), allow_nan=False)


@pytest.mark.usefixtures("brisk")
def test_flat_against_flat() -> None:
    shape = dome()
    flat = Surface(shape.points * [1, 1, 0], shape.triangles)
    result = compare_surfaces(flat, posed(flat, 3.0), options=QUICK)
    assert result.similarity.value > 0.999
    assert result.scan_to_shape.rms < 1e-5
    values = json.loads(json.dumps(result.to_json(), allow_nan=False))
    assert values["aspect_ratio"]["shape"] == 0.0


@pytest.mark.usefixtures("brisk")
def test_progress_is_told() -> None:
    heard: list[Event] = []
    compare_surfaces(dome(12), dome(12), options=QUICK, on_event=heard.append)
    assert isinstance(heard[0], Started)
    fractions = [event.fraction for event in heard if isinstance(event, Progress)]
    assert fractions == sorted(fractions)
    assert fractions[-1] == 1.0


@pytest.mark.parametrize(
    ("options", "match"),
    [
        (CompareOptions(unit="mm", scale=1.0), "twice"),
        (CompareOptions(unit="kg"), "kg"),
        (CompareOptions(scale=-1.0), "scale"),
        (CompareOptions(grid=1), "grid"),
        (CompareOptions(grid=8, window=9), "window"),
        (CompareOptions(face="top"), "face"),  # type: ignore[arg-type]
    ],
)
def test_options_that_cannot_be(options: CompareOptions, match: str) -> None:
    with pytest.raises(InputError, match=match):
        compare_surfaces(dome(8), dome(8), options=options)
