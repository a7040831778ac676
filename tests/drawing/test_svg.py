# ruff: noqa: E501  (tables of markup read better in long lines)
from __future__ import annotations

import io
import math
import time

import numpy as np
import pytest
import resvg_py
import shapely
from matplotlib.image import imread

from sheetmorph.core.errors import InputError
from sheetmorph.drawing.colours import colour_hex

PI = math.pi


SPACES = 'xmlns="http://www.w3.org/2000/svg" xmlns:xlink="http://www.w3.org/1999/xlink"'


def page(body):
    return f'<svg {SPACES} width="100mm" height="80mm" viewBox="0 0 100 80">{body}</svg>'


# body, bounds of the area [mm], area [mm²]
SHAPES = {
    "rect": ('<rect x="10" y="5" width="20" height="30"/>', (10, 45, 30, 75), 600),
    "round rect": ('<rect x="0" y="0" width="20" height="30" rx="5"/>', (0, 50, 20, 80), 600 - (4 - PI) * 25),
    "rect as ellipse": ('<rect x="0" y="0" width="20" height="30" rx="99" ry="99"/>', (0, 50, 20, 80), PI * 150),
    "circle": ('<circle cx="20" cy="30" r="10"/>', (10, 40, 30, 60), PI * 100),
    "ellipse": ('<ellipse cx="20" cy="30" rx="10" ry="5"/>', (10, 45, 30, 55), PI * 50),
    "polygon": ('<polygon points="0,0 10,0 10,10"/>', (0, 70, 10, 80), 50),
    "polyline": ('<polyline points="0 0 10 0 10 10"/>', (0, 70, 10, 80), 50),
    "units": ('<rect width="1cm" height="10mm"/>', None, (10 * 96 / 25.4) ** 2),
    "percent": ('<rect width="50%" height="25%"/>', (0, 60, 50, 80), 1000),
    "relative path": ('<path d="m10 10h20v10h-20z"/>', (10, 60, 30, 70), 200),
    "two subpaths": ('<path d="M0 0h10v10h-10zm20 0h10v10h-10z"/>', (0, 70, 30, 80), 200),
    "half circle": ('<path d="M10 20A10 10 0 0 1 30 20z"/>', (10, 60, 30, 70), PI * 50),
    "large arc": ('<path d="M10 20a10 10 0 1 1 10 10z"/>', None, 0.75 * PI * 100 + 50),
    "flags together": ('<path d="M10 20a10 10 0 0110 -10L20 20z"/>', (10, 60, 20, 70), PI * 25),
    "small radius": ('<path d="M10 20A1 1 0 0 1 30 20z"/>', (10, 60, 30, 70), PI * 50),
    "turned ellipse": ('<path d="M20 10A20 10 90 0 1 20 50z"/>', (20, 30, 30, 70), PI * 100),
    "quadratic": ('<path d="M0 20Q10 0 20 20z"/>', (0, 60, 20, 70), 400 / 3),
    "smooth quadratic": ('<path d="M0 20Q10 0 20 20T40 20"/>', (0, 50, 40, 70), 800 / 3),
    "cubic": ('<path d="M0 20C0 0 20 0 20 20z"/>', (0, 60, 20, 75), 240),
    "smooth cubic": ('<path d="M0 20C0 0 20 0 20 20S40 40 40 20z"/>', (0, 45, 40, 75), 480),
    "nonzero": ('<path d="M0 0h20v20h-20zM5 5h10v10h-10z"/>', (0, 60, 20, 80), 400),
    "nonzero hole": ('<path d="M0 0h20v20h-20zM5 5v10h10v-10z"/>', (0, 60, 20, 80), 300),
    "evenodd": ('<path fill-rule="evenodd" d="M0 0h20v20h-20zM5 5h10v10h-10z"/>', (0, 60, 20, 80), 300),
    "crossing nonzero": ('<path d="M0 0h20v20h-20zM10 10h20v20h-20z"/>', (0, 50, 30, 80), 700),
    "crossing evenodd": ('<path fill-rule="evenodd" d="M0 0h20v20h-20zM10 10h20v20h-20z"/>', (0, 50, 30, 80), 600),
    "bow tie": ('<path d="M0 0L20 20V0L0 20z"/>', (0, 60, 20, 80), 200),
    "translate": ('<rect transform="translate(10 5)" width="10" height="10"/>', (10, 65, 20, 75), 100),
    "rotate": ('<rect transform="rotate(90,10,10)" width="10" height="5"/>', (15, 70, 20, 80), 50),
    "nested": ('<g transform="translate(10,10)"><g transform="scale(2 3)"><rect width="5" height="2"/></g></g>', (10, 64, 20, 70), 60),
    "matrix": ('<rect transform="matrix(1 0 .5 1 3 4)" width="10" height="10"/>', (3, 66, 18, 76), 100),
    "skew": ('<rect transform="skewX(45)" width="10" height="10"/>', (0, 70, 20, 80), 100),
    "mirror": ('<rect transform="translate(50) scale(-1,1)" width="10" height="10"/>', (40, 70, 50, 80), 100),
    "scaled circle": ('<circle transform="scale(.001)" cx="20000" cy="30000" r="10000"/>', (10, 40, 30, 60), PI * 100),
    "use": ('<defs><rect id="a" width="10" height="5"/></defs><use href="#a" x="10"/><use xlink:href="#a" transform="translate(30 30)"/>', (10, 45, 40, 80), 100),
    "use of a group": ('<defs><g id="a"><rect width="10" height="5"/><circle cx="50" cy="50" r="5"/></g></defs><use href="#a"/>', None, 50 + PI * 25),
    "symbol": ('<symbol id="a" viewBox="0 0 10 10"><rect width="10" height="10"/></symbol><use href="#a" x="5" width="20" height="40"/>', (5, 50, 25, 70), 400),
    "inner svg": ('<svg x="10" y="20" width="20" height="20" viewBox="0 0 2 2"><rect width="1" height="1"/></svg>', (10, 50, 20, 60), 100),
    "display none": ('<rect width="10" height="10"/><g display="none"><rect width="90" height="70"/></g>', (0, 70, 10, 80), 100),
    "hidden": ('<rect width="10" height="10"/><rect visibility="hidden" width="90" height="70"/>', (0, 70, 10, 80), 100),
    "contour": ('<rect fill="none" stroke="red" width="10" height="10"/><circle fill="none" stroke="red" cx="5" cy="5" r="2"/>', (0, 70, 10, 80), 100 - 4 * PI),
    "loose contour": ('<g fill="none" stroke="red"><path d="M0 0h10v10"/><line x1="10" y1="10.004"/></g>', None, 50),
}  # fmt: skip


