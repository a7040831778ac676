"""A symmetric design on a symmetric mesh takes a symmetric shape."""

from __future__ import annotations

import numpy as np
import pytest

import sheetmorph as sm
from sheetmorph.design.presets import preset_text
from sheetmorph.geometry.symmetry import node_images


@pytest.mark.parametrize("name", ["petals", "blank"])
def test_the_shape_has_the_symmetry_of_the_design(name: str) -> None:
    design = sm.Design.from_toml(preset_text(name))
    result = sm.simulate(design.with_values({"mesh.symmetry": "auto"}))
    assert result.status == "completed"
    group, shape = design.symmetry, result.positions[-1]
    assert group.elements >= 4
    counterpart = node_images(result.mesh.nodes, group, 1e-9)
    images = group.images(shape)
    if not len(result.held_nodes):  # a free sheet lies where its rigid motions were taken out
        shape = shape - shape.mean(axis=0)
        images = group.images(shape)
    assert result.summary["height_m"] > 5e-3
    assert np.abs(images - shape[counterpart]).max() < 1e-9


def test_the_usual_mesh_is_not_symmetric() -> None:
    design = sm.Design.from_toml(preset_text("petals"))
    with pytest.raises(sm.InputError):
        node_images(design.build_mesh().nodes, design.symmetry, 1e-6)
