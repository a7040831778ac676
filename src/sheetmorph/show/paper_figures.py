"""The figures of the redone paper: shapes side by side, diagrams, maps."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from sheetmorph.geometry.mesh import Floats
from sheetmorph.paper.rows import Bare, CurveFigure, Figure, MapFigure, ShapeFigure
from sheetmorph.paper.runs import Outcomes
from sheetmorph.show import fields, scene, style
from sheetmorph.show.scene import Camera, Image, Job, View
from sheetmorph.show.stills import FIELD_COLOURS, SHAPE_COLOURS, Field, base_job, white
from sheetmorph.show.style import Sheet

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from sheetmorph.show.render import RenderWorker
    from sheetmorph.study.result import Result

CELL = 300
LABEL, BAR, GAP, HEADER = 44, 130, 18, 44
COLOURS = ("#1f6fa8", "#c8102e", "#268c76", "#8854a0", "#b8860b", "#5c6975")
BARE_COLOUR = (196, 190, 178)
NAMES = {"shape": "shape", "angle": "|θ|", "strain": "ε", "top": "from above"}


@dataclass(frozen=True, eq=False)
class _Column:
    """One column of shapes: its label, positions, and what is drawn of them."""

    label: str
    points: Floats
    result: Result | None
    job: Job


def draw_figure(figure: Figure, outcomes: Outcomes, worker: RenderWorker, path: Path) -> Path:
    """Draw a figure as PNG.

    Args:
        figure: what to draw.
        outcomes: of the runs that the figure names.
        worker: draws the shapes in space.
        path: where to write.

    Raises:
        OutputError: it cannot be written.
    """
    if isinstance(figure, ShapeFigure):
        return _draw_shapes(figure, outcomes, worker, path)
    if isinstance(figure, CurveFigure):
        return _draw_curves(figure, path)
    return _draw_maps(figure, path)


def _draw_shapes(figure: ShapeFigure, outcomes: Outcomes, worker: RenderWorker, path: Path) -> Path:
    columns = [_column(label, one, outcomes) for label, one in figure.columns]
    across = min(len(columns), figure.across)
    bands = [columns[k : k + across] for k in range(0, len(columns), across)]
    painted = {row: _field(row, columns) for row in figure.rows if row in ("angle", "strain")}
    # Places of all cells, from the top: a band of columns has all the rows.
    cameras = {row: _cameras(row, columns) for row in figure.rows}
    heights = [cameras[row][1][1] for row in figure.rows]
    band_height = HEADER + sum(heights) + GAP * len(heights)
    bar = BAR if painted else 16
    sheet = Sheet(LABEL + across * CELL + bar, len(bands) * band_height + 8)
    images = [
        _images(column, k, figure.rows, cameras, painted, worker)
        for k, column in enumerate(columns)
    ]
    for index, (column, drawn) in enumerate(zip(columns, images, strict=True)):
        band, place = divmod(index, across)
        top = sheet.height - band * band_height
        x = LABEL + place * CELL
        sheet.text(
            x + 0.5 * CELL, top - 0.5 * HEADER, column.label, ha="center", va="center", fontsize=15
        )
        y = top - HEADER
        for row, height in zip(figure.rows, heights, strict=True):
            y -= height
            sheet.image(next(drawn), x, y)
            if place == 0:
                _side_label(sheet, y + 0.5 * height, NAMES[row])
                if row in painted:
                    box = (LABEL + across * CELL + 10.0, y + 10.0, 18.0, height - 58.0)
                    painted[row].draw_bar(sheet, box)
            y -= GAP
    return sheet.save(path)


def _column(label: str, one: object, outcomes: Outcomes) -> _Column:
    if isinstance(one, Bare):
        texture = np.full((4, 4, 3), BARE_COLOUR, dtype=np.uint8)
        job = Job(
            one.triangles.astype(np.int32), np.zeros((len(one.points), 2)), (texture, texture), ()
        )
        return _Column(label, one.points, None, job)
    result = outcomes[one].result  # type: ignore[index]  # the other kind of column is a run
    assert result is not None  # noqa: S101  sections name runs that have a shape
    return _Column(label, result.positions[-1], result, base_job(result))


def _field(row: str, columns: list[_Column]) -> Field:
    """One colour bar for all columns of a row."""
    values = [
        np.zeros(len(column.points))
        if column.result is None
        else fields.hinges_to_nodes(column.result.mesh, np.abs(column.result.dihedral[-1]))
        if row == "angle"
        else fields.edges_to_nodes(column.result.mesh, column.result.strain[-1])
        for column in columns
    ]
    flat = np.concatenate(values)
    if row == "angle":
        limits, name, label = fields.angle_limits(flat), style.ANGLE_MAP, "|θ|  [rad]"
    else:
        limits, name, label = fields.strain_limits(flat), style.STRAIN_MAP, "ε  [–]"
    return Field(flat[None], limits, name, label, "", "")


def _cameras(row: str, columns: list[_Column]) -> tuple[list[Camera], tuple[int, int]]:
    """Cameras of one scale, and the size of the cells."""
    square = (CELL, CELL)
    direction = scene.from_above() if row == "top" else scene.perspective()
    fitted = [direction.fitted(column.points, square, 0.04) for column in columns]
    extent = max(camera.extent for camera in fitted)
    distance = max(camera.distance for camera in fitted)
    cameras = [replace(camera, extent=extent, distance=distance) for camera in fitted]
    spans = [
        float(np.ptp(camera.project(column.points, square)[:, 1]))
        for camera, column in zip(cameras, columns, strict=True)
    ]
    height = int(np.clip(1.08 * max(spans), 0.4 * CELL, CELL))
    share = extent * height / CELL
    return [replace(camera, extent=share) for camera in cameras], (CELL, height)


def _images(
    column: _Column,
    index: int,
    rows: tuple[str, ...],
    cameras: dict[str, tuple[list[Camera], tuple[int, int]]],
    painted: dict[str, Field],
    worker: RenderWorker,
) -> Iterator[Image]:
    plain = white(len(column.points))
    views = []
    for row in rows:
        camera, size = cameras[row][0][index], cameras[row][1]
        if row in painted and column.result is not None:
            field = painted[row]
            colours = style.mapped(_values(row, column.result), field.colour_map, field.limits)
            views.append(
                View(column.points, colours, FIELD_COLOURS, camera, size, scene.FIELD_LIGHT)
            )
        else:
            colours_of = (0, 1) if column.result is None else SHAPE_COLOURS
            views.append(View(column.points, plain, colours_of, camera, size))
    return worker.draw(replace(column.job, views=tuple(views)))


def _values(row: str, result: Result) -> Floats:
    if row == "angle":
        return fields.hinges_to_nodes(result.mesh, np.abs(result.dihedral[-1]))
    return fields.edges_to_nodes(result.mesh, result.strain[-1])


def _side_label(sheet: Sheet, y: float, text: str) -> None:
    sheet.text(20, y, text, rotation=90, ha="center", va="center", fontsize=16, fontweight="bold")


def _draw_curves(figure: CurveFigure, path: Path) -> Path:
    sheet = Sheet(1000, 520)
    axes = sheet.inset(96, 78, 640, 414)
    count = 0
    for curve in figure.curves:
        if curve.look == "dashed":
            axes.plot(curve.x, curve.y, "--", color=style.MUTED, lw=1.4, label=curve.label)
            continue
        colour = COLOURS[count % len(COLOURS)]
        count += 1
        if curve.look == "dots":
            lines = sum(one.look == "line" for one in figure.curves)
            colour = COLOURS[(count - 1 - lines) % len(COLOURS)] if count > lines else colour
            axes.plot(curve.x, curve.y, "o", ms=5, mfc="white", color=colour, label=curve.label)
        else:
            axes.plot(curve.x, curve.y, "-", color=colour, lw=2.0, label=curve.label)
    for height, text in figure.marks:
        axes.axhline(height, color=style.HELD, lw=1.2, ls=":")
        axes.annotate(
            text,
            (0.02, height),
            xycoords=("axes fraction", "data"),
            fontsize=style.SMALL,
            xytext=(0, 4),
            textcoords="offset points",
            color=style.HELD,
        )
    _label_axes(axes, figure)
    axes.legend(loc="upper left", bbox_to_anchor=(1.03, 1.0), frameon=False, fontsize=style.SMALL)
    return sheet.save(path)


def _label_axes(axes: Axes, figure: CurveFigure) -> None:
    axes.set_xlabel(figure.x_label)
    axes.set_ylabel(figure.y_label)
    axes.set_facecolor("white")
    axes.grid(color=style.FAINT, lw=0.5)
    axes.set_axisbelow(True)
    low = min(float(np.min(curve.x)) for curve in figure.curves)
    if low < 0:
        axes.invert_xaxis()  # actuation grows to the right, as shrinkage does
    for side in ("top", "right"):
        axes.spines[side].set_visible(False)


def _draw_maps(figure: MapFigure, path: Path) -> Path:
    side = 384
    count = len(figure.maps)
    sheet = Sheet(LABEL + count * (side + GAP) + BAR, side + HEADER + 16)
    for k, (label, values) in enumerate(figure.maps):
        x = LABEL + k * (side + GAP)
        colours = style.mapped(values.T[::-1], style.ANGLE_MAP, figure.limits)
        repeat = max(1, side // max(colours.shape[:2]))
        image = np.repeat(np.repeat(colours, repeat, axis=0), repeat, axis=1)
        sheet.image(np.ascontiguousarray(image), x, 8 + (side - image.shape[0]) // 2)
        sheet.text(
            x + 0.5 * image.shape[1],
            side + 8 + 0.5 * HEADER,
            label,
            ha="center",
            va="center",
            fontsize=15,
        )
    box = (LABEL + count * (side + GAP) + 4.0, 20.0, 18.0, side - 60.0)
    sheet.colour_bar(box, style.ANGLE_MAP, figure.limits, figure.limits, figure.label)
    return sheet.save(path)
