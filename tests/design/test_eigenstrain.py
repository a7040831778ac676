"""The free strain of the laminate model on triangles and edges, and the keys that state it."""

from __future__ import annotations

import numpy as np
import pytest
from laminates import LAMINATE

from sheetmorph.core.errors import InputError
from sheetmorph.design.actuation import (
    edge_distance,
    edge_eigenstrain,
    thermal_strain,
    triangle_eigenstrain,
    triangle_share,
)
from sheetmorph.design.check import describe, format_description
from sheetmorph.design.radial import parse_radial
from sheetmorph.design.regions import regions
from sheetmorph.design.spec import Design

# SHA-256 of designs before the laminate model came; results on disk carry them.
HASHES = {
    "blank": "20f136d6777598aee4f91351b90bd93445359fc1a55e04fe2b6f6eea5a6e4c5f",
    "bowl": "05040510945f3e17c5bae31b17aa884b96740db4d9f435478eec508b49020702",
    "kirigami": "6661c3db10bbb4cd9b49c24280bd6fe5c5d12b70a014c3e0063386e6dc1f6393",
}
TABLE = "r [mm], e_radial, e_hoop\n0, 0.1, 0.1\n10, 0.2, 0.0\n30, 0.2, -20e-2\n"


def laminate(values=None, **actuation):
    values = dict(values or {})
    values |= {f"actuation.{key}": value for key, value in actuation.items()}
    return Design.from_toml(LAMINATE).with_values(values)


def strain(design, mesh):
    return triangle_eigenstrain(design, mesh, regions(design, mesh))


@pytest.mark.parametrize("name", HASHES)
def test_new_keys_with_their_defaults_leave_hashes_alone(name):
    from sheetmorph.design.presets import PRESETS, preset_text

    assert name in PRESETS
    assert Design.from_toml(preset_text(name)).hash == HASHES[name]


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("laminate.thickening", "none"),
        ("layers.0.eigenstrain_factor", 0.5),
        ("actuation.under_pattern", 0.5),
        ("actuation.transverse", 0.5),
    ],
)
def test_new_keys_with_other_values_change_the_hash(key, value):
    design = laminate()
    changed = design.with_values({key: value})
    assert changed.hash != design.hash
    assert changed.with_values({key: None}).hash == design.hash


def test_the_model_is_changed_by_its_name_alone(design):
    other = design.with_values({"model": "laminate"})
    assert other.laminate
    assert not design.laminate
    assert "published" not in other.spec.model_fields_set
    with pytest.raises(InputError, match="published: belongs to the published model"):
        design.with_values({"model": "laminate", "published.coupling": 0.5})


def test_linear_share_at_centroids(strip):
    design = laminate()
    region = regions(design, strip)
    x, y = strip.triangle_centroids.T
    away = np.hypot(np.maximum(np.abs(x) - 0.01, 0), np.maximum(np.abs(y) - 0.003, 0))
    expected = np.where(region.triangle_in_pattern, 0.0, away / np.hypot(0.010, 0.007))
    assert triangle_share(design, strip, region) == pytest.approx(expected, rel=1e-9, abs=1e-12)
    got = strain(design, strip)
    assert got[:, 0] == pytest.approx(-0.3 * expected, rel=1e-9, abs=1e-12)
    assert np.array_equal(got[:, 0], got[:, 1])
    assert not got[:, 2].any()


def test_bilayer_edges_measure_from_their_midpoints(strip):
    design = laminate(distance="bilayer_edges")
    region = regions(design, strip)
    middles = strip.edge_midpoints[region.edge_in_pattern]
    gaps = np.linalg.norm(strip.triangle_centroids[:, None] - middles[None], axis=2).min(axis=1)
    _, farthest = edge_distance(design, strip, region)
    expected = np.where(region.triangle_in_pattern, 0.0, np.minimum(gaps / farthest, 1.0))
    assert triangle_share(design, strip, region) == pytest.approx(expected, rel=1e-12)


def test_share_under_the_pattern(strip):
    plain, under = laminate(), laminate(under_pattern=0.25)
    region = regions(plain, strip)
    share, lifted = (triangle_share(design, strip, region) for design in (plain, under))
    assert lifted == pytest.approx(0.25 + 0.75 * share, rel=1e-14)
    assert set(lifted[region.triangle_in_pattern]) == {0.25}


