"""Every way to get a design wrong: one line that names the key and what is allowed."""

from __future__ import annotations

import datetime
import tomllib

import pytest
from laminates import LAMINATE

from sheetmorph.core.errors import InputError
from sheetmorph.design.spec import Design

FILM = 'thickness = "0.3 mm"'
BAR = 'start = ["-10 mm", "0 mm"]\nend = ["10 mm", "0 mm"]\nhalf_width = "3 mm"'
BAR_KIND = f'kind = "bar"\n{BAR}'
SHEET = 'kind = "rectangle"\nwidth = "40 mm"\nheight = "20 mm"'
SQUARE = 'kind = "polygon"\nunit = "mm"\npoints = [[-9, -9], [9, -9], [9, 9], [-9, 9]]'
BOX = 'kind = "box"\nx = ["-5 mm", "5 mm"]\ny = ["-5 mm", "5 mm"]'
SUPPORTS = f"[[supports]]\n{BOX}\n"
PLA = 'role = "inert"\nthickness = "1.0 mm"'
SIZE = 'size = "2 mm"'

# (what to replace, by what, and every piece of text that the message must have)
BROKEN = {
    # names and structure
    "no name": ('name = "strip"\n', "", ["name: is required"]),
    "name a path": ('"strip"', '"../x"', ["name:", "'../x'", "letters, digits"]),
    "name too long": ('"strip"', f'"{"x" * 101}"', ["name:", "≤ 100 characters"]),
    "name a number": ('"strip"', "3", ["name: must be text in quotes"]),
    "name empty": ('"strip"', '""', ["name: must not be empty"]),
    "model unknown": ('"published"', '"publisched"', ["model:", "did you mean published?"]),
    "top key": ("[mesh]", "[messh]", ["messh: unknown key; did you mean mesh?", "allowed: name"]),
    "layer key": (FILM, f'{FILM}\nthicknes = "1 mm"', ["layers[0].thicknes", "mean thickness?"]),
    "key with a line end": (
        FILM,
        f'{FILM}\n"a\\nb" = 1',
        ["layers[0].", "unknown key", "thickness"],
    ),
    "table is a number": ("[mesh]\n" + SIZE, "", ["mesh: is required"]),
    "layers a table": ("[[layers]]", "[layers]", ["not valid TOML", "line 24, column"]),
    "outline a list": ("[outline]", "[[outline]]", ["outline: must be a table", "[outline]"]),
    # quantities
    "bare number": (FILM, "thickness = 0.3", ["layers[0].thickness", 'such as "0.3 mm"', "0.3)"]),
    "no unit": (FILM, 'thickness = "0.3"', ["layers[0].thickness", 'such as "0.3 mm"']),
    "wrong kind": (FILM, 'thickness = "3 MPa"', ["layers[0].thickness", '"MPa" is not a unit of']),
    "unknown unit": (FILM, 'thickness = "3 ell"', ["layers[0].thickness", '"ell" is not known']),
    "too thick": (FILM, 'thickness = "3 m"', ["layers[0].thickness", "'3 m'", "1 um to 10 cm"]),
    "negative": (FILM, 'thickness = "-1 mm"', ["layers[0].thickness", "1 um to 10 cm"]),
    "zero": (FILM, 'thickness = "0 mm"', ["layers[0].thickness", "1 um to 10 cm"]),
    "nan": (FILM, 'thickness = "nan mm"', ["layers[0].thickness", "write a length"]),
    "toml nan": ("poisson_ratio = 0.33", "poisson_ratio = nan", ["poisson_ratio", "finite"]),
    "power tower": (FILM, 'thickness = "9**9**9 mm"', ["layers[0].thickness", "write a length"]),
    "modulus zero": ('"0.8911 MPa"', '"0 Pa"', ["layers[0].young_modulus", "above 0 Pa"]),
    "modulus bare": ('"0.8911 MPa"', "1e6", ["layers[0].young_modulus", "write a pressure"]),
    "poisson one half": ("poisson_ratio = 0.33", "poisson_ratio = 0.5", ["poisson_ratio", "< 0.5"]),
    "poisson text": ("poisson_ratio = 0.33", 'poisson_ratio = "0.3"', ["without quotes"]),
    "poisson true": ("poisson_ratio = 0.33", "poisson_ratio = true", ["poisson_ratio", "True"]),
    "density": ('"1050 kg/m^3"', '"1050 kg"', ["layers[0].density", "write a density"]),
    # layers
    "no layers": ("layers", "layer", ["layer: unknown key; did you mean layers?"]),
    "role": ('role = "inert"', 'role = "dead"', ["layers[1].role", "'dead'", "active, inert"]),
    "where": ('"pattern"', '"patern"', ["layers[1].where", "did you mean pattern?", "everywhere"]),
    "active in pattern": (PLA, PLA.replace("inert", "active"), ["layers[1].where", "everywhere"]),
    "nothing active": ('role = "active"', 'role = "inert"', ["layers:", "nothing moves", "active"]),
    "same names": ('name = "PLA"', 'name = "film"', ["layers[1].name", "same name", "'film'"]),
    "no pattern layer": (
        'where = "pattern"',
        'where = "everywhere"',
        ["pattern:", "where = pattern"],
    ),
    # outline and pattern
    "outline kind": ('"rectangle"', '"rectangel"', ["outline.kind", "did you mean rectangle?"]),
    "outline no kind": ('kind = "rectangle"\n', "", ["outline.kind: is required"]),
    "outline missing": ('width = "40 mm"\n', "", ["outline.width: is required"]),
    "outline clip": (SHEET, f"{SHEET}\nclip = true", ["outline.clip: unknown key", "cutouts"]),
    "outline crosses": (
        SHEET,
        'kind = "polygon"\nunit = "mm"\npoints = [[0, 0], [50, 20], [50, 0], [0, 20]]',
        ["outline.points", "self-intersection at (25, 10) mm", "does not cross"],
    ),
    "outline flat": (
        SHEET,
        'kind = "polygon"\nunit = "mm"\npoints = [[0, 0], [50, 0], [20, 0]]',
        ["outline.points"],
    ),
    "outline two points": (
        SHEET,
        'kind = "polygon"\nunit = "mm"\npoints = [[0, 0], [50, 20]]',
        ["outline.points: has 2 entries", "≥ 3"],
    ),
    "outline hole outside": (
        SHEET,
        f"{SQUARE}\nholes = [[[30, 30], [40, 30], [40, 40]]]",
        ["outline.points", "hole lies outside shell"],
    ),
    "polygon unit": (
        SHEET,
        'kind = "polygon"\nunit = "MPa"\npoints = [[0, 0], [50, 0], [20, 10]]',
        ["outline.unit", '"MPa" is not a unit of length'],
    ),
    "polygon without unit": (
        SHEET,
        'kind = "polygon"\npoints = [[0, 0], [50, 0], [20, 10]]',
        ["outline.points[0][0]", "write a length"],
    ),
    "polygon point": (
        SHEET,
        'kind = "polygon"\nunit = "mm"\npoints = [[0], [50, 0], [20, 10]]',
        ["outline.points[0]", "needs two values", "[x, y]"],
    ),
    "pattern kind": ('"bar"', '"spyral"', ["pattern[0].kind", "did you mean spiral?"]),
    "pattern outside": (BAR, BAR.replace('"0 mm"', '"50 mm"'), ["pattern[0]", "outside the sheet"]),
    "pattern past edge": (
        BAR,
        BAR.replace('"10 mm"', '"25 mm"'),
        ["pattern[0]: reaches 5 mm past the edge", "clip = true"],
    ),
    "pattern everywhere": (
        BAR_KIND,
        'kind = "rectangle"\nwidth = "40 mm"\nheight = "20 mm"',
        ["pattern:", "covers the whole sheet"],
    ),
    "bar no length": (BAR, BAR.replace('"10 mm"', '"-10 mm"'), ["pattern[0].end", "no length"]),
    "bar width": ('half_width = "3 mm"', 'half_width = "0 mm"', ["half_width", "10 um to 10 m"]),
    "star arms": (
        BAR_KIND,
        'kind = "star"\narms = 0\narm_length = "8 mm"\nhalf_width = "1 mm"',
        ["pattern[0].arms", "≥ 1"],
    ),
    "star half an arm": (
        BAR_KIND,
        'kind = "star"\narms = 2.5\narm_length = "8 mm"\nhalf_width = "1 mm"',
        ["pattern[0].arms", "whole number"],
    ),
    "rotation": (
        BAR_KIND,
        'kind = "star"\narms = 4\narm_length = "8 mm"\nhalf_width = "1 mm"\nrotation = 45',
        ["pattern[0].rotation", 'write an angle with its unit, such as "45 deg"'],
    ),
    "too many shapes": (
        "[[pattern]]",
        f"[[pattern]]\n{BAR_KIND}\n" * 500 + "[[pattern]]",
        ["pattern: has 501 entries", "≤ 500"],
    ),
    # actuation
    "no actuation": ("eps_pre = -0.3", "", ["actuation.eps_pre", "eps_pre or temperature"]),
    "two actuations": (
        "eps_pre = -0.3",
        'eps_pre = -0.3\ntemperature = "150 degC"',
        ["actuation.temperature", "exclude each other"],
    ),
    "eps too small": ("eps_pre = -0.3", "eps_pre = -0.95", ["actuation.eps_pre", "-0.95 to 1"]),
    "eps too large": ("eps_pre = -0.3", "eps_pre = 1.5", ["actuation.eps_pre", "1.5", "to 1"]),
    "temperature": ("eps_pre = -0.3", "temperature = 150", ["actuation.temperature", "150 degC"]),
    "below zero": (
        "eps_pre = -0.3",
        'temperature = "-300 degC"',
        ["actuation.temperature", "0 K to 3000 K"],
    ),
    "profile": ('"linear"', '"linaer"', ["actuation.profile", "did you mean linear?", "step"]),
    "no gamma": ('"linear"', '"exponential"', ["actuation.gamma", "needs a gamma"]),
    "gamma unused": ('"linear"', '"linear"\ngamma = 1.0', ["actuation.gamma", "remove it"]),
    "gamma negative": ('"linear"', '"exponential"\ngamma = -1.0', ["actuation.gamma", "≥ 0"]),
    "distance": ('"bilayer_edges"', '"edges"', ["actuation.distance", "pattern_boundary"]),
    # supports and perturbation
    "support kind": ('"box"', '"bix"', ["supports[0].kind", "did you mean box?", "nodes, free"]),
    "box reversed": ('["-5 mm", "5 mm"]\ny', '["5 mm", "-5 mm"]\ny', ["supports[0].x", "smaller"]),
    "box one value": ('["-5 mm", "5 mm"]\ny', '["5 mm"]\ny', ["supports[0].x", "[x, y]"]),
    "negative node": (BOX, 'kind = "nodes"\nnodes = [-1]', ["supports[0].nodes[0]", "≥ 0"]),
    "free and held": (
        SUPPORTS,
        f'{SUPPORTS}\n[[supports]]\nkind = "free"\n',
        ["supports[1].kind", "remove one"],
    ),
    "free, uniform": (SUPPORTS, "", ["perturbation.shape", "'uniform'", "bowl"]),
    "two forces": (
        'force_per_node = "1e-6 N"',
        'force_per_node = "1e-6 N"\ntotal_force = "1 N"',
        ["perturbation.total_force", "exclude each other"],
    ),
    "force unit": ('"1e-6 N"', '"1e-6 kg"', ["perturbation.force_per_node", "write a force"]),
    # mesh
    "no mesh source": (SIZE, "", ["mesh.size", "file, reference_file"]),
    "two sources": (SIZE, f'{SIZE}\nfile = "a.msh"', ["mesh.file", "exclude each other"]),
    "unit of a size": (SIZE, f'{SIZE}\nunit = "mm"', ["mesh.unit", "its own unit"]),
    "mesh unit": (SIZE, 'file = "a.msh"\nunit = "km"', ["mesh.unit", "um, mm, cm, m, in"]),
    "too fine": (SIZE, 'size = "0.02 mm"', ["mesh.size", "500000", "mm for this sheet"]),
    "too coarse": (SIZE, 'size = "30 mm"', ["mesh.size", "≤ 10 mm"]),
    # options
    "stiffness form": (
        "coupling = 1.0",
        'stretch_stiffness = "scaled"',
        ["published.stretch_stiffness", "scaled_by_edge_length, printed"],
    ),
    "coupling": ("coupling = 1.0", 'coupling = "1"', ["published.coupling", "without quotes"]),
    "factor": ("coupling = 1.0", "stretch_factor = 0", ["published.stretch_factor", "> 0"]),
    "step": ("max_step = 0.2", "max_step = 1.2", ["solver.max_step", "≤ 1"]),
    "step order": (
        "max_step = 0.2",
        "max_step = 0.05\ninitial_step = 0.1",
        ["solver.initial_step", "min_step to max"],
    ),
    "solver": ("max_step = 0.2", 'linear_solver = "lu"', ["solver.linear_solver", "auto, mkl"]),
    "iterations": ("max_step = 0.2", "max_iterations = 0", ["solver.max_iterations", "≥ 1"]),
    "output": (
        "[solver]",
        '[outputs]\nreport = "yes"\n[solver]',
        ["outputs.report", "true or false"],
    ),
    # TOML itself
    "not toml": ("eps_pre = -0.3", "eps_pre = ", ["not valid TOML", "line 34, column 12"]),
    "twice": (SIZE, f"{SIZE}\n{SIZE}", ["not valid TOML", "line"]),
    "deep": (SIZE, f"size = {'[' * 5000}{']' * 5000}", ["nested too deeply"]),
    "long key": (SIZE, f"{'a.' * 5000}a = 1", ["too many parts"]),
    "huge number": (SIZE, f"size = {'9' * 5000}", ["number that cannot be read"]),
}


