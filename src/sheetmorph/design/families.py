"""Families of designs: functions from a few numbers to a complete design, for sweeps."""

from __future__ import annotations

from typing import Literal

from sheetmorph.design.presets import preset_text
from sheetmorph.design.spec import Design

MESH_PER_LINE = 0.6
"""Edge length of the mesh in widths of a line: a line is then about two triangles wide."""


def random_kirigami(
    seed: int,
    *,
    lines: int = 6,
    line_width: float = 4e-3,
    thickness: float = 0.7e-3,
    polygons: int = 3,
    sheet_radius: float = 50e-3,
    style: Literal["spokes", "outline", "both"] = "spokes",
    connected: bool = True,
    mesh_size: float | None = None,
) -> Design:
    """A disc with a pattern of random polygons: the preset `kirigami` with other numbers.

    The held box about the middle keeps its share of the sheet. The same numbers stand in the
    design under `pattern.0.seed`, `pattern.0.lines`, `pattern.0.line_width` and
    `layers.PLA.thickness`; all else can be set with `Design.with_values`.

    Args:
        seed: whole number from 0 that chooses the pattern.
        lines: of each polygon; the paper adopted more than four.
        line_width: of the pattern [m].
        thickness: of the inert layer [m].
        polygons: how many.
        sheet_radius: of the disc [m].
        style: lines from the centres to the corners, the sides of the polygons, or both.
        connected: whether bars join what does not touch.
        mesh_size: wanted mean edge length [m]; 0.6 of `line_width` by default.

    Raises:
        InputError: a number is not allowed, or no such pattern fits the sheet.
    """
    size = MESH_PER_LINE * line_width if mesh_size is None else mesh_size
    held = [_metres(-sheet_radius / 5), _metres(sheet_radius / 5)]
    preset = Design.from_toml(preset_text("kirigami", f"kirigami {seed}"))
    return preset.with_values(
        {
            "outline.radius": _metres(sheet_radius),
            "pattern.0.seed": seed,
            "pattern.0.lines": lines,
            "pattern.0.line_width": _metres(line_width),
            "pattern.0.polygons": polygons,
            "pattern.0.style": style,
            "pattern.0.connected": connected,
            "layers.PLA.thickness": _metres(thickness),
            "supports.0.x": held,
            "supports.0.y": held,
            "mesh.size": _metres(size),
        }
    )


def _metres(length: float) -> str:
    """A length [m] as text of a design file."""
    return f"{float(length)!r} m"