@pytest.mark.parametrize("name", SHAPES)
def test_shapes(svg, name):
    body, bounds, area = SHAPES[name]
    found = svg(body, flatness=1e-7).area()
    assert found.area * 1e6 == pytest.approx(area, abs=0.02)
    if bounds is not None:
        assert np.array(found.bounds) * 1e3 == pytest.approx(bounds, abs=0.006)


@pytest.mark.parametrize("name", sorted(set(SHAPES) - {"contour", "loose contour"}))
def test_shapes_look_the_same_elsewhere(svg, name):
    body = SHAPES[name][0]
    area = svg(body).area()
    png = resvg_py.svg_to_bytes(svg_string=page(body), background="white", width=500, dpi=96)
    dark = 1.0 - imread(io.BytesIO(bytes(png)))[:, :, 0]
    assert dark.sum() * (0.1 / dark.shape[1]) ** 2 == pytest.approx(
        area.intersection(shapely.box(0, 0, 0.1, 0.08)).area, rel=6e-3
    )


@pytest.mark.parametrize("shortened", [0.0, 1e-12, 4e-9, 1e-6, 1e-3])
@pytest.mark.parametrize("sweep", [0, 1])
def test_arcs_of_nearly_half_a_turn(svg, shortened, sweep):
    # Files round their numbers; the centre of such an arc hangs by the square root of that.
    # Some libraries snap it to the chord, 1e-4 of the radius away.
    half = 40 * (1 - shortened)
    a, b = (50 + s * half * np.array([math.cos(0.3), math.sin(0.3)]) for s in (-1, 1))
    body = f'<path fill="none" stroke="red" d="M{a[0]} {a[1]}A40 40 0 0 {sweep} {b[0]} {b[1]}"/>'
    away = math.sqrt(40**2 - half**2) * (1 if sweep else -1)
    centre = 50 + away * np.array([-math.sin(0.3), math.cos(0.3)])
    points = shapely.get_coordinates(svg(body, flatness=1e-6).lines()) * 1e3
    radii = np.hypot(*(points - [centre[0], 80 - centre[1]]).T)
    assert np.abs(radii - 40).max() < 4e-6
    side = (points[len(points) // 2] - [50, 30]) @ [math.sin(0.3), math.cos(0.3)]
    assert side == pytest.approx(40 if sweep else -40, abs=2.0)


def test_flatness(svg):
    body = '<path d="M10 60C10 -20 90 -20 90 60z"/><path d="M0 70A40 9 20 0 1 60 70"/>'
    fine = svg(body, flatness=1e-8).area()
    for flatness in (1e-6, 5e-6, 1e-4):
        coarse = svg(body, flatness=flatness).area()
        assert 0.1 * flatness < coarse.hausdorff_distance(fine) < 1.02 * flatness


# page, unit asked for, bounds of <rect x="10" y="5" width="20" height="30"/> [mm]
PAGES = {
    "mm": ('width="100mm" height="80mm" viewBox="0 0 100 80"', None, (10, 45, 30, 75)),
    "cm": ('width="10cm" height="8cm" viewBox="0 0 100 80"', None, (10, 45, 30, 75)),
    "in": ('width="1in" height="1in" viewBox="0 0 50 50"', None, (5.08, 7.62, 15.24, 22.86)),
    "doubled": ('width="200mm" height="160mm" viewBox="0 0 100 80"', None, (20, 90, 60, 150)),
    "box elsewhere": ('width="100mm" height="80mm" viewBox="-20 -30 100 80"', None, (30, 15, 50, 45)),
    "width alone": ('width="100mm" viewBox="0 0 100 80"', None, (10, 45, 30, 75)),
    "pixels": ('width="96px" height="96"', None, (25.4 * 10 / 96, 25.4 * 61 / 96, 25.4 * 30 / 96, 25.4 * 91 / 96)),
    "box alone": ('viewBox="0 0 96 96"', None, (25.4 * 10 / 96, 25.4 * 61 / 96, 25.4 * 30 / 96, 25.4 * 91 / 96)),
    "box in mm": ('viewBox="0 0 100 80"', "mm", (10, 45, 30, 75)),
    "in units of": ('width="50mm" height="40mm" viewBox="0 0 100 80"', "cm", (100, 450, 300, 750)),
    "middle": ('width="200mm" height="80mm" viewBox="0 0 100 80"', None, (60, 45, 80, 75)),
    "left": ('width="200mm" height="80mm" viewBox="0 0 100 80" preserveAspectRatio="xMinYMin"', None, (10, 45, 30, 75)),
    "bottom": ('width="100mm" height="180mm" viewBox="0 0 100 80" preserveAspectRatio="xMidYMax meet"', None, (10, 45, 30, 75)),
    "slice": ('width="100mm" height="160mm" viewBox="0 0 100 80" preserveAspectRatio="xMinYMin slice"', None, (20, 90, 60, 150)),
    "none": ('width="100mm" height="160mm" viewBox="0 0 100 80" preserveAspectRatio="none"', None, (10, 90, 30, 150)),
    "origin": ('width="100mm" height="80mm" viewBox="0 0 100 80" data-sheetmorph-origin="-50 7.5"', None, (-40, 52.5, -20, 82.5)),
}  # fmt: skip


@pytest.mark.parametrize("name", PAGES)
def test_pages(svg, name):
    page, unit, bounds = PAGES[name]
    drawing = svg('<rect x="10" y="5" width="20" height="30"/>', page, unit=unit)
    assert np.array(drawing.area().bounds) * 1e3 == pytest.approx(bounds, abs=1e-9)
    assert ("96 in" in " ".join(drawing.notes)) == (name in ("pixels", "box alone"))


STYLED = """
<style>/* a comment */ .cut, g > path.x {{ fill: none; stroke: #F00 }} @media print {{ rect {{ fill: red }} }}
  #b {{ fill: rgb(0,0,255) }} rect {{ fill: lime }} .off {{ display: none }} g rect.deep {{ fill: teal !important }}
  rect:hover {{ fill: red }}</style>
<rect id="a" width="10" height="10"/><rect id="b" x="20" width="10" height="10"/>
<rect id="c" class="cut wide" x="40" width="10" height="10"/>
<rect id="d" class="cut" style="fill:#0f0;stroke:none" x="60" width="10" height="10"/>
<rect class="off" width="90" height="70"/>
<g><path class="x" d="M0 30h10v10h-10z"/><rect class="deep" style="fill:red" x="20" y="30" width="10" height="10"/></g>
<g fill="navy" inkscape:label="my layer" xmlns:inkscape="http://www.inkscape.org/namespaces/inkscape">
  <circle id="e" cx="50" cy="50" r="5"/><circle cx="70" cy="50" r="5" fill="inherit" stroke="currentColor" color="#123456"/></g>
""".replace("{{", "{").replace("}}", "}")  # fmt: skip


@pytest.mark.parametrize(
    ("select", "area"),
    [
        ("a", 100), ("b", 100), ("#0000ff", 100), ("BLUE", 100), ("lime", 200), ("#0F0", 200),
        ("cut", 200), ("wide", 100), ("red", 200), ("#f00", 200), ("teal", 100),
        ("my layer", 50 * PI), ("My Layer", 50 * PI), ("navy", 50 * PI), ("#123456", 25 * PI),
        ("x", 100), (None, 600 + 50 * PI),
    ],
)  # fmt: skip
def test_selection_and_styles(svg, select, area):
    drawing = svg(STYLED)
    assert drawing.area(select).area * 1e6 == pytest.approx(area, abs=0.4)
    assert sum("ignored" in note for note in drawing.notes) == 2


RULES = {
    "specificity": ("#a { fill: lime } .c { fill: red } rect { fill: blue }", "lime"),
    "order": (".c { fill: red } .d { fill: lime }", "lime"),
    "important": (".c { fill: lime !important } #a { fill: red !IMPORTANT; stroke: none }", "red"),
    "list": ("circle, .c, path { fill: lime }", "lime"),
    "child": ("g > rect { fill: lime } svg > rect { fill: red }", "lime"),
    "descendant": ("svg rect { fill: lime } circle rect { fill: red }", "lime"),
    "attribute": ("[id='a'] { fill: lime }", "lime"),
    "everything": ("* { fill: lime }", "lime"),
    "string": ("rect { font-family: '} rect { fill: red'; fill: lime }", "lime"),
    "damaged": ("rect { fill lime; fill: lime; fill } }} .c { }", "lime"),
    "comments": ("<!-- /* .c { fill: red } */ rect/**/{ fill /**/ : lime /**/ } -->", "lime"),
    "siblings": ("g + g rect, rect ~ rect { fill: red } rect { fill: lime }", "lime"),
    "colour of CSS": ("rect { fill: hwb(120 0% 0%) }", "lime"),
}  # fmt: skip


@pytest.mark.parametrize("name", RULES)
def test_style_rules(svg, name):
    rules, colour = RULES[name]
    body = '<g><rect id="a" class="c d" width="10" height="10"/></g>'
    drawing = svg(f"<style><![CDATA[{rules}]]></style>{body}")
    assert drawing.area(colour).area == pytest.approx(1e-4)


def test_rules_apply_where_a_copied_element_stands(svg):
    drawing = svg(
        '<style>.there rect { fill: red } .here rect { fill: lime }</style><g class="here">'
        '<rect id="a" width="9" height="9"/></g><g class="there"><use href="#a" x="20"/></g>'
    )
    assert drawing.area("lime").area == pytest.approx(162e-6)


def test_selection_that_matches_nothing(svg):
    drawing = svg(
        '<rect id="SHEET" width="10" height="10"/><rect id="PATTERN" width="9" height="9"/>'
    )
    with pytest.raises(InputError, match=r"did you mean 'SHEET'.*allowed: PATTERN, SHEET, #000000"):
        drawing.area("SHEETS")
    with pytest.raises(InputError, match=r"drawing\.svg"):
        drawing.lines("#fff")


# body, analytic area of the rib [mm²]
RIBS = {
    "butt": ('<path d="M10 10h20" stroke-width="2"/>', 40),
    "square": ('<path d="M10 10h20" stroke-width="2" stroke-linecap="square"/>', 44),
    "round": ('<path d="M10 10h20" stroke-width="2" stroke-linecap="round"/>', 40 + PI),
    "mitre": ('<path d="M10 10h20v20" stroke-width="2"/>', 80),
    "bevel": ('<path d="M10 10h20v20" stroke-width="2" stroke-linejoin="bevel"/>', 79.5),
    "round join": ('<path d="M10 10h20v20" stroke-width="2" stroke-linejoin="round"/>', 79 + PI / 4),
    "closed": ('<path d="M10 10h20v20h-20z" stroke-width="2"/>', 160),
    "beyond the limit": (
        '<path d="M10 10h20L10 12" stroke-width="1"/>',
        None,
    ),
    "circle": ('<circle cx="30" cy="30" r="10" stroke-width="2"/>', PI * (121 - 81)),
    "scaled": ('<path transform="scale(3)" d="M1 1h5" stroke-width="1"/>', 45),
    "scaled unevenly": ('<path transform="scale(1 3)" d="M1 1h5" stroke-width="1"/>', 15),
    "fixed width": ('<path transform="scale(1 3)" vector-effect="non-scaling-stroke" d="M1 1h5" stroke-width="1"/>', 5 * 25.4 / 96),
    "line": ('<line x1="10" y1="10" x2="30" y2="10" stroke-width="2"/>', 40),
    "dot": ('<path d="M10 10h20M50 50z" stroke-width="2" stroke-linecap="round"/>', 40 + 2 * PI),
    "group": ('<g stroke-width="1"><path d="M10 10h20"/><path d="M10 30h20"/></g>', 40),
}  # fmt: skip


@pytest.mark.parametrize("name", RIBS)
def test_ribs(svg, name):
    body, area = RIBS[name]
    body = f'<g fill="none" stroke="black">{body}</g>'
    found = svg(body).area(strokes=True)
    if area is not None:
        assert found.area * 1e6 == pytest.approx(area, rel=1e-3, abs=2e-2)
    if name == "fixed width":
        return  # the renderer does not know vector-effect
    png = resvg_py.svg_to_bytes(svg_string=page(body), background="white", width=1000, dpi=96)
    dark = 1.0 - imread(io.BytesIO(bytes(png)))[:, :, 0]
    assert dark.sum() * (0.1 / dark.shape[1]) ** 2 == pytest.approx(found.area, rel=1e-2)


def test_overlapping_paint_is_united_with_a_note(svg):
    drawing = svg('<rect width="20" height="20"/><rect x="10" y="10" width="20" height="20"/>')
    region = drawing.region()
    assert region.shape.area == pytest.approx(700e-6)
    assert region.notes == (
        "painted shapes overlap, first at (15, 65) mm, by 100 mm² in all: united",
    )


def test_what_is_left_out_is_noted(svg):
    drawing = svg(
        '<rect width="10" height="10" fill="url(#g)" clip-path="url(#c)"/><text x="5" y="10">A</text>'
        '<image id="photo" href="file:///etc/passwd" x="1" y="2" width="3" height="4"/>'
        '<use href="other.svg#a"/><use href="#nobody"/><path d="M0 0h9" stroke="red" stroke-dasharray="1 2"/>'
    )
    said = "\n".join(drawing.notes)
    for words in (
        "clip-path of <rect> was ignored",
        "the fill 'url(#g)' of <rect> is read as paint",
        "<text> at (5, 70) mm was ignored; turn it into paths",
        "<image> 'photo' at (1, 78) mm was ignored",
        "'other.svg#a' leads out of the file",
        "'#nobody' leads nowhere",
        "dashes of <path>",
    ):
        assert words in said


BROKEN = {
    "open contour": ('<path fill="none" stroke="red" d="M0 0h10v10l-10 -9.6"/>', r"ends at \(0, 80\) mm and \(0, 79.6\) mm are 0.4 mm apart.*allowed: gap of 0.01 mm"),
    "crosses itself": ('<path fill="none" stroke="red" d="M0 0L20 20V0L0 20z"/>', r"crosses itself at \(10, 70\) mm"),
    "two cross": ('<g fill="none" stroke="red"><path d="M0 0h20v20h-20z"/><path d="M10 10h20v20h-20z"/></g>', r"cross at \(20, 60\) mm|cross at \(10, 60\) mm|cross at \(20, 70\) mm"),
    "nothing": ("<g/>", "nothing that can be read"),
    "no area": ('<path d="M0 0h10"/>', "nothing closed|open contour"),
    "too small": ('<rect width=".1" height=".2"/>', r"0.2 mm high; did you draw in cm|0.2 mm high; did you"),
    "too large": ('<rect width="20000" height="1"/>', "20 m wide"),
    "path": ('<path id="p" d="M0 0h10 garbage"/>', "<path> 'p': the path cannot be read"),
    "flags": ('<path d="M0 0A9 9 0 2 1 9 9"/>', "cannot be read"),
    "path without numbers": ('<path d="M0 0h"/>', "cannot be read"),
    "numbers after z": ('<path d="M0 0h9v9z 5 5"/>', "cannot be read"),
    "digits of elsewhere": ('<path d="M0 0h\u0663v9z"/>', "cannot be read"),
    "transform cut off": ('<rect transform="scale(3" width="9" height="9"/><path d="M0 0x"/>', "cannot be read"),
    "path cut off": ('<path d="M0 0L1"/>', "ends within a segment"),
    "path without M": ('<path d="L1 1"/>', "does not start with M"),
    "infinite": ('<path d="M0 0L1e999 0 3 3z"/>', "not finite"),
    "far": ('<path d="M0 0L1e99 0 3 3z"/>', "out of bounds"),
    "transform": ('<rect transform="turn(3)" width="9" height="9"/>', "transform cannot be read"),
    "length": ('<rect width="9 apples" height="9"/>', "width is no length"),
    "use of itself": ('<g id="a"><use href="#a"/></g>', "contains itself"),
    "laughs": (
        '<g id="a0"><rect width="9" height="9"/></g>' + "".join(f'<g id="a{k}">' + f'<use href="#a{k - 1}"/>' * 10 + "</g>" for k in range(1, 12)),
        "too many elements",
    ),
    "many points": ('<circle transform="scale(1e9)" cx="0" cy="0" r="1e9"/>', "too many points"),
}  # fmt: skip


@pytest.mark.parametrize("name", BROKEN)
def test_broken(svg, name, monkeypatch):
    body, says = BROKEN[name]
    if name == "laughs":
        monkeypatch.setattr("sheetmorph.drawing.svg.MAX_COPIES", 300)
    with pytest.raises(InputError, match=says) as caught:
        svg(body).area()
    assert "\n" not in str(caught.value)


def chain(count, step):
    """A polygon around a circle that takes every step-th of its corners."""
    turn = 2 * PI * step * np.arange(count) / count
    xy = np.column_stack([50 + 40 * np.cos(turn), 40 + 30 * np.sin(turn)])
    return '<polygon points="' + " ".join(f"{x:.6f},{y:.6f}" for x, y in xy) + '"/>'


# body, what the refusal says
TOO_MUCH = {
    "elements": (lambda: "<rect/>" * 200_000, "too many elements; allowed: ≤ 100000"),
    "levels": (lambda: "<g>" * 1_000_000, "nested too deeply"),
    "levels that count": (lambda: "<g>" * 100 + "</g>" * 100, "nested too deeply"),
    "segments": (lambda: '<path d="M0 0' + "h1" * 200_001 + '"/>', "too many segments; allowed: ≤ 200000"),
    "arcs": (lambda: '<path d="M0 0' + "a1 1 0 011 2" * 200_001 + '"/>', "too many segments"),
    "points": (lambda: f'<polygon points="{"1 2 " * 260_000}"/>', "too long a list of numbers"),
    "corners": (lambda: chain(200_010, 1), "too many corners; allowed: ≤ 200000"),
    "corners that cross": (lambda: chain(20_011, 2), "crosses or touches itself has too many corners.*≤ 20000"),
    "rules": (lambda: "<style>" + "a,b{}" * 1100 + "</style>", "too many style rules"),
    "style": (lambda: f'<style>{" " * 2_200_000}</style>', "styles of the drawing are too long"),
    "deep style": (lambda: f'<rect style="fill:{"(" * 100_000}"/>', "too deeply nested"),
    "work": (
        lambda: "<style>" + "b * *{}" * 1900 + "</style>" + "<g>" * 60 + '<rect width="1"/>' * 50 + "</g>" * 60,
        "style selectors are too much work",
    ),
    "transform": (lambda: f'<rect transform="{"scale(1)" * 1000}"/>', "transform is too long"),
    "huge radius": (lambda: '<path d="M0 0A1e200 1e200 0 0 1 5 5z"/>', "too many points|arc that cannot be drawn|not finite"),
    "tiny radius": (lambda: '<path d="M0 0A1e-300 1e-300 0 0 1 5 5z"/>', "arc that cannot be drawn"),
    "huge control": (lambda: '<path d="M0 0C1e200 1e200 0 0 1 5z"/>', "too many points"),
}  # fmt: skip


@pytest.mark.parametrize("name", TOO_MUCH)
def test_bounds(svg, name):
    make, says = TOO_MUCH[name]
    body = make()
    begin = time.process_time()
    with pytest.raises(InputError, match=says):
        svg(body).area()
    assert time.process_time() - begin < (3.0 if name == "elements" else 6.0)


def test_arcs_without_a_radius_are_lines(svg):
    drawing = svg('<path d="M0 0A0 5 0 0 1 20 0 20 20 0 0 1 20 0V20z"/>')
    assert drawing.area().area == pytest.approx(200e-6)


def test_unite_contours_that_cross(svg):
    body = BROKEN["two cross"][0]
    region = svg(body).region(overlaps="union")
    assert region.shape.area == pytest.approx(700e-6)
    assert "united" in region.notes[0]


@pytest.mark.parametrize(
    "text",
    [
        '<!DOCTYPE svg [<!ENTITY a "aaaa"><!ENTITY b "&a;&a;">]><svg xmlns="http://www.w3.org/2000/svg">&b;</svg>',
        '<!DOCTYPE svg [<!ENTITY a SYSTEM "file:///etc/passwd">]><svg xmlns="http://www.w3.org/2000/svg">&a;</svg>',
        '<html/>', "no xml", "<svg", '<svg viewBox="0 0 0 0"/>', '<svg viewBox="a"/>', '<svg width="-1"/>',
        '<svg width="1e999"/>', '<svg data-sheetmorph-origin="nan 0"/>', '<svg data-sheetmorph-origin="1e9 0"/>',
    ],
)  # fmt: skip
def test_broken_pages(tmp_path, text):
    from sheetmorph.drawing.read import read_drawing

    path = tmp_path / "a.svg"
    path.write_text(text)
    with pytest.raises(InputError):
        read_drawing(path)


@pytest.mark.parametrize(
    ("text", "digits"),
    [
        ("Red", "#ff0000"), ("#abc", "#aabbcc"), ("#AABBCCdd", "#aabbcc"), ("#abc0", ""),
        ("rgb(100%, 0%, 40%)", "#ff0066"), ("rgba(1 2 3 / 0)", ""), ("hsl(120, 100%, 25%)", "#008000"),
        ("transparent", ""), ("apple", None), ("#abcde", None), ("rgb(1,2)", None),
    ],
)  # fmt: skip
def test_colours(text, digits):
    assert colour_hex(text) == digits