def test_uniform_is_the_whole_sheet(strip):
    got = strain(laminate(profile="uniform"), strip)
    assert np.array_equal(got, np.tile([-0.3, -0.3, 0.0], (len(got), 1)))


def test_parts_of_active_layers_alone_are_no_pattern_to_keep_away_from(strip):
    design = laminate({"layers.1.role": "active", "layers.1.eigenstrain_factor": -1})
    region = regions(design, strip)
    assert region.triangle_in_pattern.any()
    assert set(triangle_share(design, strip, region)) == {1.0}
    assert design.inert_parts == ()
    stack = region.cells[1].stack
    assert stack.eigenstrain_factors.tolist() == [1.0, -1.0]


def test_inert_layers_everywhere_have_factor_zero():
    design = laminate({"layers.1.where": "everywhere", "pattern": None})
    from sheetmorph.design.laminate import film_stack

    assert film_stack(design).eigenstrain_factors.tolist() == [1.0, 0.0]


def test_orthotropic_strain_turns_with_its_direction(strip):
    got = strain(laminate(profile="uniform", transverse=-0.5, direction="30 deg"), strip)
    c, s = np.sqrt(3) / 2, 0.5
    along, across = -0.3, 0.15
    expected = [
        along * c * c + across * s * s,
        along * s * s + across * c * c,
        (along - across) * c * s,
    ]
    assert got == pytest.approx(np.tile(expected, (len(got), 1)), rel=1e-13)
    principal = np.linalg.eigvalsh([[got[0, 0], got[0, 2]], [got[0, 2], got[0, 1]]])
    assert principal == pytest.approx([-0.3, 0.15], rel=1e-13)


def test_radial_direction(strip):
    design = laminate(
        profile="uniform", transverse=0.0, direction="radial", centre='["5 mm", "-2 mm"]'
    )
    got = strain(design, strip)
    arms = strip.triangle_centroids - [0.005, -0.002]
    arms /= np.linalg.norm(arms, axis=1)[:, None]
    assert got[:, 0] == pytest.approx(-0.3 * arms[:, 0] ** 2, rel=1e-12, abs=1e-15)
    assert got[:, 1] == pytest.approx(-0.3 * arms[:, 1] ** 2, rel=1e-12, abs=1e-15)
    assert got[:, 2] == pytest.approx(-0.3 * arms[:, 0] * arms[:, 1], rel=1e-12, abs=1e-15)


def test_at_the_very_centre_both_directions_have_the_mean(strip):
    x, y = 1e3 * strip.triangle_centroids[7]
    design = laminate(
        profile="uniform",
        transverse=0.5,
        direction="radial",
        centre=[f"{float(v)!r} mm" for v in (x, y)],
    )
    assert strain(design, strip)[7] == pytest.approx([-0.225, -0.225, 0.0], rel=1e-9)


@pytest.fixture
def with_table(tmp_path):
    def make(text=TABLE, **values):
        (tmp_path / "growth.csv").write_text(text)
        (tmp_path / "strip.toml").write_text(LAMINATE)
        keys = {"profile": "radial", "radial_profile": "growth.csv", "eps_pre": None} | values
        return Design.load(
            tmp_path / "strip.toml", {f"actuation.{key}": v for key, v in keys.items()}
        )

    return make


def test_radial_table(with_table, strip):
    design = with_table()
    assert design.eps_pre == 1.0
    got = strain(design, strip)
    x, y = strip.triangle_centroids.T
    r = np.hypot(x, y)
    radial, hoop = parse_radial(TABLE, "growth").at(r)
    # Invariants: trace, determinant, and the strain along the radius.
    assert got[:, 0] + got[:, 1] == pytest.approx(radial + hoop, rel=1e-12)
    assert got[:, 0] * got[:, 1] - got[:, 2] ** 2 == pytest.approx(radial * hoop, abs=1e-12)
    quadratic = got[:, 0] * x * x + 2 * got[:, 2] * x * y + got[:, 1] * y * y
    assert quadratic / r**2 == pytest.approx(radial, rel=1e-12)
    half = strain(with_table(eps_pre=0.5), strip)
    assert half == pytest.approx(0.5 * got, rel=1e-14)


