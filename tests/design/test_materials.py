"""The library of materials, and layers that name one."""

from __future__ import annotations

import pytest

from sheetmorph.core.errors import InputError
from sheetmorph.design.materials import KINDS, find_material, layer_values, library
from sheetmorph.design.presets import PRESETS, preset_text
from sheetmorph.design.shrinkage import built_in_curve
from sheetmorph.design.spec import Design

PLA = 'young_modulus = "2.6733 MPa"\npoisson_ratio = 0.33\ndensity = "1250 kg/m^3"\n'


def test_every_value_has_a_source_and_lies_in_its_range():
    assert {"polystyrene", "PLA", "epoxy"} <= set(library())
    for material in library().values():
        assert material.role in ("active", "inert")
        assert {"young_modulus_room", "young_modulus", "poisson_ratio"} <= set(material.values())
        for value in material.values().values():
            assert len(value.source) > 15
            if value.low is not None and value.high is not None:
                assert value.low <= value.value <= value.high
        if material.shrink_curve is not None:
            assert built_in_curve(material.shrink_curve).eps_pre(300.0) == 0.0


def test_the_numbers_of_the_paper():
    film, print_, glue = (find_material(name) for name in ("polystyrene", "PLA", "epoxy"))
    for material in (film, print_):
        room, hot, poisson = material.young_modulus_room, material.young_modulus, 0.33
        assert room is not None and hot is not None
        effective = room.value / (1 - poisson**2)
        assert effective == pytest.approx(1e9 if material is film else 3e9, rel=1e-4)
        assert room.value == pytest.approx(1000 * hot.value)
        assert hot.assumed
    assert film.glass_temperature is not None and film.glass_temperature.value == 366.5
    assert film.density is not None and film.density.value == 1050.0
    assert print_.density is not None and print_.density.value == 1250.0
    assert glue.young_modulus_room is not None
    assert (glue.young_modulus_room.low, glue.young_modulus_room.high) == (1.5e9, 4e9)
    assert glue.poisson_ratio is not None
    assert (glue.poisson_ratio.low, glue.poisson_ratio.high) == (0.33, 0.43)


def test_a_layer_of_a_material_is_the_layer_of_its_values(base):
    assert PLA in base
    named = Design.from_toml(base.replace(PLA, 'material = "PLA"\n'))
    plain = Design.from_toml(base)
    layer = named.layers[1]
    assert (layer.young_modulus, layer.poisson_ratio, layer.density) == (2.6733e6, 0.33, 1250.0)
    assert layer.material == "PLA"
    assert named.hash == plain.hash
    assert Design.from_toml(base.replace(PLA, 'material = "epoxy"\n')).hash != plain.hash


def test_keys_of_the_layer_win_over_the_material(base):
    text = base.replace(PLA, 'material = "pla"\nyoung_modulus = "5 MPa"\n')
    layer = Design.from_toml(text).layers[1]
    assert (layer.young_modulus, layer.density) == (5e6, 1250.0)
    changed = Design.from_toml(text).with_values({"layers.PLA.material": "epoxy"})
    assert changed.layers[1].young_modulus == 5e6
    assert changed.layers[1].density == find_material("epoxy").density.value


def test_portable_text_holds_the_values(base, monkeypatch):
    text = base.replace(PLA, 'material = "PLA" # printed\ndensity = "1.3 g/cm^3"\n')
    design = Design.from_toml(text)
    portable = design.to_portable_toml()
    assert 'material = "PLA"' not in portable
    assert "of the material PLA" in portable
    # It is read where the library is another.
    monkeypatch.setattr("sheetmorph.design.sections.layer_values", lambda name: {})
    again = Design.from_toml(portable)
    assert again.layers[1].young_modulus == 2.6733e6
    assert again.layers[1].density == 1300.0
    assert again.hash == design.hash
    assert design.to_toml() == text


@pytest.mark.parametrize("name", PRESETS)
def test_presets_stay_as_they_are(name):
    assert "material =" not in preset_text(name, "try")
    assert Design.from_toml(preset_text(name, "try")).to_portable_toml() == preset_text(name, "try")


@pytest.mark.parametrize(
    ("line", "fragment"),
    [
        ('material = "PLAA"\n', r"layers\[1\].material: .*did you mean PLA\?.*polystyrene, PLA"),
        ('material = "poly-styrene"\n', "did you mean polystyrene"),
        ('material = "unobtainium"\n', "is not in the library of materials .*allowed: polystyrene"),
        ('material = ""\n', r"layers\[1\]"),
        ("material = 3\n", r"layers\[1\]"),
        ("", r"layers\[1\].young_modulus: is required, unless a material gives it"),
        ('materail = "PLA"\n', "did you mean material"),
    ],
)
def test_materials_that_are_refused(base, line, fragment):
    with pytest.raises(InputError, match=fragment) as caught:
        Design.from_toml(base.replace(PLA, line))
    assert "\n" not in str(caught.value)


def test_layers_are_given_what_a_file_could_say():
    for name in library():
        assert set(layer_values(name)) <= set(KINDS)
