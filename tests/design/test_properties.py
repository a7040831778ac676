"""Designs, by properties: files, hashes, patterns and meshes of whatever may be drawn."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import sheetmorph as sm
from sheetmorph.core.errors import InputError
from sheetmorph.design.presets import PRESETS, preset_text
from sheetmorph.geometry import surface

often = settings(deadline=None, max_examples=25, derandomize=True)

MILLIMETRES = st.integers(1, 99_999).map(lambda n: n / 1000)
BOWL = sm.Design.from_toml(preset_text("bowl", "bowl"))


@often
@given(st.sampled_from(PRESETS), st.integers(-94, 99), st.booleans())
def test_toml_there_and_back(name: str, percent: int, quantity: bool) -> None:
    eps = f"{percent} %" if quantity else percent / 100
    try:
        design = sm.Design.from_toml(preset_text(name, name)).with_values(
            {"actuation.eps_pre": eps}
        )
    except InputError as error:
        assert "\n" not in str(error)
        return
    again = sm.Design.from_toml(design.to_toml())
    assert again.spec == design.spec
    assert again.hash == design.hash
    assert sm.Design.from_toml(design.to_portable_toml()).hash == design.hash


@often
@given(st.sampled_from([0.3, 0.25, 0.125, 0.7]), st.sampled_from(["um", "mm", "cm", "m"]))
def test_the_hash_does_not_know_units_names_or_comments(thickness: float, unit: str) -> None:
    factor = {"um": 1000, "mm": 1, "cm": 0.1, "m": 0.001}[unit]
    plain = BOWL.with_values({"layers.0.thickness": f"{thickness} mm"})
    other = BOWL.with_values({"layers.0.thickness": f"{thickness * factor:.9f} {unit}"})
    renamed = other.with_values({"name": "another", "outputs.pictures": False})
    commented = sm.Design.from_toml("# a comment\n" + renamed.to_toml())
    assert plain.hash == other.hash == renamed.hash == commented.hash
    assert plain.hash != BOWL.with_values({"layers.0.thickness": "0.31 mm"}).hash


@settings(often, max_examples=8)
@given(
    arms=st.integers(1, 9),
    length=st.floats(15, 60),
    width=st.floats(2.5, 9),
    turn=st.floats(0, 360),
    kind=st.sampled_from(["disc", "rectangle", "regular_polygon"]),
)
def test_meshes_fill_the_sheet_with_good_triangles(
    arms: int, length: float, width: float, turn: float, kind: str
) -> None:
    outline = {
        "disc": 'radius = "40 mm"',
        "rectangle": 'width = "90 mm"\nheight = "60 mm"',
        "regular_polygon": 'radius = "45 mm"\nsides = 5',
    }[kind]
    head, layers = preset_text("bowl", "a").split("# The layers", maxsplit=1)
    text = head.split("[outline]", maxsplit=1)[0] + (
        f'[outline]\nkind = "{kind}"\n{outline}\n[[pattern]]\nkind = "star"\nclip = true\n'
        f'arms = {arms}\narm_length = "{length} mm"\nhalf_width = "{width} mm"\n'
        f'rotation = "{turn} deg"\n# The layers{layers}'
    )
    design = sm.Design.from_toml(text).with_values({"mesh.size": "6 mm"})
    mesh = design.build_mesh()
    sheet, pattern = design.outline_polygon().area, design.pattern_polygon().area
    assert mesh.triangle_areas.min() > 0.0
    assert mesh.triangle_areas.sum() == pytest.approx(sheet, rel=0.01)
    assert surface.smallest_angles(mesh.nodes, mesh.triangles).min() > np.deg2rad(8.0)
    from sheetmorph.design.regions import regions

    inside = regions(design, mesh).triangle_in_pattern
    assert mesh.triangle_areas[inside].sum() == pytest.approx(pattern, rel=0.1)
