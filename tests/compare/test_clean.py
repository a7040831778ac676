"""Cleaning of scans: what is dropped, closed, turned, counted, and cut off."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from sheetmorph.compare.clean import prepare
from sheetmorph.compare.crop import CropOptions, floor_of
from sheetmorph.compare.faces import faces_of
from sheetmorph.compare.reduce import reduced
from sheetmorph.compare.scan import Scan, read_surface
from sheetmorph.compare.surface import Surface
from sheetmorph.core.errors import InputError


def scan(surface: Surface, unit: float | None = None) -> Scan:
    return Scan(surface, "made.stl", unit=unit)


def told(result: Scan, words: str) -> bool:
    return any(words in note for note in result.notes)


def test_a_clean_sheet_is_left_as_it_is(made: SimpleNamespace) -> None:
    bowl = made.bowl()
    result = prepare(scan(bowl))
    assert result.notes == ()
    assert np.array_equal(result.surface.points, bowl.points)
    assert np.array_equal(result.surface.triangles, bowl.triangles)


def test_flipped_patches_are_turned_back(made: SimpleNamespace) -> None:
    bowl = made.bowl()
    flipped = np.random.default_rng(1).random(len(bowl.triangles)) < 0.3
    triangles = np.where(flipped[:, None], bowl.triangles[:, ::-1], bowl.triangles)
    result = prepare(scan(Surface(bowl.points, triangles)))
    assert (result.surface.normals[:, 2] > 0.0).all()
    assert told(result, f"{flipped.sum()} triangles were turned over")


def test_a_closed_body_looks_outwards(made: SimpleNamespace) -> None:
    shell = made.thick(made.bowl(), 0.05)
    inside_out = Surface(shell.points, shell.triangles[:, ::-1])
    result = prepare(scan(inside_out))
    assert told(result, "pointed inwards")
    assert np.allclose(result.surface.normals, shell.normals)


def test_a_moebius_strip_is_told(made: SimpleNamespace) -> None:
    def strip(u: np.ndarray, v: np.ndarray) -> tuple[np.ndarray, ...]:
        turn, out = np.pi * u, 1.0 + 0.3 * v * np.cos(np.pi * u / 2.0)
        return out * np.cos(turn), out * np.sin(turn), 0.3 * v * np.sin(np.pi * u / 2.0)

    result = prepare(scan(made.grid(strip)))
    assert told(result, "Möbius")


def test_debris_goes_and_large_pieces_stay(made: SimpleNamespace) -> None:
    bowl = made.bowl()
    crumb = Surface(0.05 * bowl.points + [2.0, 0.0, 0.0], bowl.triangles)
    part = Surface(0.5 * bowl.points + [3.0, 0.0, 0.0], bowl.triangles)
    scene = scan(made.joined(bowl, crumb, part))
    kept = {k: prepare(scene, crop=CropOptions(keep=k)) for k in ("parts", "largest", "all")}
    assert kept["parts"].surface.area == pytest.approx(1.25 * bowl.area)
    assert told(kept["parts"], "1 loose piece was dropped, 0.20% of the area")
    assert told(kept["parts"], "in 2 pieces")
    assert kept["largest"].surface.area == pytest.approx(bowl.area)
    assert kept["all"].surface.area == pytest.approx(1.2525 * bowl.area)


def test_broken_triangles_and_cracks(made: SimpleNamespace) -> None:
    bowl = made.bowl()
    cut = bowl.points[bowl.triangles].mean(axis=1)[:, 0] > 0.0
    halves = made.joined(bowl.part(cut), bowl.part(~cut))
    shifted = halves.points.copy()
    shifted[: len(bowl.part(cut).points)] += 3e-6  # a seam that nearly meets
    extra = np.concatenate([halves.triangles, halves.triangles[:5, [1, 0, 2]], [[0, 0, 1]]])
    result = prepare(scan(Surface(shifted, extra)))
    assert told(result, "1 without area, 5 there twice")
    assert told(result, "Cracks were closed")
    assert not told(result, "pieces")
    assert not told(result, "rims;")
    assert result.surface.area == pytest.approx(bowl.area, rel=1e-4)


def test_holes_are_counted(made: SimpleNamespace) -> None:
    bowl = made.bowl()
    centres = bowl.points[bowl.triangles].mean(axis=1)[:, :2]
    holes = np.zeros(len(centres), dtype=bool)
    for place in ([0.5, 0.0], [-0.5, 0.0], [0.0, 0.6]):
        holes |= np.linalg.norm(centres - place, axis=1) < 0.1
    result = prepare(scan(bowl.part(~holes)))
    assert told(result, "The scan has 4 rims")
    assert told(result, "the other 3 may be holes")


def test_a_box_in_the_unit_of_the_file(made: SimpleNamespace) -> None:
    bowl = made.bowl()
    half = (0.0, 1.1, -1.1, 1.1, -1.0, 1.0)
    result = prepare(scan(bowl), crop=CropOptions(box=half))
    assert result.surface.area == pytest.approx(bowl.area / 2.0, rel=0.02)
    assert told(result, "The box keeps 50%")
    small = Surface(0.001 * bowl.points, bowl.triangles)
    metres = prepare(scan(small, unit=0.001), crop=CropOptions(box=half))
    assert metres.surface.area == pytest.approx(1e-6 * result.surface.area)
    with pytest.raises(InputError, match=r"made\.stl.*no triangle of the scan is inside"):
        prepare(scan(bowl), crop=CropOptions(box=(5.0, 6.0, 5.0, 6.0, 5.0, 6.0)))
    for box in ((1.0, 0.0, 0.0, 1.0, 0.0, 1.0), (0.0, 1.0), (0.0, np.nan, 0.0, 1.0, 0.0, 1.0)):
        with pytest.raises(InputError, match="box"):
            CropOptions(box=box)  # type: ignore[arg-type]
    with pytest.raises(InputError, match="floor"):
        CropOptions(floor="maybe")  # type: ignore[arg-type]
    with pytest.raises(InputError, match="keep"):
        CropOptions(keep="some")  # type: ignore[arg-type]


@pytest.mark.parametrize(("height", "noise"), [(-0.02, 0.004), (0.0, 0.0), (0.08, 0.004)])
def test_a_floor_below_through_and_beside(
    made: SimpleNamespace, height: float, noise: float
) -> None:
    for seed, body in enumerate((made.bowl(), made.thick(made.bowl(), 0.05))):
        scene = made.posed(made.joined(body, made.flat(height)), seed, noise)
        count = len(body.triangles)
        floor, hint = floor_of(scene)
        assert hint is None
        assert not floor[:count].any()
        assert floor[count:].all()
        result = prepare(scan(scene))
        assert told(result, "A flat floor was cut off")
        assert result.surface.area == pytest.approx(scene.areas[:count].sum(), rel=0.01)


def test_a_floor_under_the_reference_scan(reference: Path, made: SimpleNamespace) -> None:
    petals = read_surface(reference / "petals_scan_outer.stl").surface
    alone = prepare(scan(petals)).surface
    middle = (petals.points - petals.centroid) / petals.radius
    for axis in range(3):
        stands = Surface(np.roll(middle, 2 - axis, axis=1), petals.triangles)
        low = float(stands.box[0, 2])
        scene = made.posed(made.joined(stands, made.flat(low + 0.05, 4.0)), axis)
        result = prepare(scan(scene)).surface
        share = result.area / scene.area * (stands.area + 64.0) / stands.area
        assert share == pytest.approx(alone.area / petals.area, rel=0.01)


SHEETS: dict[str, Callable[..., tuple[np.ndarray, ...]]] = {
    "flat": lambda u, v: (u, v, 0.0 * u),
    "nearly flat": lambda u, v: (u, v, 0.03 * u * u),
    "cylinder": lambda u, v: (np.sin(1.5 * u), v, np.cos(1.5 * u)),
    "saddle": lambda u, v: (u, v, u * u - v * v),
    "gentle hill in a flat frame": lambda u, v: (u, v, 0.3 * np.exp(-4.0 * (u * u + v * v))),
    "folded": lambda u, v: (u, np.minimum(v, 0.0), np.maximum(v, 0.0)),
    "tray": lambda u, v: (
        np.clip(u, -0.6, 0.6),
        np.clip(v, -0.6, 0.6),
        np.maximum(np.maximum(abs(u), abs(v)) - 0.6, 0.0),
    ),
}


@pytest.mark.parametrize("name", SHEETS)
@pytest.mark.parametrize("noise", [0.0, 0.004])
def test_no_sheet_is_taken_for_a_floor(made: SimpleNamespace, name: str, noise: float) -> None:
    sheet = made.grid(SHEETS[name])
    bodies = [sheet] if name == "tray" else [sheet, made.thick(sheet, 0.03)]
    for seed, body in enumerate(bodies):
        floor, hint = floor_of(made.posed(body, seed, noise))
        assert not floor.any()
        assert (hint is not None) == (name == "gentle hill in a flat frame")


def test_the_reference_scans_have_no_floor(reference: Path) -> None:
    for name in ("petals_scan.stl", "petals_scan_outer.stl"):
        floor, hint = floor_of(read_surface(reference / name).surface)
        assert not floor.any()
        assert hint is None


def test_a_joined_floor_is_cut_where_the_sheet_stands_up(made: SimpleNamespace) -> None:
    dome = made.grid(lambda u, v: (u, v, np.maximum(0.0, 0.4 - 1.5 * (u * u + v * v))), 120)
    up = dome.points[dome.triangles].mean(axis=1)[:, 2] > 0.0
    result = prepare(scan(dome))
    assert result.surface.area == pytest.approx(dome.areas[up].sum(), rel=0.1)
    assert told(result, "switch this off")
    assert prepare(scan(dome), crop=CropOptions(floor="none")).surface.area == dome.area
    # The shape it is compared with has a flat frame: it stays.
    kept = prepare(scan(dome), shape=made.posed(dome, 3))
    assert kept.surface.area == dome.area
    assert told(kept, "the shape has such a part")
    hill = made.grid(SHEETS["gentle hill in a flat frame"], 120)
    assert told(prepare(scan(hill)), "may be a floor")
    assert prepare(scan(hill), crop=CropOptions(floor="cut")).surface.area < 0.6 * hill.area


def test_a_slab_that_grew_together_with_a_dome(made: SimpleNamespace) -> None:
    import manifold3d

    def body(surface: Surface) -> manifold3d.Manifold:
        mesh = manifold3d.Mesh64(surface.points, surface.triangles.astype(np.uint64))
        return manifold3d.Manifold(mesh)

    dome = made.thick(made.bowl(-1.2, 40), 0.06)
    shell = body(Surface(dome.points + np.array([0.0, 0.0, 1.25]), dome.triangles))
    slab = manifold3d.Manifold.cube((5.0, 4.0, 0.2), True).translate((0.0, 0.0, -0.02))

    def surface(solid: manifold3d.Manifold) -> Surface:
        mesh = solid.to_mesh64()
        return Surface(mesh.vert_properties[:, :3], mesh.tri_verts.astype(np.int64))

    above = surface(shell.split_by_plane((0.0, 0.0, 1.0), 0.08)[0])
    scene = made.posed(surface(shell + slab.refine_to_length(0.2)), 2, scale=3.0)
    result = prepare(scan(scene))
    assert result.surface.area == pytest.approx(9.0 * above.area, rel=0.06)


def test_reduced_keeps_the_faces_apart(made: SimpleNamespace) -> None:
    sheet = made.grid(lambda u, v: (u, v, 0.5 * (u * u + v * v)), 120)
    shell = made.thick(sheet, 0.004)
    small, cell = reduced(shell, 8_000)
    assert cell > 10 * 0.004
    assert 4_000 < len(small.triangles) < 16_000
    assert small.area == pytest.approx(shell.area, rel=0.02)
    assert np.quantile(shell.nearest(small.points).distance, 0.9) < 0.02 * cell
    assert np.quantile(shell.nearest(small.sample(3000).points).distance, 0.9) < 0.02 * cell
    faces = faces_of(small)
    assert faces.two_faced
    assert faces.thickness == pytest.approx(0.004, rel=0.2)
    same, none = reduced(shell, 10**6)
    assert same is shell
    assert none == 0.0
