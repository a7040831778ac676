"""Pictures of a search for a design: target beside shape, distances, and the course of it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from sheetmorph.compare.surface import Surface
from sheetmorph.geometry.mesh import Floats
from sheetmorph.inverse.result import Step
from sheetmorph.show import scene, stills, style
from sheetmorph.show.comparison_views import distance_to_scan, round_limit
from sheetmorph.show.render import RenderWorker
from sheetmorph.show.scene import Camera, Image, Job, View
from sheetmorph.show.style import Sheet
from sheetmorph.study.result import Result

_PANEL = (480, 380)
_HEAD, _FOOT, _CAPTION, _GAP = 100, 56, 34, 10
WANTED = (120, 128, 140)
"""Colour of the target."""


@dataclass(frozen=True, eq=False)
class Pair:
    """A target on a shape.

    Attributes:
        target: laid on the shape [m].
        result: the run of the shape.
        distance: root mean square distance both ways over the size of the target.
    """

    target: Surface
    result: Result
    distance: float

    @property
    def shape(self) -> Surface:
        """The final shape [m]."""
        return Surface(self.result.positions[-1], self.result.mesh.triangles.astype(np.int64))


def write_found(pair: Pair, path: Path, title: str, subtitle: str, painter: RenderWorker) -> Path:
    """Target, shape, the flat sheet, and the distance map on the shape.

    Raises:
        OutputError: the picture cannot be written.
    """
    signed = distance_to_scan(pair.shape, pair.target)
    limit = round_limit(float(np.percentile(np.abs(signed), 95)))
    colours = style.mapped(1e3 * signed, style.STRAIN_MAP, (-1e3 * limit, 1e3 * limit))
    target, shape, mapped = _images(pair, painter, colours)
    with style.style():
        sheet = _sheet(title, subtitle)
        _panel(sheet, 0, 0, "wanted", target)
        _panel(sheet, 1, 0, "found", shape)
        _flat(sheet, pair.result, 0, 1, _flat_caption(pair.result))
        if mapped is not None:
            _panel(sheet, 1, 1, "distance of the target", mapped)
        x, y = _place(1, 1)
        shown = (-1e3 * limit, 1e3 * limit)
        sheet.colour_bar(
            (x + _PANEL[0] + 8, y + 60, 18, 240), style.STRAIN_MAP, shown, shown, "mm", style.SMALL
        )
        sheet.foot(
            f"Root mean square distance {100 * pair.distance:.2f} % of the size of the target. "
            "Red: the target lies above the shape; blue: below it."
        )
        return sheet.save(path)


def write_best(
    pair: Pair, path: Path, title: str, steps: Sequence[Step], painter: RenderWorker
) -> Path:
    """The best so far of a search that goes on: target, shape, flat sheet, and the way there.

    Raises:
        OutputError: the picture cannot be written.
    """
    target, shape, _ = _images(pair, painter, None)
    with style.style():
        sheet = _sheet(title, f"best of {steps[-1].count} designs: {steps[-1].family} mesh")
        _panel(sheet, 0, 0, "wanted", target)
        _panel(sheet, 1, 0, "best so far", shape)
        _flat(sheet, pair.result, 0, 1, _flat_caption(pair.result))
        _course(sheet, steps, 1, 1)
        sheet.foot(
            f"Root mean square distance {100 * pair.distance:.2f} % of the size of the target"
        )
        return sheet.save(path)


def write_course(steps: Sequence[Step], path: Path, title: str) -> Path:
    """How the best became better, alone.

    Raises:
        OutputError: the picture cannot be written.
    """
    with style.style():
        sheet = Sheet(2 * _PANEL[0], _PANEL[1] + _HEAD + 20)
        sheet.title("Search", title)
        _draw_course(sheet.inset(90, 70, 2 * _PANEL[0] - 130, _PANEL[1] - 60), steps)
        return sheet.save(path)


def _images(
    pair: Pair, painter: RenderWorker, colours: scene.Colours | None
) -> tuple[Image, Image, Image | None]:
    shape, target = pair.shape, pair.target
    camera = _camera(np.concatenate([shape.points, target.points[target.used]]))
    grey = np.tile(np.array(WANTED, dtype=np.uint8), (len(target.points), 1))
    white = np.full((2, 2, 3), 255, dtype=np.uint8)
    wanted = Job(
        target.triangles.astype(np.int32),
        np.zeros((len(target.points), 2)),
        (white,),
        (View(target.points, grey, (0, 0), camera, _PANEL),),
    )
    plain = stills.white(len(shape.points))
    found = stills.base_job(
        pair.result, (View(shape.points, plain, stills.SHAPE_COLOURS, camera, _PANEL),)
    )
    jobs = [wanted, found]
    if colours is not None:
        view = View(shape.points, colours, (0, 0), camera, _PANEL, scene.FIELD_LIGHT)
        uv = np.zeros((len(shape.points), 2))
        jobs.append(Job(shape.triangles.astype(np.int32), uv, (white,), (view,)))
    images = [next(painter.draw(job)) for job in jobs]
    return images[0], images[1], images[2] if len(images) > 2 else None


def _camera(points: Floats) -> Camera:
    camera = scene.perspective().fitted(points, _PANEL, 0.06)
    return replace(camera, extent=camera.extent)


def _sheet(title: str, subtitle: str) -> Sheet:
    width = 2 * _PANEL[0] + 3 * _GAP + 80
    sheet = Sheet(width, _HEAD + 2 * (_PANEL[1] + _CAPTION + _GAP) + _FOOT)
    sheet.title(title, subtitle)
    return sheet


def _place(column: int, row: int) -> tuple[int, int]:
    x = _GAP + column * (_PANEL[0] + _GAP)
    return x, _FOOT + (1 - row) * (_PANEL[1] + _CAPTION + _GAP)


def _panel(sheet: Sheet, column: int, row: int, caption: str, image: Image) -> None:
    x, y = _place(column, row)
    sheet.image(image, x, y)
    _caption(sheet, column, row, caption)


def _caption(sheet: Sheet, column: int, row: int, caption: str) -> None:
    x, y = _place(column, row)
    place = (x + 0.5 * _PANEL[0], y + _PANEL[1] + 14)
    sheet.text(*place, caption, ha="center", va="center", fontweight="bold")


def _flat_caption(result: Result) -> str:
    wide, high = (1e3 * float(side) for side in np.ptp(result.mesh.nodes[:, :2], axis=0))
    reached = f"{100 * result.design.eps_pre:.1f} %".replace("-", "−")
    graded = result.design.actuation.profile == "field"
    strain = "free strain by place" if graded else f"free strain {reached}"
    return f"flat: {wide:.0f} × {high:.0f} mm, {strain}"


def _flat(sheet: Sheet, result: Result, column: int, row: int, caption: str) -> None:
    """The plan: film and pattern, or the strain where there is no pattern."""
    from matplotlib.collections import PolyCollection

    from sheetmorph.show import fields
    from sheetmorph.show.cells import triangle_colours

    x, y = _place(column, row)
    _caption(sheet, column, row, caption)
    axes = sheet.inset(x + 20, y + 10, _PANEL[0] - 40, _PANEL[1] - 20)
    mesh = result.mesh
    corners = list(1e3 * mesh.nodes[mesh.triangles, :2])
    if result.design.pattern:
        colours = triangle_colours(result)
        axes.add_collection(PolyCollection(corners, facecolors=colours, edgecolors="face", lw=0.3))
    else:
        values = fields.edges_to_triangles(mesh, result.thermal_strain_full)
        collection = PolyCollection(corners, array=values, cmap="magma", edgecolors="face", lw=0.3)
        axes.add_collection(collection)
        bar = sheet.figure.colorbar(collection, ax=axes, fraction=0.04, pad=0.02)
        bar.ax.tick_params(labelsize=style.SMALL)
    axes.set_aspect("equal")
    axes.autoscale_view()
    axes.axis("off")


def _course(sheet: Sheet, steps: Sequence[Step], column: int, row: int) -> None:
    x, y = _place(column, row)
    _caption(sheet, column, row, "misfit of the best")
    _draw_course(sheet.inset(x + 80, y + 60, _PANEL[0] - 110, _PANEL[1] - 80), steps)


def _draw_course(axes: object, steps: Sequence[Step]) -> None:
    from typing import Any

    from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

    plot: Any = axes
    counts = [one.count for one in steps]
    plot.step(counts, [100 * one.misfit for one in steps], where="post", color=style.INK, lw=1.4)
    stages = [one.family.rpartition(", ")[2] for one in steps]
    colours = {"coarse": style.colour(style.SCAN), "fine": style.colour(style.SHAPE)}
    for stage, colour in colours.items():
        chosen = [k for k, one in enumerate(stages) if one == stage]
        if chosen:
            values = [100 * steps[k].misfit for k in chosen]
            label = "coarse meshes" if stage == "coarse" else "own meshes"
            plot.plot([counts[k] for k in chosen], values, "o", ms=5, color=colour, label=label)
    plot.set_yscale("log")
    plot.yaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
    plot.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    plot.yaxis.set_minor_formatter(NullFormatter())
    plot.set_xlabel("designs", fontsize=style.SMALL)
    plot.set_ylabel("misfit [% of the size]", fontsize=style.SMALL)
    plot.tick_params(labelsize=style.SMALL)
    if plot.get_legend_handles_labels()[0]:
        plot.legend(fontsize=style.SMALL, frameon=False)
    for side in ("top", "right"):
        plot.spines[side].set_visible(False)
