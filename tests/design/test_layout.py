"""The plan of a sheet: parts, booleans, copies, cutouts, cells and the faces they lie on."""

from __future__ import annotations

import math

import numpy as np
import pytest
import shapely

from sheetmorph.core.errors import InputError
from sheetmorph.design.laminate import stack_of
from sheetmorph.design.regions import cells, hinge_face, overlay, regions
from sheetmorph.design.spec import Design

LAYERS = """
[[layers]]
name = "film"
role = "active"
thickness = "0.3 mm"
young_modulus = "1 MPa"
"""
ACTUATION = """
[actuation]
eps_pre = -0.3

[mesh]
size = "4 mm"
"""


def inert(name: str, where: str, thickness: str = "0.5 mm") -> str:
    return (
        f'[[layers]]\nname = "{name}"\nrole = "inert"\nthickness = "{thickness}"\n'
        f'young_modulus = "3 MPa"\nwhere = "{where}"\n'
    )


def design_of(pattern: str, layers: str | None = None, outline: str = "") -> Design:
    sheet = outline or 'kind = "rectangle"\nwidth = "60 mm"\nheight = "40 mm"'
    stack = LAYERS + inert("PLA", "pattern") if layers is None else layers
    return Design.from_toml(f'name = "plan"\n[outline]\n{sheet}\n{pattern}\n{stack}{ACTUATION}')


def rectangle(width: float, height: float, x: float = 0.0, more: str = "") -> str:
    return (
        f'[[pattern]]\nkind = "rectangle"\nwidth = "{width} mm"\nheight = "{height} mm"\n'
        f'centre = ["{x} mm", "0 mm"]\n{more}\n'
    )


def test_operations_join_the_shapes_before_them():
    taken = design_of(rectangle(20, 20) + rectangle(10, 10, 0, 'operation = "difference"'))
    assert taken.pattern_polygon().area == pytest.approx(300e-6, rel=1e-12)
    assert len(taken.pattern_polygon().geoms[0].interiors) == 1
    common = design_of(rectangle(20, 20) + rectangle(20, 10, 10, 'operation = "intersection"'))
    assert common.pattern_polygon().area == pytest.approx(100e-6, rel=1e-12)
    refilled = design_of(
        rectangle(20, 20) + rectangle(10, 10, 0, 'operation = "difference"') + rectangle(4, 4)
    )
    assert refilled.pattern_polygon().area == pytest.approx(316e-6, rel=1e-12)


def test_mirror_and_arrays_copy_what_is_drawn():
    pair = design_of(rectangle(4, 10, 10, "mirror = {}"))
    assert pair.pattern_polygon().area == pytest.approx(80e-6, rel=1e-12)
    assert pair.pattern_polygon().bounds == pytest.approx((-0.012, -0.005, 0.012, 0.005))
    slanted = design_of(rectangle(4, 10, 10, 'mirror = { angle = "45 deg" }'))
    assert slanted.pattern_polygon().bounds == pytest.approx((-0.005, -0.005, 0.012, 0.012))
    grid = 'grid_array = { columns = 3, rows = 2, dx = "8 mm", dy = "12 mm" }'
    many = design_of(rectangle(4, 10, -20, grid))
    assert len(many.pattern_polygon().geoms) == 6
    assert many.pattern_polygon().area == pytest.approx(240e-6, rel=1e-12)
    turned = design_of(rectangle(4, 4, 10, "polar_array = { count = 6 }"))
    centres = np.array([part.centroid.coords[0] for part in turned.pattern_polygon().geoms])
    assert np.linalg.norm(centres, axis=1) == pytest.approx([0.01] * 6, rel=1e-12)
    both = design_of(rectangle(2, 2, 10, "mirror = {}\npolar_array = { count = 3 }"))
    assert len(both.pattern_polygon().geoms) == 6


def test_fillets_and_corner_radii():
    cross = '[[pattern]]\nkind = "star"\narms = 4\narm_length = "15 mm"\nhalf_width = "3 mm"\n'
    plain = design_of(cross).pattern_polygon().area
    r = 2e-3
    fillet = design_of(cross + 'fillet = "2 mm"').pattern_polygon().area
    assert fillet - plain == pytest.approx(4 * r**2 * (1 - math.pi / 4), rel=1e-3)
    cut = design_of(rectangle(20, 10, 0, 'corner_radius = "2 mm"')).pattern_polygon().area
    assert 200e-6 - cut == pytest.approx(4 * r**2 * (1 - math.pi / 4), rel=1e-3)
    sheet = 'kind = "rectangle"\nwidth = "60 mm"\nheight = "40 mm"\ncorner_radius = "5 mm"'
    rounded = design_of(cross, outline=sheet).outline_polygon()
    assert 2400e-6 - rounded.area == pytest.approx(4 * 25e-6 * (1 - math.pi / 4), rel=1e-3)
    assert rounded.bounds == pytest.approx((-0.03, -0.02, 0.03, 0.02), abs=1e-9)