@pytest.mark.parametrize("case", BROKEN)
def test_broken_design(base, tmp_path, case):
    old, new, fragments = BROKEN[case]
    assert old in base
    file = tmp_path / "strip.toml"
    file.write_text(base.replace(old, new) if old == "layers" else base.replace(old, new, 1))
    with pytest.raises(InputError) as caught:
        Design.load(file)
    message = str(caught.value)
    assert message.startswith(f"{file}: ")
    for fragment in fragments:
        assert fragment in message
    assert "\n" not in message
    assert "pydantic" not in message
    assert len(message.removeprefix(str(file))) < 400


def test_the_unbroken_design_is_fine(base):
    assert Design.from_toml(base).name == "strip"


def test_counts_the_other_problems(base):
    text = base.replace('"0.3 mm"', "0.3").replace('"1.0 mm"', "1.0").replace('"2 mm"', "2")
    with pytest.raises(InputError) as caught:
        Design.from_toml(text)
    message = str(caught.value)
    assert message.startswith("layers[0].thickness: ")
    assert message.endswith("(and 2 more)")


def test_files_that_are_no_designs(tmp_path):
    with pytest.raises(InputError, match="there is no such file"):
        Design.load(tmp_path / "absent.toml")
    with pytest.raises(InputError, match="is a folder"):
        Design.load(tmp_path)
    with pytest.raises(InputError, match="cannot be read"):
        Design.load("a\0b")
    (tmp_path / "latin.toml").write_bytes(b'a = 1\nname = "\xe9"')
    with pytest.raises(InputError, match=r"not UTF-8 text \(line 2\)"):
        Design.load(tmp_path / "latin.toml")
    (tmp_path / "large.toml").write_text("# " + "x" * 5_000_001)
    with pytest.raises(InputError, match="too large"):
        Design.load(tmp_path / "large.toml")