def test_radial_table_is_read_in_si_and_monotone():
    table = parse_radial(TABLE, "growth")
    assert table.radii.tolist() == pytest.approx([0.0, 0.01, 0.03])
    radial, hoop = table.at(np.array([0.0, 0.01, 0.02, 0.03]))
    assert radial[[0, 1, 3]] == pytest.approx([0.1, 0.2, 0.2])
    assert radial[2] == pytest.approx(0.2)  # no overshoot
    assert -0.2 < hoop[2] < 0.0


def test_the_hash_follows_the_table(with_table):
    before = with_table().hash
    assert with_table(TABLE.replace("0.2, 0.0", "0.3, 0.0")).hash != before


@pytest.mark.parametrize(
    ("text", "fragments"),
    [
        ("r [mm], e_radial\n0, 0\n1, 0\n", ["no column e_hoop"]),
        ("r, e_radial, e_hoop\n0, 0, 0\n1, 0, 0\n", ["line 1, column r", "unit in brackets"]),
        ("r [mm], e_radial, e_hop\n0, 0, 0\n", ["e_hop", "did you mean e_hoop?"]),
        (TABLE.replace("10,", "0,"), ["line 3: r must increase"]),
        (TABLE.replace("0.1, 0.1", "0.1, -1"), ["line 2, column e_hoop", "above -0.95 to 4"]),
        ("r [mm], e_radial, e_hoop\n0, 0, 0\n", ["at least two rows"]),
        (TABLE.replace("30,", "15,"), ["does not reach 2", "0 to 15 mm"]),
        (TABLE.replace("\n0,", "\n5,"), ["does not reach", "5 to 30 mm"]),
    ],
)
def test_broken_tables(with_table, strip, text, fragments):
    with pytest.raises(InputError) as caught:
        strain(with_table(text), strip)
    message = str(caught.value)
    assert "\n" not in message
    for fragment in fragments:
        assert fragment in message


def test_edges_have_the_mean_of_their_triangles(strip):
    rng = np.random.default_rng(5)
    uniform = np.tile([0.3, -0.2, 0.1], (len(strip.triangles), 1))
    d = np.diff(strip.nodes[strip.edges, :2], axis=1)[:, 0]
    d /= np.linalg.norm(d, axis=1)[:, None]
    expected = 0.3 * d[:, 0] ** 2 - 0.2 * d[:, 1] ** 2 + 0.2 * d[:, 0] * d[:, 1]
    assert edge_eigenstrain(strip, uniform) == pytest.approx(expected, rel=1e-12)
    values = rng.normal(size=len(strip.triangles))
    isotropic = np.column_stack([values, values, np.zeros_like(values)])
    got = edge_eigenstrain(strip, isotropic)
    for edge in (0, 17, len(strip.edges) - 1):
        beside = (strip.triangle_edges == edge).any(axis=1)
        assert got[edge] == pytest.approx(values[beside].mean(), rel=1e-12)


def test_thermal_strain_of_edges(strip):
    design = laminate(profile="uniform", transverse=0.0)
    got = thermal_strain(design, strip, regions(design, strip))
    d = np.diff(strip.nodes[strip.edges, :2], axis=1)[:, 0]
    assert got == pytest.approx(-0.3 * d[:, 0] ** 2 / (d**2).sum(axis=1), rel=1e-12, abs=1e-15)


