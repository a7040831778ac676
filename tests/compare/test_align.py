"""The pose of a scan: any pose, noise, holes, symmetry, mirror, known scale, the reference scan."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import sheetmorph as sm
from sheetmorph.compare.align import Effort, align
from sheetmorph.compare.clean import prepare
from sheetmorph.compare.distances import symmetric_rms
from sheetmorph.compare.pose import Similarity
from sheetmorph.compare.scan import read_surface
from sheetmorph.compare.surface import Surface
from sheetmorph.core.errors import InputError

BRISK = Effort(points=1000)
EXAMPLES = Path(__file__).resolve().parents[2] / "examples" / "published"


def sheet(height: object, cells: int = 24) -> Surface:
    """z = height(x, y) over a unit square, in decimetres, as metres."""
    x, y = np.meshgrid(*[np.linspace(-1, 1, cells + 1)] * 2, indexing="ij")
    points = 0.05 * np.stack([x, y, height(x, y)], axis=-1).reshape(-1, 3)  # type: ignore[operator]
    a = (np.arange(cells)[:, None] * (cells + 1) + np.arange(cells)).ravel()
    b, c, d = a + cells + 1, a + cells + 2, a + 1
    return Surface(points, np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)]))


@pytest.fixture(scope="module")
def odd() -> Surface:
    """A shape without any symmetry, not even a mirror's: a twisted, lopsided dome."""
    return sheet(lambda x, y: 0.5 * x * y - 0.4 * x**2 - 0.2 * y**2 + 0.15 * x**3 + 0.1 * y)


@pytest.fixture(scope="module")
def petals(reference: Path) -> Surface:
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("SHEETMORPH_REFERENCE_DATA", str(reference))
        result = sm.simulate(sm.Design.load(EXAMPLES / "petals.toml"))
    return Surface(result.positions[-1], result.mesh.triangles)


def any_pose(seed: int) -> Similarity:
    rng = np.random.default_rng(seed)
    turn = Rotation.from_quat(rng.normal(size=4)).as_matrix()
    return Similarity(float(np.exp(rng.normal(0.0, 2.0))), turn, 10.0 * rng.normal(size=3))


def error(found: Similarity, moved: Similarity, surface: Surface) -> float:
    """How far the pose that was found leaves the surface from its place, over its size."""
    there = found.after(moved).apply(surface.points) - surface.points
    return float(np.sqrt((there**2).sum(axis=1).mean()) / surface.size)


@pytest.mark.parametrize("seed", range(3))
def test_a_copy_is_put_back_exactly(odd: Surface, seed: int) -> None:
    pose = any_pose(seed)
    found = align(odd.moved(pose), odd, seed=seed)
    assert error(found.pose, pose, odd) < 1e-6
    assert found.pose.scale * pose.scale == pytest.approx(1.0, rel=1e-6)
    assert found.rms < 1e-6 * odd.size
    assert found.equivalent_poses == ()
    assert found.confidence > 0.99


def test_noise_of_one_percent(odd: Surface) -> None:
    rng = np.random.default_rng(0)
    noisy = Surface(odd.points + 0.01 * odd.size * rng.normal(size=odd.points.shape), odd.triangles)
    pose = any_pose(1)
    found = align(noisy.moved(pose), odd)
    assert error(found.pose, pose, odd) < 1e-2
    assert found.pose.scale * pose.scale == pytest.approx(1.0, rel=2e-2)
    assert 0.003 < found.rms / odd.size < 0.012


@pytest.mark.slow
def test_a_third_of_the_scan_is_missing(odd: Surface) -> None:
    centres = odd.points[odd.triangles].mean(axis=1) / 0.05
    whole = (centres[:, 0] < 0.75) & (np.hypot(centres[:, 0] + 0.4, centres[:, 1]) > 0.5)
    holed = odd.part(whole)
    assert holed.area < 0.7 * odd.area
    pose = any_pose(2)
    found = align(holed.moved(pose), odd)
    assert error(found.pose, pose, odd) < 0.025
    assert found.pose.scale * pose.scale == pytest.approx(1.0, rel=0.01)
    known = align(holed.moved(pose), odd, scale=1.0 / pose.scale)
    assert error(known.pose, pose, odd) < 0.02


def test_a_known_scale_is_held(odd: Surface) -> None:
    pose = any_pose(3)
    found = align(odd.moved(pose), odd, scale=1.05 / pose.scale)
    assert found.pose.scale == pytest.approx(1.05 / pose.scale, rel=1e-12)
    assert found.rms > 1e-3 * odd.size