ODD = (
    None, -1, 10**30, float("nan"), 1e308, True, "", "x", "1e300 mm", "a\nb", "x" * 5000, [], [[]],
    ["1 mm"], {}, {"kind": "polygon", "unit": [1], "points": 3}, {"kind": {}}, [{}],
    datetime.date(2020, 1, 1), {"a\nb": 1},
)  # fmt: skip


def places(data, path=()):
    """Paths of all entries, tables and lists included."""
    entries = data.items() if isinstance(data, dict) else enumerate(data)
    for key, value in entries:
        yield (*path, key)
        if isinstance(value, dict | list):
            yield from places(value, (*path, key))


LOADED = f"""{LAMINATE}
[laminate]
thickening = "none"
[[supports]]
kind = "box"
x = ["-20 mm", "-20 mm"]
y = ["-10 mm", "10 mm"]
z = ["0 mm", "0 mm"]
hold = ["x", "y"]
clamp = true
[[supports]]
kind = "symmetry"
plane = "y"
at = "-10 mm"
[[loads]]
kind = "point"
at = ["20 mm", "0 mm"]
force = ["0 N", "0 N", "1 N"]
[[loads]]
kind = "line"
x = ["20 mm", "20 mm"]
y = ["-10 mm", "10 mm"]
force_per_length = ["0 N/m", "0 N/m", "1 N/m"]
[[loads]]
kind = "area"
force_per_area = ["0 Pa", "0 Pa", "1 Pa"]
[[loads]]
kind = "weight"
gravity = "9.81 m/s^2"
direction = [0, 0, -1]
""".replace(
    "eps_pre = -0.3",
    """eps_pre = -0.3
under_pattern = 0.1
transverse = 0.2
direction = "radial"
centre = ["1 mm", "1 mm"]""",
).replace(
    'role = "active"',
    """role = "active"
eigenstrain_factor = 0.5""",
)


@pytest.mark.parametrize("model", ["published", "laminate"])
def test_any_value_at_any_place_is_fine_or_an_input_error(design, model):
    design = design if model == "published" else Design.from_toml(LOADED)
    for path in places(tomllib.loads(design.source)):
        key = ".".join(map(str, path))
        for value in ODD:
            try:
                assert len(design.with_values({key: value}).hash) == 64
            except InputError as error:
                assert "\n" not in str(error), (key, value)
                assert len(str(error)) < 450, (key, value)
                assert "cannot be used" not in str(error), (key, value)