FILM, PLA, EPS = 'name = "film"', 'name = "PLA"', "eps_pre = -0.3"
BROKEN = {
    "published": ("[mesh]", "[published]\ncoupling = 1.0\n[mesh]", ["published:", "laminate"]),
    "thickening": (
        "[mesh]",
        '[laminate]\nthickening = "volume"\n[mesh]',
        ["laminate.thickening", "did you mean volume_conserved?", "volume_conserved, none"],
    ),
    "laminate in published": (
        'model = "laminate"',
        'model = "published"\n[laminate]\nthickening = "none"',
        ["laminate: belongs to the laminate model"],
    ),
    "factor in published": (
        FILM,
        f"{FILM}\neigenstrain_factor = 0.5",
        ["layers[0].eigenstrain_factor: belongs to the laminate model", "0.5"],
        "published",
    ),
    "uniform in published": (
        EPS, f'{EPS}\nprofile = "uniform"', ["actuation.profile: belongs", "uniform"], "published",
    ),
    "share in published": (
        EPS, f"{EPS}\nunder_pattern = 0.5", ["actuation.under_pattern: belongs"], "published",
    ),
    "active part in published": (
        'role = "inert"', 'role = "active"', ["layers[1].where", "everywhere"], "published",
    ),
    "factor of an inert layer": (
        PLA,
        f"{PLA}\neigenstrain_factor = 0.5",
        ["layers[1].eigenstrain_factor", "no free strain", "role = active"],
    ),
    "factor too large": (FILM, f"{FILM}\neigenstrain_factor = 11", ["factor", "≤ 10"]),
    "factor text": (FILM, f'{FILM}\neigenstrain_factor = "1"', ["factor", "without quotes"]),
    "nothing everywhere": (
        FILM, f'{FILM}\nwhere = "pattern"', ["layers: no layer lies everywhere", "where = "],
    ),
    "share": (EPS, f"{EPS}\nunder_pattern = 1.5", ["actuation.under_pattern", "≤ 1"]),
    "share of uniform": (
        EPS,
        f'{EPS}\nprofile = "uniform"\nunder_pattern = 1.0',
        ["actuation.under_pattern", "does not depend on the pattern"],
    ),
    "gamma of uniform": (
        EPS, f'{EPS}\nprofile = "uniform"\ngamma = 1.0', ["actuation.gamma", "remove it"],
    ),
    "direction": (
        EPS,
        f'{EPS}\ntransverse = 0.5\ndirection = "radal"',
        ["actuation.direction", '"radial", or an angle from -360 deg to 360 deg'],
    ),
    "direction too far": (
        EPS, f'{EPS}\ntransverse = 0.5\ndirection = "400 deg"', ["actuation.direction", "radial"],
    ),
    "direction alone": (
        EPS, f'{EPS}\ndirection = "30 deg"', ["actuation.transverse", "such as 0.2"],
    ),
    "centre alone": (
        EPS, f'{EPS}\ncentre = ["1 mm", "1 mm"]', ["actuation.centre", "radial"],
    ),
    "radial without table": (EPS, 'profile = "radial"', ["actuation.radial_profile", "table"]),
    "table without radial": (
        EPS, f'{EPS}\nradial_profile = "a.csv"', ["actuation.radial_profile", "choose radial"],
    ),
    "temperature of radial": (
        EPS,
        'temperature = "150 degC"\nprofile = "radial"\nradial_profile = "a.csv"',
        ["actuation.temperature", "remove it"],
    ),
    "transverse of radial": (
        EPS,
        'transverse = 0.1\nprofile = "radial"\nradial_profile = "a.csv"',
        ["actuation.transverse", "both strains"],
    ),
}  # fmt: skip


@pytest.mark.parametrize("case", BROKEN)
def test_broken_laminates(case):
    old, new, fragments, *model = BROKEN[case]
    assert old in LAMINATE
    text = LAMINATE.replace(old, new, 1)
    if model:
        text = text.replace('model = "laminate"', f'model = "{model[0]}"')
    with pytest.raises(InputError) as caught:
        Design.from_toml(text)
    message = str(caught.value)
    for fragment in fragments:
        assert fragment in message
    assert "\n" not in message


@pytest.mark.parametrize(
    "values",
    [
        {"layers.0.eigenstrain_factor": 4.0},
        {"actuation.transverse": 10.0, "actuation.eps_pre": 0.9},
    ],
)
def test_strains_beyond_use(strip, values):
    with pytest.raises(InputError) as caught:
        strain(laminate(values), strip)
    message = str(caught.value)
    assert message.startswith("layers[0].eigenstrain_factor: a free strain of film")
    assert "above -0.95 to 4" in message


def test_check_names_the_table(with_table, strip):
    report = describe(with_table(eps_pre=0.5), strip)
    assert report["actuation"]["table"] == "growth.csv"
    assert "strains of growth.csv, times +0.5, everywhere" in format_description(report)
