"""Curved meshes: checks, frames, and the files they come from."""

from __future__ import annotations

import math

import meshio
import numpy as np
import pytest

from sheetmorph.core.errors import InputError
from sheetmorph.geometry.files import read_mesh, write_mesh, write_stl
from sheetmorph.geometry.structured import rectangle, sphere_sector
from sheetmorph.geometry.topology import build_mesh

TENT = [[0, 0, 0], [1, 0, 0.5], [1, 1, 0.5], [0, 1, 0]]
TWO = [[0, 1, 2], [0, 2, 3]]
WALL = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [1, 0, -1], [1, 1, -1]]
BOX = [[0, 1, 2], [1, 3, 2], [3, 4, 2]]


@pytest.fixture(scope="module")
def dome():
    return sphere_sector(0.1, (math.radians(18), math.pi / 2), (0.0, math.pi / 2), 6, 6)


def test_a_curved_mesh_keeps_its_heights():
    mesh = build_mesh(TENT, TWO, curved=True)
    assert not mesh.flat
    assert mesh.nodes.tolist() == TENT
    assert mesh.triangle_areas.sum() == pytest.approx(math.hypot(1, 0.5))
    assert mesh.edge_lengths.max() == pytest.approx(1.5)
    with pytest.raises(InputError, match="not flat"):
        build_mesh(TENT, TWO)


def test_vertical_triangles_are_fine():
    mesh = build_mesh(WALL, BOX, curved=True)
    assert mesh.triangle_areas == pytest.approx([0.5, 0.5, 0.5])
    assert mesh.triangle_normals[1:] == pytest.approx(np.tile([1.0, 0.0, 0.0], (2, 1)))
    # A triangle that faces x has z as its first axis.
    assert mesh.triangle_frames[1] == pytest.approx(np.array([[0.0, 0.0, 1.0], [0.0, -1.0, 0.0]]))


def test_a_flat_sheet_has_the_axes_of_the_plan():
    mesh = rectangle(1.0, 1.0, 3, 3, irregular=0.2)
    assert np.array_equal(mesh.triangle_frames, np.tile(np.eye(3)[:2], (18, 1, 1)))
    assert np.array_equal(mesh.triangle_normals, np.tile([0.0, 0.0, 1.0], (18, 1)))


def test_frames_are_orthonormal_in_the_triangles(dome):
    first, second = dome.triangle_frames.transpose(1, 0, 2)
    normals = dome.triangle_normals
    basis = np.stack([first, second, normals], axis=1)
    assert basis @ basis.transpose(0, 2, 1) == pytest.approx(np.tile(np.eye(3), (72, 1, 1)))
    assert np.linalg.det(basis) == pytest.approx(np.ones(72))
    # The first axis is x without its part along the normal.
    expected = np.array([1.0, 0.0, 0.0]) - normals[:, :1] * normals
    assert np.cross(first, expected) == pytest.approx(np.zeros((72, 3)), abs=1e-12)
    assert ((first * expected).sum(axis=1) > 0).all()


BAD = {
    "overhang": ([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0.5, 0.9, 1]], [[0, 1, 2], [0, 3, 2]],
                 "triangle 1 is flipped"),
    "no area": ([[0, 0, 0], [1, 0, 1], [2, 0, 2], [0, 1, 0]], [[0, 2, 3], [0, 1, 2]],
                "triangle 1 is degenerate"),
    "inside out": (WALL, [[0, 1, 2], [1, 2, 3], [3, 4, 2]], "overlap"),
    "two pieces": ([*TENT, [5, 0, 1], [6, 0, 1], [5, 1, 0]], [*TWO, [4, 5, 6]], "in 2 pieces"),
    "not finite": ([[0, 0, 0], [1, 0, np.nan], [1, 1, 0]], [[0, 1, 2]], "node 1 .*not a finite"),
}  # fmt: skip


@pytest.mark.parametrize("name", BAD)
def test_bad_curved_meshes(name):
    nodes, triangles, text = BAD[name]
    with pytest.raises(InputError, match=text) as caught:
        build_mesh(nodes, triangles, curved=True)
    assert "\n" not in str(caught.value)


def test_the_text_format_keeps_every_digit(dome, tmp_path):
    for mesh in (dome, rectangle(0.1, 0.07, 5, 4, "alternating", irregular=0.2)):
        write_mesh(tmp_path / "a.txt", mesh)
        again = read_mesh(tmp_path / "a.txt", curved=not mesh.flat)
        for name in ("nodes", "triangles", "edges", "hinges"):
            assert np.array_equal(getattr(again, name), getattr(mesh, name))
    write_mesh(tmp_path / "mm.txt", dome, 1e-3)
    assert read_mesh(tmp_path / "mm.txt", 1e-3, curved=True).nodes == pytest.approx(dome.nodes)


@pytest.mark.parametrize("ending", [".vtu", ".ply", ".obj", ".stl"])
def test_files_of_curved_sheets(dome, tmp_path, ending):
    path = tmp_path / f"dome{ending}"
    if ending == ".stl":
        write_stl(path, dome.triangles, dome.nodes)
    else:
        meshio.Mesh(dome.nodes, [("triangle", dome.triangles)]).write(path)
    mesh = read_mesh(path, curved=True)
    assert mesh.counts == dome.counts
    assert mesh.triangle_areas.sum() == pytest.approx(dome.triangle_areas.sum(), rel=1e-6)
    with pytest.raises(InputError, match="not flat"):
        read_mesh(path)


def test_a_sheet_that_faces_down_is_turned_over(dome, tmp_path):
    path = tmp_path / "down.obj"
    meshio.Mesh(dome.nodes, [("triangle", dome.triangles[:, ::-1])]).write(path)
    mesh = read_mesh(path, curved=True)
    assert (mesh.triangle_normals[:, 2] > -1e-12).all()
