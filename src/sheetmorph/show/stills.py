"""Pictures of the shape in space: what the renderer shall draw, and what is written around it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from sheetmorph.geometry.mesh import Floats
from sheetmorph.show import fields, scene, style
from sheetmorph.show.cells import PaintedCell, painted_cells
from sheetmorph.show.flat import subtitle
from sheetmorph.show.motion import state_text
from sheetmorph.show.scene import Camera, Colours, Image, Job, View
from sheetmorph.show.style import Sheet
from sheetmorph.show.texture import OUTLINE, REGIONS, UNDER_REGIONS, textures

if TYPE_CHECKING:
    from sheetmorph.study.result import Result

SHAPE_COLOURS = (REGIONS, UNDER_REGIONS)
FIELD_COLOURS = (OUTLINE, OUTLINE)

WIDTH = 1000
HEAD, FOOT = 96, 60
BESIDE = 160
CELL_WIDTH = 300
STATES = 4
LEGEND_END = 560
"""Where the last entry of a legend may begin [px]."""


@dataclass(frozen=True, eq=False)
class Field:
    """A field on the nodes of every picked state, with its colours.

    Attributes:
        values: shape (picked states, V).
        limits: range of the colour bar.
        colour_map: name of the colour map.
        label: name and unit.
        title: title of its picture.
        note: how it was made, for the foot of the picture.
    """

    values: Floats
    limits: tuple[float, float]
    colour_map: str
    label: str
    title: str
    note: str

    def colours(self, state: int) -> Colours:
        """Colours of the nodes in a picked state, shape (V, 3)."""
        return style.mapped(self.values[state], self.colour_map, self.limits)

    def draw_bar(
        self, sheet: Sheet, box: tuple[float, float, float, float], fontsize: float = style.TEXT
    ) -> None:
        """Put the colour bar into a box [px]."""
        shown = fields.shown_range(self.values, self.limits)
        sheet.colour_bar(box, self.colour_map, self.limits, shown, self.label, fontsize)


@dataclass(frozen=True, eq=False)
class Plan:
    """All stills of a result: what to draw, and the numbers needed to label it.

    Attributes:
        states: indices of the states in the overview, the last one at the end.
        angle: |θ| at the nodes.
        strain: axial strain at the nodes.
        job: the views, in the order in which `write` uses them.
    """

    states: list[int]
    angle: Field
    strain: Field
    job: Job


def base_job(result: Result, views: tuple[View, ...] = ()) -> Job:
    """A job with the textures of a result."""
    uv, pictures = textures(result.mesh, result.regions.triangle_cell, painted_cells(result))
    return Job(result.mesh.triangles, uv, pictures, views)


def white(count: int) -> Colours:
    """Node colours that leave a texture as it is, shape (count, 3)."""
    return np.full((count, 3), 255, dtype=np.uint8)


def plan(result: Result) -> Plan:
    """Decide what to draw of a result."""
    mesh, final = result.mesh, result.positions[-1]
    ramp, load = fields.clock_of(result)
    states = fields.pick_states(ramp, load, STATES)
    angle = np.array([fields.hinges_to_nodes(mesh, np.abs(result.dihedral[k])) for k in states])
    strain = np.array([fields.edges_to_nodes(mesh, result.strain[k]) for k in states])
    angles = Field(
        angle,
        fields.angle_limits(angle),
        style.ANGLE_MAP,
        "|θ|  [rad]",
        "Dihedral angle |θ|",
        "Mean over the hinges at each node",
    )
    strains = Field(
        strain,
        fields.strain_limits(strain),
        style.STRAIN_MAP,
        "ε  [–]",
        "Axial strain ε",
        "Mean over the edges at each node; red: stretched, blue: shortened",
    )
    plain = white(len(final))
    perspective = scene.perspective()
    wide, narrow = (WIDTH, 620), (WIDTH - BESIDE, 600)
    views = [
        View(final, plain, SHAPE_COLOURS, perspective.fitted(final, wide, 0.05), wide),
        *_parallel_views(final, plain),
    ]
    camera = perspective.fitted(final, narrow, 0.05)
    views += [
        View(final, field.colours(-1), FIELD_COLOURS, camera, narrow, scene.FIELD_LIGHT)
        for field in (angles, strains)
    ]
    cameras, cell = _cells(result.positions[states])
    for row in (None, angles, strains):
        for k, state in enumerate(states):
            points = result.positions[state]
            views.append(
                View(points, plain, SHAPE_COLOURS, cameras[k], cell)
                if row is None
                else View(
                    points, row.colours(k), FIELD_COLOURS, cameras[k], cell, scene.FIELD_LIGHT
                )
            )
    return Plan(states, angles, strains, base_job(result, tuple(views)))


def write(result: Result, plan: Plan, images: Iterator[Image], folder: Path) -> list[Path]:
    """Write the pictures, taking the images from the renderer in the order of the plan."""
    views = plan.job.views
    paths = [
        _write_shape(result, next(images), folder / "shape.png"),
        _write_measured(result, views[1], next(images), "Seen from above", folder / "top.png"),
        _write_measured(result, views[2], next(images), "Seen from the side", folder / "side.png"),
        _write_field(result, plan.angle, next(images), folder / "dihedral.png"),
        _write_field(result, plan.strain, next(images), folder / "strain.png"),
    ]
    paths.append(_write_overview(result, plan, list(images), folder / "overview.png"))
    return paths


def state_name(result: Result) -> str:
    """What the last state is: the final shape, or as far as the run came."""
    reached = state_text(result, -1)
    if result.motion is not None:
        return f"{reached}, {'at rest' if result.summary['motion']['at_rest'] else 'in motion'}"
    return reached if result.ramp[-1] > 1 - 1e-9 else f"last state reached, {reached}"


def _cells(states: Floats) -> tuple[list[Camera], tuple[int, int]]:
    """A camera for each state (S, V, 3) in the middle of its cell, all of one scale."""
    tall = (CELL_WIDTH, CELL_WIDTH)
    fitted = [scene.perspective().fitted(points, tall, 0.04) for points in states]
    extent = max(camera.extent for camera in fitted)
    distance = max(camera.distance for camera in fitted)
    cameras = [replace(camera, extent=extent, distance=distance) for camera in fitted]
    spans = [
        float(np.ptp(camera.project(points, tall)[:, 1]))
        for camera, points in zip(cameras, states, strict=True)
    ]
    height = int(np.clip(1.08 * max(spans), 0.45 * CELL_WIDTH, CELL_WIDTH))
    part = extent * height / CELL_WIDTH
    return [replace(camera, extent=part) for camera in cameras], (CELL_WIDTH, height)


def _parallel_views(points: Floats, colours: Colours) -> list[View]:
    views = []
    for camera, rows in ((scene.from_above(), (1, 640)), (scene.from_the_side(), (2, 560))):
        span = np.ptp(points, axis=0)
        axis, tallest = rows
        height = int(np.clip(0.70 * WIDTH * span[axis] / span[0] + 130, 220, tallest))
        size = (WIDTH, height)
        fitted = _with_room(camera.fitted(points, size, 0.0), points, size)
        views.append(View(points, colours, SHAPE_COLOURS, fitted, size))
    return views


def _with_room(camera: Camera, points: Floats, size: tuple[int, int]) -> Camera:
    """Room of 150 px at either side and 60 px above and below, for the dimension lines."""
    span = np.ptp(camera.project(points, size)[:, :2], axis=0)
    share = max(span[0] / (size[0] - 300), span[1] / (size[1] - 120))
    return Camera(camera.centre, camera.right, camera.up, camera.toward, camera.extent * share, 0.0)


def _write_shape(result: Result, image: Image, path: Path) -> Path:
    height, width = image.shape[:2]
    sheet = Sheet(WIDTH, height + HEAD + FOOT)
    sheet.image(image, 0, FOOT)
    sheet.title("Shape", subtitle(result, state_name(result)))
    _legend(sheet, 24, 28, painted_cells(result))
    span = np.ptp(result.positions[-1], axis=0)
    flat = np.ptp(result.mesh.nodes, axis=0)
    sizes = " × ".join(f"{1e3 * side:.1f}" for side in span)
    sheet.text(width - 24, sheet.height - 20, f"{sizes} mm", ha="right", va="top", fontsize=16)
    text = f"flat: {_millimetres(flat[0])} × {_millimetres(flat[1])} mm"
    sheet.text(width - 24, 28, text, ha="right", va="center", color=style.MUTED)
    return sheet.save(path)


def _write_measured(result: Result, view: View, image: Image, title: str, path: Path) -> Path:
    height = image.shape[0]
    sheet = Sheet(WIDTH, height + HEAD + FOOT)
    sheet.image(image, 0, FOOT)
    sheet.title(title, subtitle(result, state_name(result)))
    _legend(sheet, 24, 28, painted_cells(result))
    places = view.camera.project(view.points, view.size)[:, :2]
    low, high = places.min(axis=0), places.max(axis=0)
    left, right = float(low[0]), float(high[0])
    bottom, top = FOOT + height - float(high[1]), FOOT + height - float(low[1])
    span = np.ptp(view.points, axis=0)
    vertical = int(np.argmax(np.abs(view.camera.up)))
    names = "xyz"
    _dimension(sheet, (left, bottom - 30), (right, bottom - 30), f"{_millimetres(span[0])} mm")
    _dimension(sheet, (right + 34, bottom), (right + 34, top), f"{_millimetres(span[vertical])} mm")
    x, y = 40.0, FOOT + 22.0
    for end, name in (((x + 34, y), "x"), ((x, y + 34), names[vertical])):
        arrow = {"arrowstyle": "-|>", "color": style.MUTED, "lw": 1.2, "shrinkA": 0, "shrinkB": 0}
        sheet.axes.annotate("", end, (x, y), arrowprops=arrow)
        away = (end[0] + 0.25 * (end[0] - x), end[1] + 0.25 * (end[1] - y))
        sheet.text(*away, name, ha="center", va="center", color=style.MUTED)
    return sheet.save(path)


def _write_field(result: Result, field: Field, image: Image, path: Path) -> Path:
    height, width = image.shape[:2]
    sheet = Sheet(WIDTH, height + HEAD + FOOT)
    sheet.image(image, 0, FOOT)
    sheet.title(field.title, subtitle(result, state_name(result)))
    bar = (float(width), FOOT + 0.16 * height, 24.0, 0.62 * height)
    field.draw_bar(sheet, bar)
    sheet.foot(field.note)
    return sheet.save(path)


def _write_overview(result: Result, plan: Plan, images: list[Image], path: Path) -> Path:
    columns = len(plan.states)
    label, bar, gap, header = 40, 136, 22, 148
    cell = plan.job.views[-1].size
    width = max(label + columns * cell[0] + bar, 760)
    sheet = Sheet(width, header + 3 * (cell[1] + gap) + 24)
    sheet.title("From flat to final", subtitle(result))
    rows = ((None, "shape"), (plan.angle, "|θ|"), (plan.strain, "ε"))
    for row, (field, name) in enumerate(rows):
        y = sheet.height - header - (row + 1) * (cell[1] + gap) + gap
        sheet.text(
            20,
            y + 0.5 * cell[1],
            name,
            rotation=90,
            ha="center",
            va="center",
            fontsize=16,
            fontweight="bold",
        )
        for column in range(columns):
            sheet.image(images[row * columns + column], label + column * cell[0], y)
        if field is not None:
            box = (label + columns * cell[0] + 10.0, y + 8.0, 18.0, cell[1] - 52.0)
            field.draw_bar(sheet, box)
    for column, state in enumerate(plan.states):
        text = state_text(result, state)
        sheet.text(
            label + (column + 0.5) * cell[0],
            sheet.height - header + 18,
            text,
            ha="center",
            va="center",
            fontsize=15,
        )
    return sheet.save(path)


def _legend(sheet: Sheet, x: float, y: float, cells: list[PaintedCell]) -> None:
    from matplotlib.patches import Rectangle

    for cell in cells:
        if x > LEGEND_END:
            break
        text = style.shortened(cell.name.removeprefix("film + "), 24)
        for k, rgb in enumerate((cell.colour, cell.under)):
            sheet.axes.add_patch(
                Rectangle((x + 18 * k, y - 9), 18, 18, facecolor=style.colour(rgb), lw=0)
            )
        sheet.text(x + 46, y, text, va="center")
        x += 70 + 11 * len(text)
    if x <= LEGEND_END:
        sheet.text(x, y, "paler: underside", va="center", color=style.MUTED)


def _dimension(
    sheet: Sheet, start: tuple[float, float], end: tuple[float, float], text: str
) -> None:
    standing = start[0] == end[0]
    arrow = {"arrowstyle": "<->", "color": style.INK, "lw": 1.0, "shrinkA": 0, "shrinkB": 0}
    if abs(end[0] - start[0]) + abs(end[1] - start[1]) > 12:
        sheet.axes.annotate("", end, start, arrowprops=arrow)
    middle = (0.5 * (start[0] + end[0]), 0.5 * (start[1] + end[1]))
    if standing:
        sheet.text(middle[0] + 10, middle[1], text, ha="left", va="center")
    else:
        sheet.text(
            *middle,
            text,
            ha="center",
            va="center",
            bbox={"facecolor": "white", "edgecolor": "none", "pad": 3},
        )


def _millimetres(length: float) -> str:
    return f"{1e3 * length:.1f}"
