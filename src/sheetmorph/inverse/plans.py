"""Outlines and patterns of the families, as tables of a design file."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from sheetmorph.geometry.mesh import Floats

SPREAD = 300
"""Points that stand for a sheet."""


@dataclass(frozen=True)
class Plan:
    """The tables that a family decides on.

    Attributes:
        outline: lines of the table `outline`.
        pattern: lines of each table of the pattern.
    """

    outline: tuple[str, ...]
    pattern: tuple[tuple[str, ...], ...]


def text_of(plan: Plan, name: str, eps_pre: float, mesh_size: float) -> str:
    """A design file: film and printed parts as in the presets, a free sheet.

    Args:
        plan: outline and pattern.
        name: of the design.
        eps_pre: free strain of the film.
        mesh_size: mean edge length [m].
    """
    pattern = "\n\n".join("[[pattern]]\n" + "\n".join(lines) for lines in plan.pattern)
    outline = "\n".join(plan.outline)
    return _TEXT.format(
        name=name,
        outline=outline,
        pattern=pattern,
        eps_pre=f"{eps_pre:.6f}",
        mesh=mm(mesh_size),
    )


def mm(length: float) -> str:
    """A length [m] as text of a design file, to a tenth of a micrometre."""
    return f'"{1e3 * length:.4f} mm"'


def _disc(half: float) -> tuple[str, ...]:
    return ('kind = "disc"', f"radius = {mm(half)}")


def _rectangle(half: float, aspect: float) -> tuple[str, ...]:
    return ('kind = "rectangle"', f"width = {mm(2 * half)}", f"height = {mm(2 * half * aspect)}")


def star(values: Mapping[str, float]) -> Plan:
    """A disc with a star."""
    half = 0.5 * values["size"]
    return Plan(
        _disc(half),
        (
            (
                'kind = "star"',
                f"arms = {int(values['arms'])}",
                f"arm_length = {mm(half * values['arm_length'])}",
                f"half_width = {mm(half * values['half_width'])}",
                f"hub_radius = {mm(half * values['hub_radius'])}",
                "clip = true",
            ),
        ),
    )


def lotus(values: Mapping[str, float]) -> Plan:
    """A disc with a lotus."""
    half = 0.5 * values["size"]
    radius = half * values["radius"]
    return Plan(
        _disc(half),
        (
            (
                'kind = "lotus"',
                f"petals = {int(values['petals'])}",
                f"disc_radius = {mm(half * values['disc_radius'])}",
                f"radius = {mm(radius)}",
                f"petal_half_width = {mm(min(half * values['petal_half_width'], 0.45 * radius))}",
            ),
        ),
    )


def ring(values: Mapping[str, float]) -> Plan:
    """A disc with a ring."""
    half = 0.5 * values["size"]
    return Plan(
        _disc(half),
        (
            (
                'kind = "ring"',
                f"radius = {mm(half * values['radius'])}",
                f"width = {mm(half * values['width'])}",
            ),
        ),
    )


def cross(values: Mapping[str, float]) -> Plan:
    """A rectangle with a star of four arms."""
    half = 0.5 * values["size"]
    return Plan(
        _rectangle(half, values["aspect"]),
        (
            (
                'kind = "star"',
                "arms = 4",
                f"arm_length = {mm(half * values['arm_length'])}",
                f"half_width = {mm(half * values['half_width'])}",
                f'rotation = "{values["rotation"]:.4f} deg"',
                "clip = true",
            ),
        ),
    )


def canoe(values: Mapping[str, float]) -> Plan:
    """An ellipse with two stars of six arms, joined by a bar."""
    half = 0.5 * values["size"]
    return Plan(
        (
            'kind = "ellipse"',
            f"half_width = {mm(half)}",
            f"half_height = {mm(half * values['aspect'])}",
        ),
        (
            (
                'kind = "twin_star"',
                "arms = 6",
                f"arm_length = {mm(half * values['arm_length'])}",
                f"half_width = {mm(half * values['half_width'])}",
                f"spacing = {mm(half * values['spacing'])}",
                "clip = true",
            ),
        ),
    )


def stripes(values: Mapping[str, float]) -> Plan:
    """A rectangle with parallel ribs, evenly spaced across its height."""
    half = 0.5 * values["size"]
    angle = np.radians(values["rotation"])
    across = half * (abs(np.sin(angle)) + values["aspect"] * abs(np.cos(angle)))
    spacing = 2.0 * across / values["ribs"]
    width = min(half * values["half_width"], 0.45 * spacing)
    return Plan(
        _rectangle(half, values["aspect"]),
        (
            (
                'kind = "stripes"',
                f"spacing = {mm(spacing)}",
                f"half_width = {mm(width)}",
                f"offset = {mm(0.0 if int(values['ribs']) % 2 else 0.5 * spacing)}",
                f'rotation = "{values["rotation"]:.4f} deg"',
            ),
        ),
    )


def spread_disc(values: Mapping[str, float]) -> Floats:
    """Points over a disc, by the golden angle (Vogel 1979), shape (n, 2)."""
    step = np.arange(SPREAD) + 0.5
    r = 0.5 * values["size"] * np.sqrt(step / SPREAD)
    t = np.pi * (3.0 - np.sqrt(5.0)) * step
    return np.column_stack([r * np.cos(t), r * np.sin(t)])


def spread_ellipse(values: Mapping[str, float]) -> Floats:
    """The same over an ellipse, shape (n, 2)."""
    return np.asarray(spread_disc(values) * np.array([1.0, values["aspect"]]))


def spread_rectangle(values: Mapping[str, float]) -> Floats:
    """Points over a rectangle, by the plastic number (Roberts 2018), shape (n, 2)."""
    plastic = 1.324717957244746
    step = np.arange(1, SPREAD + 1)[:, None]
    unit = (0.5 + step / np.array([plastic, plastic**2])) % 1.0 - 0.5
    return np.asarray(unit * values["size"] * np.array([1.0, values["aspect"]]))


_TEXT = """name = "{name}"
model = "published"

[outline]
{outline}

{pattern}

# The layers from the bottom up. Moduli are those at the temperature of actuation.
[[layers]]
name = "polystyrene"
role = "active"
thickness = "0.3 mm"
young_modulus = "0.8911 MPa"
poisson_ratio = 0.33
density = "1050 kg/m^3"
where = "everywhere"

[[layers]]
name = "PLA"
role = "inert"
thickness = "0.8 mm"
young_modulus = "2.6733 MPa"
poisson_ratio = 0.33
density = "1250 kg/m^3"
where = "pattern"

[actuation]
eps_pre = {eps_pre}
profile = "linear"
distance = "pattern_boundary"

[perturbation] # a small load that makes the sheet leave its plane, gone at the end
shape = "bowl"
total_force = "0.95 mN"

[mesh]
size = {mesh}
"""