@pytest.mark.parametrize("scale", [1e-6, 1e6])
def test_a_known_scale_is_held_however_wrong_it_is(odd: Surface, scale: float) -> None:
    quick = Effort(starts=8, kept=2, points=200)
    assert align(odd, odd, scale=scale, effort=quick).pose.scale == pytest.approx(scale, rel=1e-9)


def test_a_mirrored_shape_is_refused_unless_asked_for(odd: Surface) -> None:
    mirror = Similarity(1.0, np.diag([1.0, -1.0, 1.0]), np.zeros(3))
    pose = any_pose(4).after(mirror)
    scan = odd.moved(pose)
    plain = align(scan, odd, effort=BRISK)
    assert not plain.mirrored
    assert not plain.pose.mirrors
    assert plain.rms > 0.01 * odd.size
    asked = align(scan, odd, mirror=True, effort=BRISK)
    assert asked.mirrored
    assert asked.pose.mirrors
    assert asked.rms < 1e-6 * odd.size
    assert error(asked.pose, pose, odd) < 1e-6
    unneeded = align(odd.moved(any_pose(4)), odd, mirror=True, effort=BRISK)
    assert not unneeded.mirrored
    assert unneeded.rms < 1e-6 * odd.size


def test_symmetry_of_the_shape_is_resolved() -> None:
    """A saddle lies on itself in four poses: half a turn about each axis."""
    saddle = sheet(lambda x, y: 0.5 * (x**2 - y**2))
    pose = any_pose(5)
    found = align(saddle.moved(pose), saddle)
    assert found.rms < 1e-6 * saddle.size
    assert len(found.equivalent_poses) == 3
    for other in found.equivalent_poses:
        relative = other.after(found.pose.inverse())
        # Half a turn about z, or a quarter turn that also turns it over.
        assert np.degrees(relative.angle) == pytest.approx(180.0, abs=1.0)
        assert symmetric_rms(saddle.moved(relative), saddle) < 0.01 * saddle.size
    assert found.confidence > 0.9


def test_two_poses_that_fit_alike_are_told(odd: Surface) -> None:
    """A scan of a strip in the middle of a nearly cylindrical shape: it may lie either way."""
    tunnel = sheet(lambda x, y: 0.6 * np.cos(1.5 * x) + 0.06 * x * y)
    even = sheet(lambda x, y: 0.6 * np.cos(1.5 * x))
    sure, unsure = (
        align(scan, shape, effort=BRISK) for scan, shape in ((odd, odd), (even, tunnel))
    )
    assert sure.confidence > 0.9
    assert unsure.confidence < 0.1 or unsure.equivalent_poses


@pytest.mark.parametrize("scale", [0.0, -1.0, float("nan"), float("inf")])
def test_scales_that_cannot_be(odd: Surface, scale: float) -> None:
    with pytest.raises(InputError, match="scale"):
        align(odd, odd, scale=scale)


@pytest.mark.slow
def test_the_reference_scan_from_fifty_poses(reference: Path, petals: Surface) -> None:
    scan = prepare(read_surface(reference / "petals_scan_outer.stl")).surface
    scales = []
    for seed in range(50):
        pose = any_pose(seed)
        found = align(scan.moved(pose), petals, seed=seed)
        laid = scan.moved(found.pose.after(pose))
        there = petals.nearest(laid.sample(4000).points).distance
        assert np.sqrt((there**2).mean()) <= 2.4e-3, seed
        scales.append(found.pose.scale * pose.scale)
    assert np.abs(np.array(scales) - 0.190).max() < 0.003
    assert np.ptp(scales) < 3e-3 * np.mean(scales)


@pytest.mark.slow
def test_the_answer_does_not_depend_on_the_pose(reference: Path, petals: Surface) -> None:
    scan = prepare(read_surface(reference / "petals_scan_outer.stl")).surface
    first = align(scan, petals)
    pose = any_pose(1)
    again = align(scan.moved(pose), petals)
    gap = again.pose.after(pose).apply(scan.points) - first.pose.apply(scan.points)
    assert np.sqrt((gap**2).sum(axis=1)).max() < 1e-4
    assert again.pose.scale * pose.scale == pytest.approx(first.pose.scale, rel=1e-4)
    # Four petals, nearly alike; upside down is another pose, and much worse.
    assert len(first.equivalent_poses) == 3
    assert first.next_rms is not None
    assert 4 * first.rms < first.next_rms < 12e-3
    assert first.confidence == pytest.approx(1.0 - first.rms / first.next_rms, abs=0.01)
