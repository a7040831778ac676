"""A result as the browser gets it: the same numbers as in the result."""

from __future__ import annotations

import numpy as np
import pytest

import sheetmorph as sm
from sheetmorph.studio.frames import arrays_of, head_of, pack
from sheetmorph.studio.scene import FIELDS, boundary_lines, scene
from sheetmorph.studio.tasks import coarse


@pytest.fixture(scope="module")
def shown(small_result: sm.Result):  # type: ignore[no-untyped-def]
    packet = pack(*scene(small_result, preview=False))
    return head_of(packet), arrays_of(packet)


def test_positions_and_states(small_result: sm.Result, shown) -> None:  # type: ignore[no-untyped-def]
    head, arrays = shown
    np.testing.assert_allclose(arrays["positions"], 1e3 * small_result.positions, atol=1e-5)
    np.testing.assert_array_equal(arrays["triangles"], small_result.mesh.triangles)
    assert head["actuation"] == pytest.approx(list(small_result.actuation))
    assert head["ratio"][-1] == pytest.approx(small_result.summary["aspect_ratio"])
    assert (np.diff(arrays["progress"]) > 0).all()


def test_fields_are_means_at_the_nodes(small_result: sm.Result, shown) -> None:  # type: ignore[no-untyped-def]
    head, arrays = shown
    assert set(head["fields"]) == set(FIELDS)
    mesh = small_result.mesh
    for node in (0, 17, len(mesh.nodes) - 1):
        beside = (mesh.edges == node).any(axis=1)
        wanted = 100 * small_result.strain[:, beside].mean(axis=1)
        np.testing.assert_allclose(arrays["field.strain"][:, node], wanted, atol=1e-4)
        at = (mesh.hinges == node).any(axis=1)
        angle = np.degrees(abs(small_result.dihedral[:, at])).mean(axis=1)
        np.testing.assert_allclose(arrays["field.angle"][:, node], angle, atol=1e-4)
    np.testing.assert_allclose(arrays["field.height"], 1e3 * small_result.height, atol=1e-5)


def test_energy_at_the_nodes_has_the_size_of_the_energy(small_result: sm.Result, shown) -> None:  # type: ignore[no-untyped-def]
    mesh = small_result.mesh
    share = np.bincount(
        mesh.triangles.ravel(), np.repeat(mesh.triangle_areas / 3, 3), minlength=len(mesh.nodes)
    )
    shown_energy = shown[1]["field.energy"][-1] @ share
    total = small_result.summary["energy_J"]
    assert shown_energy == pytest.approx(total["stretch"] + total["bend"], rel=0.35)


def test_lines_are_the_rim_and_the_boundary_of_the_pattern(small_result: sm.Result) -> None:
    mesh = small_result.mesh
    lines = boundary_lines(mesh, np.zeros(len(mesh.triangles), dtype=bool))
    rim = np.linalg.norm(mesh.nodes[lines], axis=2)
    np.testing.assert_allclose(rim, 20e-3, rtol=2e-3)
    more = boundary_lines(mesh, small_result.triangle_in_pattern)
    assert len(more) > len(lines) + 20


def test_the_laminate_model_is_shown_too(small_design: sm.Design) -> None:
    design = small_design.with_values(
        {"model": "laminate", "actuation.eps_pre": -0.02, "mesh.size": "4 mm"}
    )
    result = sm.simulate(design)
    head, arrays = scene(result, preview=True)
    assert head["numbers"]["status"] == "completed"
    assert arrays["field.energy"].shape == (len(head["actuation"]), len(result.mesh.nodes))
    assert np.isfinite(arrays["field.energy"]).all()


def test_a_preview_is_coarser_and_never_finer(small_design: sm.Design) -> None:
    fine = small_design.with_values({"mesh.size": "1 mm", "mesh.boundary_size": "0.5 mm"})
    preview = coarse(fine)
    assert preview.spec.mesh.size == pytest.approx(2.36e-3, rel=0.02)
    assert preview.spec.mesh.boundary_size == pytest.approx(1.18e-3, rel=0.02)
    assert coarse(small_design) is small_design