def test_cutouts_and_slits_of_the_outline():
    sheet = (
        'kind = "regular_polygon"\nsides = 6\nradius = "30 mm"\nunit = "mm"\n'
        "slits = [[[-5, 15], [5, 15]], [[-5, -15], [5, -15]]]\n"
        '[[outline.cutouts]]\nkind = "disc"\nradius = "3 mm"\ncentre = ["-15 mm", "0 mm"]\n'
        "mirror = {}\n"
    )
    design = design_of(rectangle(10, 10), outline=sheet)
    hexagon = 1.5 * math.sqrt(3) * 0.03**2
    holes = 2 * math.pi * 0.003**2
    assert design.outline_polygon().area == pytest.approx(hexagon - holes, rel=1e-4)
    assert len(design.outline_polygon().interiors) == 2
    assert design.layout.slits.length == pytest.approx(0.02)


PARTS = '[[pattern]]\nkind = "disc"\nradius = "10 mm"\npart = "hub"\n' + rectangle(
    50, 6, 0, 'part = "rib"'
)


def test_layers_lie_in_their_parts():
    design = design_of(PARTS, inert("under", "hub") + LAYERS + inert("over", "rib", "1 mm"))
    film, *others = cells(design)
    assert film.parts == ()
    assert {cell.parts for cell in others} == {("hub",), ("rib",), ("hub", "rib")}
    by_parts = {cell.parts: cell for cell in others}
    assert by_parts["hub",].stack.face == -1
    assert by_parts["rib",].stack.face == 1
    assert by_parts["hub", "rib"].stack.thickness == pytest.approx(1.8e-3)
    rigidity = [cell.stack.flexural_rigidity for cell in others]
    assert rigidity == sorted(rigidity)
    total = shapely.union_all([cell.area for cell in others])
    assert total.area == pytest.approx(sum(cell.area.area for cell in others), rel=1e-9)
    under, over = design.inert_parts
    assert (under.name, under.face) == ("under", "bottom")
    assert (over.name, over.face) == ("over", "top")
    assert over.region.area == pytest.approx(300e-6, rel=1e-12)


def test_edges_between_cells_belong_to_the_stiffer_one():
    touching = rectangle(20, 20, -10, 'part = "thin"') + rectangle(20, 20, 10, 'part = "thick"')
    layers = LAYERS + inert("a", "thin", "0.2 mm") + inert("b", "thick", "1 mm")
    design = design_of(touching, layers)
    mesh = design.build_mesh()
    region = regions(design, mesh)
    seam = np.abs(mesh.edge_midpoints[:, 0]) < 1e-9
    seam &= np.abs(mesh.edge_midpoints[:, 1]) < 0.01
    assert seam.any()
    assert {region.cells[k].parts for k in region.edge_cell[seam]} == {("thick",)}
    areas = np.bincount(region.triangle_cell, mesh.triangle_areas)
    assert areas == pytest.approx([1600e-6, 400e-6, 400e-6], rel=1e-9)


def test_faces_of_hinges_follow_the_nearest_part():
    apart = rectangle(6, 30, -20, 'part = "above"') + rectangle(6, 30, 20, 'part = "below"')
    layers = inert("b", "below") + LAYERS + inert("a", "above")
    design = design_of(apart, layers)
    mesh = design.build_mesh()
    face = hinge_face(mesh, regions(design, mesh))
    x = mesh.edge_midpoints[mesh.hinge_edges[:, 0], 0]
    assert (face[x < -1e-6] == 1).all()
    assert (face[x > 1e-6] == -1).all()
    assert (face[np.abs(x) < 1e-9] == 0).all()
    balanced = design_of(rectangle(6, 30), inert("b", "pattern") + LAYERS + inert("a", "pattern"))
    mesh = balanced.build_mesh()
    assert stack_of(balanced, ["pattern"]).face == 0
    assert (hinge_face(mesh, regions(balanced, mesh)) == 0).all()
    bare = design_of("", LAYERS)
    mesh = bare.build_mesh()
    assert (hinge_face(mesh, regions(bare, mesh)) == 1).all()


def test_overlay_partitions_the_plane():
    discs = {str(k): shapely.Point(0.6 * k, 0).buffer(1.0) for k in range(4)}
    found = overlay(discs)
    assert sum(area.area for area in found.values()) == pytest.approx(
        shapely.union_all(list(discs.values())).area, rel=1e-12
    )
    for name, disc in discs.items():
        inside = [area.area for parts, area in found.items() if name in parts]
        assert sum(inside) == pytest.approx(disc.area, rel=1e-12)


ROUND = 'kind = "disc"\nradius = "30 mm"\n[[outline.cutouts]]\n'

