"""Pictures that need no renderer: the design, its thermal strain, h/d against actuation."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from sheetmorph.geometry.mesh import Floats
from sheetmorph.show import fields, style
from sheetmorph.show.cells import painted_cells, triangle_colours
from sheetmorph.show.numbers import where_text
from sheetmorph.show.style import Sheet
from sheetmorph.show.texture import rings_of

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from sheetmorph.study.result import Result

WIDTH = 1000
LEGEND_WIDTH = 350
HEAD, FOOT = 100, 104


def subtitle(result: Result, *more: str) -> str:
    """The grey line below a title: name, model, and what else is given."""
    parts = [style.shortened(result.design.name, 40), f"{result.design.model} model", *more]
    return "  ·  ".join(parts)


def actuation_text(value: float) -> str:
    """eps_pre as text."""
    return f"εₚᵣₑ = {style.signed(value)}"


def write_design(result: Result, path: Path) -> Path:
    """The flat sheet with its mesh, regions, pattern, supports and sizes."""
    from matplotlib.collections import PolyCollection

    mesh = result.mesh
    sheet, axes, box = _flat_sheet(mesh.nodes, LEGEND_WIDTH)
    nodes, edges, triangles = mesh.counts
    sheet.title("Design", subtitle(result))
    corners = 1e3 * mesh.nodes[mesh.triangles, :2]
    axes.add_collection(
        PolyCollection(
            list(corners),
            facecolors=triangle_colours(result),
            edgecolors=(1.0, 1.0, 1.0, 0.55),
            linewidths=0.5,
        )
    )
    _draw_outlines(axes, result)
    held = 1e3 * mesh.nodes[result.held_nodes]
    if len(held):
        axes.plot(
            held[:, 0], held[:, 1], "s", ms=4.5, mfc=style.HELD, mec="white", mew=0.6, zorder=5
        )
    _scale_bar(axes, mesh.nodes)
    _design_legend(sheet, result, box[0] + box[2] + 36, box[1] + box[3])
    sheet.foot(
        f"{nodes} nodes, {edges} edges, {triangles} triangles, "
        f"mean edge {style.millimetres(mesh.mean_edge_length)}; "
        f"sheet {_extent(mesh.nodes)}"
    )
    return sheet.save(path)


def write_thermal_strain(result: Result, path: Path) -> Path:
    """The thermal strain at full actuation on the flat sheet."""
    from matplotlib.collections import PolyCollection

    mesh = result.mesh
    sheet, axes, box = _flat_sheet(mesh.nodes, 196)
    values = fields.edges_to_triangles(mesh, result.thermal_strain_full)
    limits = fields.strain_limits(values)
    eps_pre = float(result.summary["eps_pre"])
    sheet.title("Thermal strain", subtitle(result, f"full actuation, {actuation_text(eps_pre)}"))
    colours = style.mapped(values, style.STRAIN_MAP, limits) / 255.0
    axes.add_collection(
        PolyCollection(
            list(1e3 * mesh.nodes[mesh.triangles, :2]),
            facecolors=colours,
            edgecolors=colours,
            linewidths=0.8,
        )
    )
    _draw_outlines(axes, result)
    _scale_bar(axes, mesh.nodes)
    bar = (box[0] + box[2] + 40, box[1] + 0.1 * box[3], 22, 0.72 * box[3])
    shown = fields.shown_range(values, limits)
    sheet.colour_bar(bar, style.STRAIN_MAP, limits, shown, "free strain [–]")
    sheet.foot("Mean of the three edges of each triangle")
    return sheet.save(path)


def write_aspect_ratio(result: Result, path: Path) -> Path:
    """Height over width of the shape against actuation, or against the time of a motion."""
    sheet = Sheet(WIDTH, 700)
    sheet.title("Height over width", subtitle(result))
    axes = sheet.inset(116, 138, WIDTH - 116 - 56, 700 - 138 - 120)
    motion, ratio = result.motion, np.nan_to_num(result.aspect_ratio)
    along = result.actuation if motion is None else motion.time
    blue = style.colour(style.BILAYER)
    axes.plot(along, ratio, "-", color=blue, lw=2, zorder=2)
    load = result.load_fraction  # states with a part of the load are on the line, unmarked
    for chosen, face, label in (
        (load >= max(float(load.max()), 1e-9), "white", "with the perturbation load"),
        (load <= 0, blue, "without load"),
    ):
        if chosen.any() and motion is None:
            axes.plot(
                along[chosen],
                ratio[chosen],
                "o",
                ms=6.5,
                mfc=face,
                mec=blue,
                mew=1.4,
                ls="none",
                label=label,
                zorder=3,
                clip_on=False,
            )
    end = float(result.summary["eps_pre"] if motion is None else along[-1])
    reach = end or (-1.0 if motion is None else 1.0)
    axes.set_xlim(-0.02 * reach, reach * 1.06)
    axes.set_ylim(0.0, max(1.2 * float(np.max(ratio)), 0.01))
    free = "actuation εₚᵣₑ, free strain of the film  [–]"
    axes.set_xlabel(free if motion is None else "time  [s]", labelpad=8)
    axes.set_ylabel("h/d  [–]", labelpad=8)
    axes.grid(color=style.FAINT, lw=0.6)
    axes.set_axisbelow(True)
    for side in ("top", "right"):
        axes.spines[side].set_visible(False)
    last = f"h/d = {ratio[-1]:.3f} at {actuation_text(float(result.actuation[-1]))}"
    sheet.text(WIDTH - 24, sheet.height - 20, last, ha="right", va="top", fontsize=16)
    if motion is None:
        axes.legend(loc="upper left", frameon=False)
    sheet.foot("h: height of the shape; d: largest width of its outline seen from above")
    return sheet.save(path)


def _flat_sheet(
    nodes: Floats, beside: int
) -> tuple[Sheet, Axes, tuple[float, float, float, float]]:
    """A figure with axes in mm that hold the sheet, and the box of the axes [px]."""
    span = np.ptp(nodes[:, :2], axis=0)
    width = WIDTH - beside - 48
    height = int(np.clip(width * span[1] / span[0], 380, 800))
    sheet = Sheet(WIDTH, height + HEAD + FOOT)
    scale = min(width / span[0], height / span[1])
    size = span * scale
    box = (
        24 + 0.5 * (width - size[0]),
        FOOT + 0.5 * (height - size[1]),
        float(size[0]),
        float(size[1]),
    )
    axes = sheet.inset(*box)
    low = 1e3 * nodes[:, :2].min(axis=0)
    axes.set_xlim(low[0], low[0] + 1e3 * span[0])
    axes.set_ylim(low[1], low[1] + 1e3 * span[1])
    axes.axis("off")
    return sheet, axes, box


def _draw_outlines(axes: Axes, result: Result) -> None:
    from matplotlib.collections import LineCollection

    mesh = result.mesh
    interior = np.zeros(len(mesh.edges), dtype=bool)
    interior[mesh.hinge_edges[:, 0]] = True
    rim = 1e3 * mesh.nodes[mesh.edges[~interior], :2]
    options: dict[str, Any] = {"colors": style.INK, "clip_on": False, "capstyle": "round"}
    axes.add_collection(LineCollection(list(rim), linewidths=1.6, **options))
    rings = [
        1e3 * ring for area in result.design.layout.parts.values() for ring, _hole in rings_of(area)
    ]
    axes.add_collection(LineCollection(rings, linewidths=1.4, **options))


def _scale_bar(axes: Axes, nodes: Floats) -> None:
    low, span = 1e3 * nodes[:, :2].min(axis=0), 1e3 * np.ptp(nodes[:, :2], axis=0)
    length = style.round_length(0.3 * span[0])
    pixel = span[0] / axes.get_window_extent().width
    y = low[1] - 30 * pixel
    axes.plot(
        [low[0], low[0] + length], [y, y], "-|", color=style.INK, lw=2, ms=9, mew=2, clip_on=False
    )
    axes.text(
        low[0] + length + 12 * pixel, y, f"{length:g} mm", ha="left", va="center", clip_on=False
    )


def _design_legend(sheet: Sheet, result: Result, x: float, top: float) -> None:
    """Swatches of what is drawn, then the layers from the top down."""
    y = top - 12
    for cell in painted_cells(result)[:8]:
        box = sheet.axes.add_patch(_swatch(x, y, cell.colour))
        box.set_zorder(3)
        sheet.text(x + 32, y, style.shortened(cell.name, 26), va="center")
        y -= 34
    if len(result.held_nodes):
        sheet.axes.plot(
            [x + 11], [y], "s", ms=8, mfc=style.HELD, mec="white", mew=0.6, clip_on=False
        )
        sheet.text(x + 32, y, f"{len(result.held_nodes)} held nodes", va="center")
        y -= 34
    y -= 18
    sheet.text(x, y, "Layers, top to bottom", va="center", fontweight="bold")
    for layer in reversed(list(result.design.layers)):
        y -= 36
        sheet.text(x, y, style.shortened(layer.name, 28), va="center")
        sheet.text(
            x,
            y - 25,
            f"{style.millimetres(layer.thickness)}, {layer.role}, {where_text(layer)}",
            va="center",
            fontsize=style.SMALL,
            color=style.MUTED,
        )
        y -= 28
        if y < 130:
            break
    y -= 44
    sheet.text(x, y, "Actuation", va="center", fontweight="bold")
    sheet.text(x, y - 32, actuation_text(float(result.summary["eps_pre"])), va="center")


def _swatch(x: float, y: float, rgb: tuple[int, int, int]) -> Any:
    from matplotlib.patches import Rectangle

    return Rectangle((x, y - 9), 22, 18, facecolor=style.colour(rgb), edgecolor=style.INK, lw=0.8)


def _extent(nodes: Floats) -> str:
    span = 1e3 * np.ptp(nodes[:, :2], axis=0)
    return f"{span[0]:.1f} × {span[1]:.1f} mm"
