"""The numbers of a result as text with units, for the report."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from sheetmorph.show.style import signed

if TYPE_CHECKING:
    from sheetmorph.study.result import Result


@dataclass(frozen=True)
class Row:
    """One number: what it is, its text, its unit."""

    label: str
    value: str
    unit: str = ""


@dataclass(frozen=True)
class Table:
    """Numbers that belong together."""

    title: str
    rows: list[Row]


@dataclass(frozen=True)
class Banner:
    """How the run ended, in words."""

    good: bool
    title: str
    lines: list[str]


_TABLES: tuple[tuple[str, tuple[tuple[str, str, float, str], ...]], ...] = (
    (
        "Shape",
        (
            ("Height", "height_m", 1e3, "mm"),
            ("Extent along x", "bbox_m.0", 1e3, "mm"),
            ("Extent along y", "bbox_m.1", 1e3, "mm"),
            ("Extent along z", "bbox_m.2", 1e3, "mm"),
            ("Height over largest width, h/d", "aspect_ratio", 1.0, ""),
            ("Actuation eps_pre", "eps_pre", 1.0, ""),
            ("Fraction of it reached", "actuation_reached", 1.0, ""),
        ),
    ),
    (
        "Energy of the last state",
        (
            ("Stretching", "energy_J.stretch", 1e3, "mJ"),
            ("Bending", "energy_J.bend", 1e3, "mJ"),
            ("Load", "energy_J.load", 1e3, "mJ"),
            ("Weight", "energy_J.weight", 1e3, "mJ"),
            ("Table", "energy_J.table", 1e3, "mJ"),
            ("Contact with itself", "energy_J.self_contact", 1e3, "mJ"),
            ("Total", "energy_J.total", 1e3, "mJ"),
        ),
    ),
    (
        "Motion",
        (
            ("Integrator", "motion.integrator", 1.0, ""),
            ("Time at the end", "motion.time_s", 1.0, "s"),
            ("Steps", "motion.steps", 1.0, ""),
            ("Steps tried again", "motion.rejected_steps", 1.0, ""),
            ("At rest", "motion.at_rest", 1.0, ""),
            ("Mass", "motion.mass_kg", 1e3, "g"),
            ("Highest speed", "motion.fastest_m_per_s", 1.0, "m/s"),
            ("Largest kinetic energy", "motion.kinetic_peak_J", 1e3, "mJ"),
            ("Work of the actuation", "motion.actuation_work_J", 1e3, "mJ"),
            ("Work of the loads", "motion.load_work_J", 1e3, "mJ"),
            ("Taken by damping", "motion.damped_J", 1e3, "mJ"),
            ("Taken by the steps in time", "motion.numerical_J", 1e3, "mJ"),
        ),
    ),
    (
        "Around the sheet",
        (
            ("Weight", "weight_N", 1e3, "mN"),
            ("Borne by the table", "table.reaction_N", 1e3, "mN"),
            ("Nodes on the table", "table.nodes_in_contact", 1.0, ""),
            ("Lowest node above the table", "table.lowest_m", 1e3, "mm"),
            ("Parts apart by more than", "self_contact.1.gap_m", 1e3, "mm"),
            ("Touches itself", "self_contact.1.touches", 1.0, ""),
            ("Pairs of triangles that cross", "crossing_pairs", 1.0, ""),
        ),
    ),
    (
        "Equilibrium",
        (
            ("Negative pivots of the Hessian", "negative_pivots", 1.0, ""),
            ("Largest residual force", "residual_max_N", 1.0, "N"),
            ("Tolerance of it", "residual_tolerance_N", 1.0, "N"),
            ("Nodes", "nodes", 1.0, ""),
            ("Edges", "edges", 1.0, ""),
            ("Triangles", "triangles", 1.0, ""),
        ),
    ),
    (
        "Solver",
        (
            ("Linear solver", "solver", 1.0, ""),
            ("States", "states", 1.0, ""),
            ("Newton iterations", "newton_iterations", 1.0, ""),
            ("Factorisations", "factorisations", 1.0, ""),
            ("Assembly", "seconds.assembly", 1.0, "s"),
            ("Factorisation", "seconds.factorise", 1.0, "s"),
            ("Back substitution", "seconds.solve", 1.0, "s"),
            ("Solver in all", "seconds.total", 1.0, "s"),
            ("Wall time", "seconds.wall", 1.0, "s"),
        ),
    ),
)


def tables_of(summary: Mapping[str, Any]) -> list[Table]:
    """The tables of numbers; what the summary lacks is left out."""
    tables = []
    for title, entries in _TABLES:
        rows = [
            Row(label, _text(value, scale), unit)
            for label, path, scale, unit in entries
            if (value := _at(summary, path)) is not None
        ]
        if rows:
            tables.append(Table(title, rows))
    return tables


def facts_of(result: Result) -> list[Row]:
    """The few numbers that are shown large."""
    span = 1e3 * np.ptp(result.positions[-1], axis=0)
    ratio = float(result.aspect_ratio[-1])
    seconds = _at(result.summary, "seconds.total")
    facts = [
        Row("actuation εₚᵣₑ", signed(float(result.actuation[-1]))),
        Row("height", f"{span[2]:.1f} mm"),
        Row("width × depth", f"{span[0]:.1f} × {span[1]:.1f} mm"),
        Row("height over width, h/d", f"{ratio:.3f}" if np.isfinite(ratio) else "–"),
    ]
    if seconds is not None:
        facts.append(Row("solved in", f"{float(seconds):.1f} s"))
    return facts


def lead_of(result: Result) -> str:
    """One sentence on the design."""
    flat = 1e3 * np.ptp(result.mesh.nodes, axis=0)
    nodes, edges, triangles = result.mesh.counts
    held = len(result.held_nodes)
    support = f"{held} nodes held" if held else "free, nothing held"
    return (
        f"A flat sheet of {flat[0]:.1f} × {flat[1]:.1f} mm, actuated to "
        f"eps_pre = {signed(float(result.summary['eps_pre']))}; {result.design.model} model; "
        f"{nodes} nodes, {edges} edges, {triangles} triangles; {support}."
    )


def banner_of(result: Result) -> Banner:
    """Whether the shape can be trusted, and what to do if not."""
    summary = result.summary
    remedy = str(summary.get("remedy") or "")
    said = [str(summary.get(key) or "") for key in ("detail", "status_message")]
    lines = [line for line in said if line]
    if result.status != "completed":
        reached = signed(float(result.actuation[-1]), 3)
        title = f"Not completed: {result.status.replace('_', ' ')}"
        lines.append(f"What is shown is the last state reached, at eps_pre = {reached}.")
        return Banner(False, title, [*lines, *([f"Remedy: {remedy}"] if remedy else [])])
    if result.motion is not None and not summary["motion"]["at_rest"]:
        return Banner(True, "Completed; the sheet is still in motion", lines)
    if not summary.get("stable", True):
        lines.append(
            f"The Hessian has {summary.get('negative_pivots', 'some')} negative pivots: a small "
            "disturbance would carry the sheet to another shape."
        )
        remedy = remedy or "try another perturbation load, or smaller steps (solver.max_step)"
        title = "Completed, but the last state is not stable"
        return Banner(False, title, [*lines, f"Remedy: {remedy}"])
    if crossing := summary.get("crossing_pairs", 0):
        pairs = "a pair" if crossing == 1 else f"{crossing} pairs"
        lines.append(f"The sheet passes through itself in {pairs} of triangles.")
        remedy = "Remedy: contact.self_contact = true"
        return Banner(False, "Completed, but no sheet can have this shape", [*lines, remedy])
    return Banner(True, "Completed, and the last state is stable", lines)


def layers_of(design: Any) -> list[dict[str, str]]:
    """The layers from the top down, as text with units."""
    return [
        {
            "name": str(layer.name),
            "role": str(layer.role),
            "where": where_text(layer),
            "thickness": f"{1e3 * layer.thickness:.4g} mm",
            "modulus": f"{1e-6 * layer.young_modulus:.4g} MPa",
            "poisson": f"{layer.poisson_ratio:.3g}",
        }
        for layer in reversed(list(design.layers))
    ]


def where_text(layer: Any) -> str:
    """Where a layer lies, as people say it."""
    if layer.where == "everywhere":
        return "everywhere"
    return "in the pattern" if layer.where == "pattern" else f"in {layer.where}"


def _at(summary: Mapping[str, Any], path: str) -> Any:
    value: Any = summary
    for key in path.split("."):
        if isinstance(value, Mapping):
            value = value.get(key)
        elif isinstance(value, list | tuple) and key.isdecimal() and int(key) < len(value):
            value = value[int(key)]
        else:
            return None
    return value


def _text(value: Any, scale: float) -> str:
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, int) and scale == 1.0:
        return f"{value:,}".replace(",", "\u202f")
    if isinstance(value, int | float):
        return f"{scale * value:.4g}".replace("-", "−")
    return str(value)
