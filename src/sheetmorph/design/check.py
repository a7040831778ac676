"""What a design amounts to, before anything is simulated: for `sheetmorph check`."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from sheetmorph.core.errors import InputError
from sheetmorph.design.actuation import covered_cells, edge_distance, thermal_strain
from sheetmorph.design.laminate import (
    LayerStack,
    mean_edge_length,
    published_stiffness,
    total_mass,
)
from sheetmorph.design.loads import gravity_forces, load_forces
from sheetmorph.design.meshing import hinge_orientation
from sheetmorph.design.regions import Regions, regions
from sheetmorph.design.sections import EVERYWHERE
from sheetmorph.design.supports import (
    directed_edges,
    held_components,
    held_nodes,
    perturbation_forces,
)
from sheetmorph.geometry.mesh import SheetMesh

if TYPE_CHECKING:
    from sheetmorph.design.spec import Design
    from sheetmorph.geometry.symmetry import Symmetry

POOR_ANGLE = math.radians(15.0)
AREA_MISMATCH = 0.15

_RUN = {"file_order": "as the file lists its edges", "away_from_pattern": "by the pattern"}


def describe(design: Design, mesh: SheetMesh | None = None) -> dict[str, Any]:
    """Numbers of a design in SI units, ready for JSON.

    Builds the mesh and every array that a simulation needs, so a design that passes here
    can be simulated.

    Args:
        design: the design.
        mesh: its mesh, when it is built already.

    Raises:
        InputError: the mesh, a curve or a support is not usable.
    """
    path = design.resolve_mesh_path()
    mesh = design.build_mesh() if mesh is None else mesh
    region = regions(design, mesh)
    strain = thermal_strain(design, mesh, region)
    held = held_components(design, mesh, region)
    loads = load_forces(design, mesh, region)
    forces = perturbation_forces(design, mesh)
    directed = len(directed_edges(design, mesh, region)[0])
    report = {
        "name": design.name,
        "model": design.model,
        "hash": design.hash,
        "mesh": _mesh_numbers(design, mesh) | {"source": "made" if path is None else path.name},
        "regions": _region_numbers(design, mesh, region),
        "plan": _plan_numbers(design),
        "mass": total_mass(mesh, region),
        "actuation": {
            "eps_pre": design.eps_pre,
            "eps_pre_scatter": design.eps_pre_scatter,
            "temperature": design.actuation.temperature,
            "table": design.actuation.radial_profile or design.actuation.field,
            "greatest_distance": (
                edge_distance(design, mesh, region)[1]
                if covered_cells(design, region).any() and not design.actuation.whole_sheet
                else None
            ),
            "strain_range": [float(strain.min()), float(strain.max())],
        },
        "supports": {
            "held_nodes": int(held.any(axis=1).sum()),
            "free_dofs": int((~held).sum())
            - (0 if held.any() else 3 if design.contact.table else 6)
            + (len(mesh.edges) - directed if design.laminate else 0),
        },
        "directed_edges": directed,
        "loads": {
            "count": len(design.loads),
            "net_force": loads.sum(axis=0).tolist(),
            "total_force": float(np.linalg.norm(loads, axis=1).sum()),
        },
        "gravity": _weight(design, mesh, region),
        "contact": {
            "self_contact": design.contact.self_contact,
            "table": design.contact.table,
        },
        "perturbation": {
            "shape": design.perturbation.shape,
            "total_force": float(np.abs(forces[:, 2]).sum()),
        },
    }
    return report | {"warnings": _warnings(design, mesh, report)}


def _weight(design: Design, mesh: SheetMesh, region: Regions) -> dict[str, Any] | None:
    """Weight and where it pulls; None without gravity."""
    if design.gravity is None:
        return None
    total = gravity_forces(design, mesh, region).sum(axis=0)
    return {"weight": float(np.linalg.norm(total)), "down": list(design.gravity.down)}


def _plan_numbers(design: Design) -> dict[str, Any]:
    layout = design.layout
    low_x, low_y, high_x, high_y = layout.sheet.bounds
    return {
        "size": [high_x - low_x, high_y - low_y],
        "area": layout.sheet.area,
        "holes": len(layout.sheet.interiors),
        "slits": len(layout.slits.geoms),
        "parts": {
            name: {"area": part.area, "pieces": len(part.geoms)}
            for name, part in layout.parts.items()
        },
        "notes": list(design.notes),
    }


def format_description(report: dict[str, Any]) -> str:
    """The dictionary of `describe` as lines for people."""
    mesh, actuation, support = report["mesh"], report["actuation"], report["supports"]
    plan = report["plan"]
    width, height = plan["size"]
    cuts = [
        f"{count} {what if count == 1 else f'{what}s'}"
        for what, count in (("hole", plan["holes"]), ("slit", plan["slits"]))
        if count
    ]
    sheet = f"{1e3 * width:.4g} × {_mm(height)}, {1e6 * plan['area']:.4g} mm²"
    counts = f"{mesh['nodes']} nodes, {mesh['edges']} edges, {mesh['triangles']} triangles"
    angle = math.degrees(mesh["smallest_angle"])
    lines = [
        f"{report['name']} ({report['model']} model), design {report['hash'][:12]}",
        _row("sheet", ", ".join([sheet, *cuts])),
        *(_row("note", note) for note in plan["notes"]),
        _row("mesh", f"{counts} ({mesh['source']})"),
        _row("", f"mean edge {_mm(mesh['mean_edge_length'])}, smallest angle {angle:.0f}°"),
        *([_row("", f"symmetry: {mesh['symmetry']}")] if mesh["symmetry"] else []),
    ]
    published = report["model"] == "published"
    if published:
        lines.append(_row("", f"hinges run {_RUN[mesh['hinge_orientation']]}"))
    for name, numbers in report["regions"].items():
        layers = " + ".join(numbers["layers"])
        stiffness = [f"D {numbers['flexural_rigidity']:.4g} N·m"]
        if published:
            stiffness.insert(0, f"k_s {numbers['stretching_stiffness']:.4g} J")
            stiffness.append(f"k_b {numbers['bending_stiffness']:.4g} J")
        else:
            stiffness.insert(0, f"Σ Y h {numbers['membrane_stiffness']:.4g} N/m")
        neutral = f"neutral plane at {_mm(numbers['neutral_height'])}"
        area = f"{1e6 * numbers['area']:.4g} mm²"
        lines.append(_row(name, f"{area} of {layers}, {_mm(numbers['thickness'])} thick"))
        lines.append(_row("", ", ".join(stiffness)))
        lines.append(_row("", neutral))
    heat, reach = actuation["temperature"], actuation["greatest_distance"]
    at = "" if heat is None else f" at {heat - 273.15:.4g} °C"
    scatter = actuation["eps_pre_scatter"]
    at = at if scatter is None else f" ± {scatter:.2g}{at}"
    far = "everywhere" if reach is None else f"reached {_mm(reach)} from the pattern"
    table = actuation["table"]
    what = "eps_pre" if table is None else f"strains of {table}, times"
    held = support["held_nodes"]
    free = "free to slide" if report["contact"]["table"] else "free sheet, rigid motions removed"
    holds = f"{held} nodes held" if held else free
    if report["directed_edges"]:
        holds += f", {report['directed_edges']} edges keep their normal"
    push, load = report["perturbation"], report["loads"]
    net = ", ".join(f"{part + 0.0:.3g}" for part in load["net_force"])
    lines += [
        _row("mass", f"{1e3 * report['mass']:.4g} g"),
        _row("actuation", f"{what} {actuation['eps_pre']:+.4g}{at}, {far}"),
        _row("supports", f"{holds}, {support['free_dofs']} degrees of freedom"),
        *(
            [_row("loads", f"{load['total_force']:.3g} N in all, net ({net}) N")]
            * bool(load["count"])
        ),
        *_around(report),
        _row("perturbation", f"{push['shape']}, {push['total_force']:.3g} N in all"),
    ]
    return "\n".join([*lines, *(_row("warning", warning) for warning in report["warnings"])])


def _around(report: dict[str, Any]) -> list[str]:
    rows = []
    if report["gravity"] is not None:
        x, y, z = report["gravity"]["down"]
        where = f"down is ({x:g}, {y:g}, {z:g})"
        rows.append(_row("gravity", f"{report['gravity']['weight']:.4g} N, {where}"))
    names = {"self_contact": "with itself", "table": "with a table"}
    known = [name for key, name in names.items() if report["contact"][key]]
    if known:
        rows.append(_row("contact", ", ".join(known)))
    return rows


def _row(label: str, text: str) -> str:
    return f"  {label:<12}  {text}"


def _mm(length: float) -> str:
    return f"{1e3 * length:.4g} mm"


def _mesh_numbers(design: Design, mesh: SheetMesh) -> dict[str, Any]:
    nodes, edges, triangles = mesh.counts
    lengths = mesh.edge_lengths
    return {
        "nodes": nodes,
        "edges": edges,
        "triangles": triangles,
        "hinges": len(mesh.hinges),
        "mean_edge_length": mesh.mean_edge_length,
        "edge_length_range": [float(lengths.min()), float(lengths.max())],
        "smallest_angle": float(mesh.minimum_angles.min()),
        "symmetry": (
            str(mesh_symmetry(design, mesh)) if design.spec.mesh.symmetry != "none" else None
        ),
        "hinge_orientation": hinge_orientation(design, design.resolve_mesh_path()),
    }


def _region_numbers(design: Design, mesh: SheetMesh, region: Regions) -> dict[str, Any]:
    stiffness = published_stiffness(design, mesh, region)
    l0, numbers = mean_edge_length(design, mesh), {}
    for index, cell in enumerate(region.cells):
        edges = region.edge_cell == index
        numbers[" + ".join(cell.parts) or "film"] = _stack_numbers(cell.stack, l0) | {
            "layers": [
                layer.name
                for layer in design.layers
                if layer.where == EVERYWHERE or layer.where in cell.parts
            ],
            "area": float(mesh.triangle_areas[region.triangle_cell == index].sum()),
            "edges": int(edges.sum()),
            "stretch_range": _range(stiffness.stretch[edges]),
        }
    return numbers


def _stack_numbers(stack: LayerStack, l0: float) -> dict[str, Any]:
    return {
        "thickness": stack.thickness,
        "neutral_height": stack.neutral_height,
        "membrane_stiffness": stack.membrane_stiffness,
        "stretching_stiffness": stack.stretching_stiffness(l0),
        "flexural_rigidity": stack.flexural_rigidity,
        "bending_stiffness": stack.bending_stiffness,
        "areal_mass": stack.areal_mass,
    }


def _range(values: np.ndarray[Any, np.dtype[np.float64]]) -> list[float]:
    return [float(values.min()), float(values.max())] if len(values) else []


def _symmetric_supports(design: Design, mesh: SheetMesh) -> bool:
    """False when a symmetry that mesh and design share moves a held node to a free one."""
    from sheetmorph.geometry.symmetry import node_images

    held = np.zeros(len(mesh.nodes), dtype=np.bool_)
    held[held_nodes(design, mesh, regions(design, mesh))] = True
    group = mesh_symmetry(design, mesh)
    return bool((held[node_images(mesh.nodes, group, 1e-9 * mesh.size)] == held).all())


def mesh_symmetry(design: Design, mesh: SheetMesh) -> Symmetry:
    """The largest part of a design's symmetry that its mesh has too."""
    from sheetmorph.geometry.symmetric_mesh import subgroups
    from sheetmorph.geometry.symmetry import Symmetry, node_images

    for group in subgroups(design.symmetry):
        try:
            node_images(mesh.nodes, group, 1e-9 * mesh.size)
        except InputError:
            continue
        return group
    return Symmetry(design.symmetry.centre, 1, None)