BROKEN = {
    "part without layer": (
        design_of,
        (rectangle(9, 9) + rectangle(5, 5, 20, 'part = "rib"'),),
        ["pattern", "where = rib"],
    ),
    "layer without part": (
        design_of,
        (rectangle(9, 9), LAYERS + inert("PLA", "patern")),
        ["layers[1].where", "did you mean pattern?"],
    ),
    "difference first": (
        design_of,
        (rectangle(9, 9, 0, 'operation = "difference"'),),
        ["pattern[0].operation", "union"],
    ),
    "nothing left": (
        design_of,
        (rectangle(9, 9) + rectangle(10, 10, 0, 'operation = "difference"'),),
        ["pattern[1]", "nothing is left"],
    ),
    "radius too large": (
        design_of,
        (rectangle(9, 9, 0, 'corner_radius = "5 mm"'),),
        ["pattern[0].corner_radius", "nothing is left"],
    ),
    "too many copies": (
        design_of,
        (rectangle(9, 9, 0, 'grid_array = { columns = 50, rows = 50, dx = "1 mm" }'),),
        ["pattern[0].grid_array", "1000"],
    ),
    "copies outside": (
        design_of,
        (rectangle(9, 9, 0, 'grid_array = { columns = 5, dx = "20 mm" }'),),
        ["pattern[0]", "past the edge"],
    ),
    "cutout cuts in two": (
        design_of,
        (
            rectangle(9, 9, 20),
            None,
            ROUND + 'kind = "rectangle"\nwidth = "4 mm"\nheight = "70 mm"\n',
        ),
        ["outline.cutouts[0]", "into pieces"],
    ),
    "cutout outside": (
        design_of,
        (
            rectangle(9, 9),
            None,
            ROUND + 'kind = "disc"\nradius = "4 mm"\ncentre = ["50 mm", "0 mm"]\n',
        ),
        ["outline.cutouts[0]", "cuts nothing"],
    ),
    "slit without length": (
        design_of,
        (
            rectangle(9, 9),
            None,
            'kind = "disc"\nradius = "30 mm"\nunit = "mm"\nslits = [[[-20, 0], [-20, 0]]]',
        ),
        ["outline.slits[0]", "no length", "(-20, 0) mm"],
    ),
    "slits outside": (
        design_of,
        (
            rectangle(9, 9),
            None,
            'kind = "disc"\nradius = "30 mm"\nunit = "mm"\nslits = [[[-40, 0], [-50, 0]]]',
        ),
        ["outline.slits", "outside the sheet"],
    ),
    "drawing without folder": (
        design_of,
        ('[[pattern]]\nkind = "drawing"\nfile = "leaf.svg"\n',),
        ["pattern[0].file", "no folder"],
    ),
}


@pytest.mark.parametrize("case", BROKEN)
def test_broken_plans(case):
    make, arguments, fragments = BROKEN[case]
    with pytest.raises(InputError) as caught:
        make(*arguments)
    message = str(caught.value)
    assert "\n" not in message
    for fragment in fragments:
        assert fragment in message, message


def test_slits_are_cut_off_at_the_rim():
    sheet = (
        'kind = "rectangle"\nwidth = "60 mm"\nheight = "40 mm"\nunit = "mm"\n'
        "slits = [[[0, 12], [0, 25]], [[10, 12], [10, 20]]]\n"
    )
    design = design_of(rectangle(10, 10), outline=sheet)
    assert design.layout.slits.length == pytest.approx(0.016)
    (note,) = design.notes
    assert "5 mm past the edge" in note
    assert "(0, 22.5) mm" in note
    assert len(design.build_mesh().hinges) > 0


def test_pieces_beside_the_sheet_are_told():
    array = 'grid_array = { columns = 5, dx = "14 mm" }\nclip = true'
    design = design_of(rectangle(9, 9, 0, array))
    (note,) = design.notes
    assert "pattern[0]: 2 pieces of 162 mm² beside the sheet" in note
    assert len(design.pattern_polygon().geoms) == 3


def test_pieces_that_the_mesh_would_lose_are_refused():
    array = 'grid_array = { columns = 4, rows = 2, dx = "6 mm", dy = "6 mm" }\npart = "pads"'
    pads = rectangle(50, 6, 0, "") + rectangle(1.2, 1.2, -20, array).replace('"0 mm"]', '"8 mm"]')
    design = design_of(pads, LAYERS + inert("a", "pattern") + inert("b", "pads"))
    with pytest.raises(InputError, match=r"mesh\.size: is too coarse for the part pads: .* near"):
        design.with_values({"mesh.size": "8 mm"}).build_mesh()
    fine = design.with_values({"mesh.boundary_size": "1.2 mm"})
    region = regions(fine, fine.build_mesh())
    assert {cell.parts for cell in region.cells} == {(), ("pattern",), ("pads",)}


def test_errors_of_the_mesher_name_a_key():
    design = design_of(rectangle(58, 38, 0, 'operation = "union"'))
    with pytest.raises(InputError) as caught:
        design.with_values({"mesh.size": "7 mm"}).build_mesh()
    assert caught.value.key == "mesh.size"
