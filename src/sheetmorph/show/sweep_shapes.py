"""The contact sheet of a sweep: shapes side by side, all to one scale."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from math import ceil
from pathlib import Path
from typing import Any

import numpy as np
import shapely

from sheetmorph.core.errors import InputError
from sheetmorph.geometry.mesh import Floats
from sheetmorph.geometry.topology import build_mesh
from sheetmorph.show import scene, style
from sheetmorph.show.cells import PaintedCell
from sheetmorph.show.render import RenderWorker
from sheetmorph.show.scene import Camera, Job, View
from sheetmorph.show.style import Sheet
from sheetmorph.show.sweep_columns import Column, input_names, read_column
from sheetmorph.show.texture import REGIONS, UNDER_REGIONS, textures
from sheetmorph.sweep.dataset import Sweep

ACROSS = 6
MOST = 120
CELL, LINE, HEAD = 200, 19, 96
MOST_LINES = 4
_UNDER_PATTERN = (150, 176, 196)


def draw_shapes(sweep: Sweep, count: int, by: str | None, worker: RenderWorker, path: Path) -> Path:
    """Draw the last states of some designs, spread evenly over all that have one.

    Args:
        sweep: what is drawn.
        count: how many at most.
        by: column by which they are ordered; by number when None.
        worker: draws the shapes.
        path: of the PNG file.

    Raises:
        InputError: no states were kept, no such column, or a count that is not allowed.
        OutputError: it cannot be written.
    """
    if not 1 <= count <= MOST:
        raise InputError(
            "must be a whole number", key="--shapes", value=count, allowed=f"1 to {MOST}"
        )
    order = read_column(sweep, by) if by else None
    chosen = _chosen(sweep, count, order)
    labels = [read_column(sweep, name) for name in input_names(sweep)[:MOST_LINES]]
    if order is not None and order.name not in [label.name for label in labels]:
        labels = [order, *labels[: MOST_LINES - 1]]
    shapes = [sweep[place] for place in chosen]
    cameras, tall = _cameras([shape["positions"][-1] for shape in shapes])
    across = min(ACROSS, len(chosen))
    height = tall + LINE * (len(labels) + 1) + 14
    with style.style():
        sheet = Sheet(max(across * CELL, 640) + 40, HEAD + ceil(len(chosen) / across) * height + 12)
        sheet.title(
            style.shortened(sweep.folder.resolve().name, 60),
            f"{len(chosen)} of {len(sweep)} designs, all to one scale"
            + (f", by {order.name}" if order else ""),
        )
        for number, (place, shape, camera) in enumerate(zip(chosen, shapes, cameras, strict=True)):
            band, column = divmod(number, across)
            x, top = 20 + column * CELL, sheet.height - HEAD - band * height
            (image,) = worker.draw(_job(shape, camera, tall))
            sheet.image(image, x, top - tall)
            _label(sheet, x + 8, top - tall - 6, shape["row"], labels, place)
        return sheet.save(path)


def _chosen(sweep: Sweep, count: int, order: Column | None) -> list[int]:
    places = sweep.rows_with_shape()
    if order is not None:
        places = [k for k in places if not np.isnan(order.values[k])]
        places.sort(key=lambda k: (order.values[k], k))
    if not places:
        raise InputError("no states were kept of this sweep", file=sweep.folder)
    picked = np.linspace(0, len(places) - 1, min(count, len(places))).round().astype(int)
    return [places[k] for k in picked]


def _cameras(shapes: Sequence[Floats]) -> tuple[list[Camera], int]:
    """A camera for every shape, all of one scale, and the height of the pictures [px]."""
    square = (CELL, CELL)
    fitted = [scene.perspective().fitted(points, square, 0.05) for points in shapes]
    extent = max(camera.extent for camera in fitted)
    distance = max(camera.distance for camera in fitted)
    cameras = [replace(camera, extent=extent, distance=distance) for camera in fitted]
    spans = [
        float(np.ptp(camera.project(points, square)[:, 1]))
        for camera, points in zip(cameras, shapes, strict=True)
    ]
    tall = int(np.clip(1.1 * max(spans), 0.4 * CELL, CELL))
    return [replace(camera, extent=extent * tall / CELL) for camera in cameras], tall


def _job(shape: dict[str, Any], camera: Camera, tall: int) -> Job:
    mesh = build_mesh(shape["nodes"], shape["triangles"])
    nothing = shapely.Polygon()
    cells = (
        PaintedCell("film", nothing, style.FILM, style.UNDER_FILM),
        PaintedCell("pattern", nothing, style.BILAYER, _UNDER_PATTERN),
    )
    uv, pictures = textures(mesh, shape["in_pattern"].astype(np.intp), cells)
    points = shape["positions"][-1]
    white = np.full((len(points), 3), 255, dtype=np.uint8)
    view = View(points, white, (REGIONS, UNDER_REGIONS), camera, (CELL, tall))
    return Job(mesh.triangles, uv, pictures, (view,))


def _label(
    sheet: Sheet, x: float, y: float, row: dict[str, Any], labels: Sequence[Column], place: int
) -> None:
    failed = row["status"] != "completed"
    head = f"{row['index']}" + (f"  {row['status']}" if failed else "")
    sheet.text(
        x,
        y,
        head,
        fontsize=11,
        fontweight="bold",
        va="top",
        color=style.HELD if failed else style.INK,
    )
    for number, column in enumerate(labels, 1):
        name = column.name.split(".")[-1]
        text = style.shortened(f"{name} {column.text(place)} {column.unit}", 27)
        sheet.text(x, y - LINE * number, text, fontsize=9.5, color=style.MUTED, va="top")
