"""The faces of a thick scan: seen, split, named; what has none is told."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
import trimesh

from sheetmorph.compare.clean import prepare
from sheetmorph.compare.faces import face_of, faces_of
from sheetmorph.compare.scan import Scan, read_surface
from sheetmorph.compare.surface import Surface
from sheetmorph.core.errors import InputError


def right_share(surface: Surface, outer: np.ndarray, count: int, first_is_outer: bool) -> float:
    """Share of the area of two faces, of `count` triangles each, that is on the right one."""
    truth = np.zeros(2 * count, dtype=bool)
    truth[:count] = first_is_outer
    truth[count:] = not first_is_outer
    return float(np.average(outer[: 2 * count] == truth, weights=surface.areas[: 2 * count]))


@pytest.mark.parametrize("noise", [0.0, 0.003])
@pytest.mark.parametrize("thickness", [0.01, 0.05, 0.15])
def test_a_thick_bowl_has_two_faces(made: SimpleNamespace, thickness: float, noise: float) -> None:
    sheet = made.bowl()
    if noise > 0.1 * thickness:
        noise = 0.1 * thickness
    scan = made.posed(made.thick(sheet, thickness), 1, noise)
    faces = faces_of(scan)
    assert faces.kind == "two"
    assert faces.told_apart
    assert (faces.outer ^ faces.inner).all()
    assert not faces.turned.any()
    assert faces.thickness == pytest.approx(7.0 * thickness, rel=0.05)
    # The bowl opens upwards, so its outer face is the lower one, the second.
    assert right_share(scan, faces.outer, len(sheet.triangles), False) > 0.995
    outer, name = face_of(scan, faces, "auto")
    inner = face_of(scan, faces, "inner")[0]
    assert name == "outer"
    assert outer.area + inner.area == pytest.approx(scan.area)
    assert face_of(scan, faces, "both")[0].area == pytest.approx(scan.area)
    with pytest.raises(InputError, match="face"):
        face_of(scan, faces, "upper")  # type: ignore[arg-type]


def test_faces_without_a_rim_may_be_turned_anyhow(made: SimpleNamespace) -> None:
    sheet = made.bowl()
    count = len(sheet.triangles)
    shell = made.thick(sheet, 0.05)
    for turned in ([False, False], [False, True], [True, False], [True, True]):
        flip = np.repeat(turned, count)[:, None]
        both = shell.triangles[: 2 * count]
        scan = made.posed(Surface(shell.points, np.where(flip, both[:, ::-1], both)), 2)
        faces = faces_of(scan)
        assert faces.two_faced
        assert (faces.turned == flip[:, 0]).all()
        assert right_share(scan, faces.outer, count, False) == 1.0
        normals = face_of(scan, faces, "both")[0].normals
        away = np.einsum("td,td->t", normals, scan.points[scan.triangles].mean(1) - scan.centroid)
        assert away[count:].mean() > 0.0 > away[:count].mean()


def test_a_flat_plate_says_that_up_is_outer(made: SimpleNamespace) -> None:
    plate = made.thick(made.grid(lambda u, v: (u, v, 0.0 * u)), 0.03)
    faces = faces_of(plate)
    assert faces.two_faced
    assert not faces.told_apart
    assert "Neither face is the convex one" in faces.notes[-1]
    assert (plate.normals[faces.outer, 2] > -0.1).all()


def test_a_sheet_rolled_nearly_shut(made: SimpleNamespace) -> None:
    tube = made.grid(lambda u, v: (np.cos(2.9 * u), np.sin(2.9 * u), v))
    scan = made.posed(made.thick(tube, 0.03), 4, 0.001)
    faces = faces_of(scan)
    assert faces.two_faced
    assert faces.told_apart
    middle = tube.points[tube.triangles].mean(axis=1) * [1.0, 1.0, 0.0]
    first_is_outer = bool((tube.normals * middle).sum() > 0.0)
    assert right_share(scan, faces.outer, len(tube.triangles), first_is_outer) > 0.995


ONE_FACED: dict[str, Callable[..., tuple[np.ndarray, ...]]] = {
    "flat": lambda u, v: (u, v, 0.0 * u),
    "bowl": lambda u, v: (u, v, 0.5 * (u * u + v * v)),
    "deep": lambda u, v: (u, v, 3.0 * (u * u + v * v)),
    "saddle": lambda u, v: (u, v, u * u - v * v),
    "tube": lambda u, v: (np.cos(2.9 * u), np.sin(2.9 * u), v),
    "narrow tube": lambda u, v: (0.06 * np.cos(3.0 * u), 0.06 * np.sin(3.0 * u), v),
    "spiral": lambda u, v: (
        (0.3 + 0.35 * (u + 1.0)) * np.cos(7.0 * np.pi * u),
        (0.3 + 0.35 * (u + 1.0)) * np.sin(7.0 * np.pi * u),
        v,
    ),
    "corrugated": lambda u, v: (u, v, 0.1 * np.sin(20.0 * u)),
    "ball with a hole": lambda u, v: (
        np.sin(1.3 * (u + 1.0)) * np.cos(np.pi * v),
        np.sin(1.3 * (u + 1.0)) * np.sin(np.pi * v),
        np.cos(1.3 * (u + 1.0)),
    ),
}


@pytest.mark.parametrize("name", ONE_FACED)
def test_one_face_is_one_face(made: SimpleNamespace, name: str) -> None:
    sheet = made.grid(ONE_FACED[name], 100)
    for noise in (0.0, 0.001):
        scan = made.posed(sheet, 5, noise)
        faces = faces_of(scan)
        assert faces.kind == "one"
        assert faces.thickness is None
        assert faces.outer.all()
        assert not faces.inner.any()
        assert faces.notes == ()
        assert face_of(scan, faces, "inner")[1] == "single"


def test_a_thick_moebius_strip_has_one_face_that_is_both(made: SimpleNamespace) -> None:
    # Twice around the strip, always on its left.
    def around(u: np.ndarray, v: np.ndarray) -> tuple[np.ndarray, ...]:
        turn = 2.0 * np.pi * u
        out, up = 0.3 * v * np.cos(turn / 2.0), 0.3 * v * np.sin(turn / 2.0)
        side = 0.01
        out, up = out - side * np.sin(turn / 2.0), up + side * np.cos(turn / 2.0)
        return (1.0 + out) * np.cos(turn), (1.0 + out) * np.sin(turn), up

    strip = made.grid(around, 90)
    faces = faces_of(prepare(Scan(strip, "strip")).surface)
    assert faces.two_faced
    assert "cannot be told apart" in faces.notes[-1]
    assert face_of(strip, faces, "outer")[1] == "both"


@pytest.mark.parametrize(
    "body",
    [
        trimesh.creation.icosphere(3),
        trimesh.creation.box().subdivide().subdivide().subdivide(),
        trimesh.creation.box((1.0, 1.0, 0.3)).subdivide().subdivide().subdivide(),
        trimesh.creation.torus(1.0, 0.3),
    ],
    ids=["ball", "cube", "block", "torus"],
)
def test_a_solid_body_is_told(made: SimpleNamespace, body: trimesh.Trimesh) -> None:
    scan = made.posed(Surface(body.vertices, body.faces), 6)
    faces = faces_of(scan)
    assert faces.kind == "solid"
    assert "looks like a solid body" in faces.notes[0]
    assert face_of(scan, faces, "auto")[0].area == pytest.approx(scan.area)


def test_a_large_scan_is_split_in_patches(
    made: SimpleNamespace, monkeypatch: pytest.MonkeyPatch
) -> None:
    sheet = made.bowl(count=100)
    scan = made.posed(made.thick(sheet, 0.03), 1, 0.001)
    monkeypatch.setattr("sheetmorph.compare.faces.BLOCKS", 4_000)
    faces = faces_of(scan)
    assert faces.thickness == pytest.approx(0.21, rel=0.05)
    assert right_share(scan, faces.outer, len(sheet.triangles), False) > 0.995


def test_the_reference_scan_splits_as_it_was_split_by_hand(reference: Path) -> None:
    """The released outer face is a part of the released raw scan, turned about x and shifted."""
    raw = prepare(read_surface(reference / "petals_scan.stl")).surface
    by_hand = read_surface(reference / "petals_scan_outer.stl").surface
    assert (
        faces_of(prepare(read_surface(reference / "petals_scan_outer.stl")).surface).kind == "one"
    )
    faces = faces_of(raw)
    assert faces.kind == "two"
    assert faces.told_apart
    assert 0.008 < faces.thickness / raw.size < 0.02

    turn = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])
    shift = by_hand.box[0] - Surface(raw.points @ turn.T, raw.triangles).box[0]

    def placed(surface: Surface) -> Surface:
        return Surface(surface.points @ turn.T + shift, surface.triangles)

    outer, inner = (placed(face_of(raw, faces, which)[0]) for which in ("outer", "inner"))
    seen = by_hand.sample(6000).points
    to_outer, to_inner = outer.nearest(seen).distance, inner.nearest(seen).distance
    assert np.quantile(to_outer, 0.95) < 1e-6
    assert np.median(to_inner) > 0.007
    back = by_hand.nearest(outer.sample(6000).points).distance
    assert np.sqrt((back**2).mean()) < 3e-4
    assert np.sqrt((by_hand.nearest(inner.sample(6000).points).distance ** 2).mean()) > 0.01
