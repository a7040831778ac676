"""A result as the browser draws it: shapes, fields at the nodes, lines, numbers."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from scipy.sparse import csr_array

from sheetmorph.design.laminate import total_mass
from sheetmorph.geometry import surface
from sheetmorph.geometry.mesh import Floats, Ints, SheetMesh
from sheetmorph.show.fields import clock_of, pick_states

if TYPE_CHECKING:
    from sheetmorph.study.result import Result

MOST_STATES = 40
"""More states than this are thinned for the slider."""
UNLOADING = 0.05
"""Part of the slider on which the perturbation load is taken off, to that of the actuation."""
ROBUST = 99.0
"""Percentile of the values at which a scale ends, so that a few corners do not take it all."""


@dataclass(frozen=True)
class Field:
    """How a field is told and coloured.

    Attributes:
        label: for people.
        unit: shown with its numbers.
        scale: from SI to that unit.
        diverging: zero is the middle of its colours.
    """

    label: str
    unit: str
    scale: float = 1.0
    diverging: bool = False


FIELDS = {
    "height": Field("Height z", "mm", 1e3),
    "angle": Field("Fold angle |θ|", "°", 180.0 / np.pi),
    "strain": Field("Strain", "%", 100.0, True),
    "thermal": Field("Thermal strain", "%", 100.0, True),
    "energy": Field("Energy density", "J/m²"),
    "mean": Field("Mean curvature", "1/m", 1.0, True),
    "gauss": Field("Gaussian curvature", "1/m²", 1.0, True),
}
"""Fields of a sheet, by their names in packets."""


def scene(result: Result, *, preview: bool) -> tuple[dict[str, Any], dict[str, Any]]:
    """Head and arrays of the packet that shows a result.

    Lengths are in mm. Every field has a row per state and a column per node.

    Args:
        result: what was computed.
        preview: it is that of a coarse mesh, to be followed by a finer one.
    """
    clock, load = clock_of(result)
    states = list(range(len(clock)))
    if len(states) > MOST_STATES:
        states = pick_states(clock, load, MOST_STATES)
    mesh = result.mesh
    fields = {name: values[states] for name, values in _fields(result).items()}
    head = {
        "preview": preview,
        "name": result.design.name,
        "fields": {name: _told(name, values) for name, values in fields.items()},
        "time": None if result.motion is None else [float(t) for t in result.motion.time[states]],
        "actuation": [float(value) for value in result.actuation[states]],
        "ratio": [float(value) for value in result.aspect_ratio[states]],
        "numbers": numbers(result),
    }
    progress = clock[states] + UNLOADING * (load[0] - load[states])
    arrays = {
        "positions": 1e3 * result.positions[states],
        "triangles": mesh.triangles,
        "pattern": result.triangle_in_pattern,
        "lines": boundary_lines(mesh, result.triangle_in_pattern),
        "edges": mesh.edges,
        "held": result.held_nodes,
        "progress": progress,
        **{f"field.{name}": values for name, values in fields.items()},
    }
    return head, arrays


def numbers(result: Result) -> dict[str, Any]:
    """What is always on show."""
    summary = result.summary
    return {
        "status": summary["status"],
        "reached": summary["actuation_reached"],
        "detail": summary["detail"],
        "remedy": summary["remedy"],
        "stable": bool(summary["stable"]),
        "negative_pivots": summary["negative_pivots"],
        "aspect_ratio": summary["aspect_ratio"],
        "height_mm": 1e3 * summary["height_m"],
        "width_mm": 1e3 * float(surface.in_plane_width(result.positions[-1])),
        "mass_g": 1e3 * total_mass(result.mesh, result.regions),
        "energy_mJ": 1e3 * summary["energy_J"]["total"],
        "seconds": summary["seconds"]["wall"],
        "nodes": summary["nodes"],
        "triangles": summary["triangles"],
        "states": summary["states"],
    }


def _fields(result: Result) -> dict[str, Floats]:
    """The fields at the nodes, shape (S, V), in the units in which they are shown."""
    mesh = result.mesh
    edges, hinges = _mean_of(mesh.edges, mesh), _mean_of(mesh.hinges, mesh)
    triangles = _mean_of(mesh.triangles, mesh)
    parts = result.stretch_energy_density, result.bend_energy_density
    at = (triangles, triangles) if result.design.laminate else (edges, hinges)
    energy = sum((_spread(mean, part) for mean, part in zip(at, parts, strict=True)), start=0.0)
    values = {
        "height": result.height,
        "angle": _spread(hinges, np.abs(result.dihedral)),
        "strain": _spread(edges, result.strain),
        "thermal": _spread(edges, result.thermal_strain),
        "energy": np.asarray(energy),
        "mean": result.mean_curvature,
        "gauss": result.gaussian_curvature,
    }
    return {name: FIELDS[name].scale * values[name] for name in FIELDS}


def _mean_of(groups: Ints, mesh: SheetMesh) -> csr_array:
    """The matrix (V, G) that takes values of groups of nodes to their means at each node."""
    count, width = groups.shape
    if count == 0:
        return csr_array((len(mesh.nodes), 1))
    rows, columns = groups.ravel(), np.repeat(np.arange(count), width)
    number = np.maximum(np.bincount(rows, minlength=len(mesh.nodes)), 1)
    return csr_array((1.0 / number[rows], (rows, columns)), shape=(len(mesh.nodes), count))


def _spread(mean: csr_array, values: Floats) -> Floats:
    if values.shape[1] == 0:
        values = np.zeros((len(values), 1))
    return np.asarray((mean @ values.T).T)


def _told(name: str, values: Floats) -> dict[str, Any]:
    """Label, unit and range of a field."""
    field = FIELDS[name]
    size = np.abs(values[-1])
    top = float(np.percentile(size, ROBUST)) if field.diverging else float(values.max(initial=0.0))
    if name in ("angle", "energy"):
        top = float(np.percentile(size, ROBUST))
    low = -top if field.diverging else min(0.0, float(values.min(initial=0.0)))
    if name == "height" and -low > top:
        top = max(top, 0.0)
    if not top > low:
        low, top = (-1.0, 1.0) if field.diverging else (0.0, 1.0)
    return {
        "label": field.label,
        "unit": field.unit,
        "low": low,
        "high": top,
        "diverging": field.diverging,
    }


def boundary_lines(mesh: SheetMesh, in_pattern: Any) -> Ints:
    """Edges on the rim and along the pattern's boundary, as pairs of nodes, shape (n, 2)."""
    sides = mesh.triangle_edges.ravel()
    inside = np.repeat(np.asarray(in_pattern, dtype=np.int64), 3)
    met = np.bincount(sides, minlength=len(mesh.edges))
    of_pattern = np.bincount(sides, inside, minlength=len(mesh.edges))
    return np.asarray(mesh.edges[(met == 1) | (of_pattern == 1)])
