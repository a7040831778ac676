"""Designs that can be computed but not made."""

from __future__ import annotations

from pathlib import Path

import pytest

from sheetmorph.core.errors import InputError
from sheetmorph.design.presets import preset_text
from sheetmorph.design.spec import Design
from sheetmorph.fabricate.package import fabricate_design

PETALS = preset_text("petals", "petals").replace('model = "published"', 'model = "laminate"')
ACTUATION = PETALS[PETALS.index("[actuation]") : PETALS.index("[[supports]]")]
WEIGHED = PETALS.replace(ACTUATION, '[[loads]]\nkind = "weight"\n')


@pytest.mark.parametrize(
    ("text", "key"),
    [
        (WEIGHED.replace('role = "active"', 'role = "inert"'), "layers"),
        (PETALS.replace('role = "inert"', 'role = "active"'), "layers[1].where"),
        (
            PETALS.replace('profile = "linear"', 'profile = "radial"\nradial_profile = "r.csv"'),
            "actuation.profile",
        ),
        (PETALS.replace('size = "5.8 mm"', 'file = "m.txt"\ncurved = true'), "mesh.curved"),
    ],
    ids=["no film", "film in a part", "radial table", "curved"],
)
def test_what_cannot_be_made_is_refused(text: str, key: str, tmp_path: Path) -> None:
    (tmp_path / "r.csv").write_text("r [mm],e_radial,e_hoop\n0,0,0\n90,-0.3,-0.3\n", "utf-8")
    design = Design.from_toml(text, tmp_path)
    with pytest.raises(InputError) as error:
        fabricate_design(design, tmp_path / "out")
    assert error.value.key == key
    assert not (tmp_path / "out").exists()


def test_a_laminate_design_is_made_as_any_other(tmp_path: Path) -> None:
    package = fabricate_design(Design.from_toml(PETALS), tmp_path / "out")
    assert any(path.suffix == ".3mf" for path in package.files)
