"""The geometric rule for hinges: numbering, edge order, turns and mirrors change nothing."""

from __future__ import annotations

from pathlib import Path

import meshio
import numpy as np
import pytest
from small import SMALL

import sheetmorph as sm
from sheetmorph.design.meshing import farther_side
from sheetmorph.study.model import build_problem


def write_mesh(path: Path, nodes: np.ndarray, triangles: np.ndarray) -> None:
    meshio.write(path, meshio.Mesh(1e3 * nodes, [("triangle", triangles)]))


def on_mesh(folder: Path, name: str, nodes: np.ndarray, triangles: np.ndarray) -> sm.Design:
    write_mesh(folder / name, nodes, triangles)
    text = SMALL.replace('size = "3 mm"', f'file = "{name}"')
    return sm.Design.from_toml(text, folder)


@pytest.fixture
def usual(small_design: sm.Design, tmp_path: Path) -> tuple[sm.Design, np.ndarray, np.ndarray]:
    mesh = small_design.build_mesh()
    # Nodes moved a little, so that no symmetry of the mesh hides a mistake.
    rng = np.random.default_rng(0)
    nodes = mesh.nodes.copy()
    inner = np.hypot(nodes[:, 0], nodes[:, 1]) < 15e-3
    nodes[inner, :2] += 5e-5 * rng.standard_normal((int(inner.sum()), 2))
    return on_mesh(tmp_path, "usual.vtu", nodes, mesh.triangles), nodes, mesh.triangles


def test_renumbering_and_reordering(usual, tmp_path: Path) -> None:  # type: ignore[no-untyped-def]
    design, nodes, triangles = usual
    rng = np.random.default_rng(1)
    number = rng.permutation(len(nodes))
    shuffled = np.empty_like(nodes)
    shuffled[number] = nodes
    faces = number[triangles][rng.permutation(len(triangles))]
    other = on_mesh(tmp_path, "other.vtu", shuffled, np.roll(faces, 1, axis=1))
    a, b = sm.simulate(design), sm.simulate(other)
    aligned = b.positions[-1][number]
    # Free sheets are laid level by all their nodes, so both lie in the same place.
    assert np.abs(a.positions[-1] - aligned).max() < 1e-9
    assert a.summary["energy_J"]["total"] == pytest.approx(b.summary["energy_J"]["total"], rel=1e-9)


def test_reversed_edges(usual) -> None:  # type: ignore[no-untyped-def]
    """Whatever way edges ran before, the rule gives the same hinges."""
    design, _, _ = usual
    problem = build_problem(design)
    mesh = problem.mesh
    turned = mesh.with_hinges_reversed(np.random.default_rng(2).random(len(mesh.hinges)) < 0.5)
    side = farther_side(turned, design.pattern_polygon())
    again = turned.with_hinges_reversed(side < 0)
    ties = problem.model.coupling == 0.0
    np.testing.assert_array_equal(again.hinges[~ties], mesh.hinges[~ties])
    assert (farther_side(again, design.pattern_polygon()) >= 0).all()
    np.testing.assert_array_equal(side == 0, ties)


def test_ties_have_no_coupling() -> None:
    """The rule on a mesh with the drawing's own symmetry: hinges on a mirror line are ties."""
    text = SMALL.replace("arms = 3", "arms = 4")
    problem = build_problem(sm.Design.from_toml(text))
    mesh = problem.mesh
    c, d = mesh.nodes[mesh.hinges[:, 2]], mesh.nodes[mesh.hinges[:, 3]]
    mirrored = np.abs(c * [1, -1, 1] - d).max(axis=1) < 1e-9
    assert mirrored.any()
    assert (problem.model.coupling[mirrored] == 0).all()
    assert (problem.model.coupling != 0).mean() > 0.7


def test_a_turned_drawing_gives_the_turned_shape(small_design: sm.Design) -> None:
    """Turned by 90°, the sheet's mesh changes, its height does not (to mesh accuracy)."""
    turned = small_design.with_values({"pattern.0.rotation": "60 deg"})
    a, b = sm.simulate(small_design), sm.simulate(turned)
    assert b.summary["height_m"] == pytest.approx(a.summary["height_m"], rel=0.05)