def _warnings(design: Design, mesh: SheetMesh, report: dict[str, Any]) -> list[str]:
    found = []
    poor = int((mesh.minimum_angles < POOR_ANGLE).sum())
    if poor:
        found.append(f"{poor} triangles have an angle below {math.degrees(POOR_ANGLE):.0f}°")
    if design.pattern and mesh.flat:
        wanted = design.pattern_polygon().area
        got = sum(part["area"] for name, part in report["regions"].items() if name != "film")
        if abs(got - wanted) > AREA_MISMATCH * wanted:
            areas = f"{1e6 * got:.4g} mm² instead of {1e6 * wanted:.4g} mm²"
            found.append(f"the mesh gives the pattern {areas}; a finer mesh follows it better")
    if report["plan"]["slits"] and design.spec.mesh.size is None:
        found.append("slits are not opened in a mesh from a file; its own edges decide")
    if design.spec.mesh.symmetry != "none" and not _symmetric_supports(design, mesh):
        found.append("the supports do not have the symmetry of the mesh, so the shape will not")
    soft = design.published.stretch_stiffness == "scaled_by_edge_length"
    if report["gravity"] is not None and report["model"] == "published" and soft:
        found.append(
            "gravity stretches this sheet too much: the released stiffness of its edges is scaled "
            'by their length in metres; published.stretch_stiffness = "printed" is not'
        )
    if report["actuation"]["eps_pre"] == 0 and not (design.loads or report["gravity"]):
        found.append("eps_pre is 0, so the sheet stays flat")
    return found
