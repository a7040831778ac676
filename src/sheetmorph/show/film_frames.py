"""Frames of a film with the outline that was found in them, to see what was measured."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from sheetmorph.measure.film_history import DOUBTFUL, FilmHistory, Shot
from sheetmorph.show import style
from sheetmorph.show.style import Sheet

COLUMNS, MOST = 4, 12
_MARGIN, _GAP, _HEAD, _FOOT, _LABEL = 24, 16, 104, 56, 56
OUTLINE = "#ff2ea6"
"""Seen on dark and on light."""


def write_frames(film: FilmHistory, path: Path) -> Path:
    """Write up to twelve frames in their order, each with its time, h/d and flags.

    The outline is drawn, and the box whose sides are h and d as they are seen.

    Raises:
        OutputError: the picture cannot be written.
    """
    shots = _chosen(film)
    rows = -(-len(shots) // COLUMNS)
    columns = min(COLUMNS, len(shots))
    high, wide = shots[0].image.shape[:2]
    width = max(2 * _MARGIN + columns * wide + (columns - 1) * _GAP, 760)
    with style.style():
        sheet = Sheet(width, _HEAD + rows * (high + _LABEL) + _FOOT)
        good = int(film.good.sum())
        sheet.title(
            style.shortened(film.name, 40),
            f"{good} of {len(film.time)} frames measured  ·  threshold {film.threshold:.0f} of 255"
            f"  ·  roll {style.signed(np.degrees(film.roll), 1)}°, looks down by "
            f"{style.signed(np.degrees(film.elevation), 1)}°",
        )
        for k, shot in enumerate(shots):
            x = _MARGIN + (k % COLUMNS) * (wide + _GAP)
            y = sheet.height - _HEAD - (k // COLUMNS) * (high + _LABEL) - high
            _draw(sheet, film, shot, x, y)
        sheet.foot(
            "Pink: the outline that was found; dashed: the box whose sides are h and d as seen"
        )
        return sheet.save(path)


def _chosen(film: FilmHistory) -> list[Shot]:
    places = np.linspace(0, len(film.shots) - 1, min(MOST, len(film.shots))).round().astype(int)
    return [film.shots[k] for k in places]


def _draw(sheet: Sheet, film: FilmHistory, shot: Shot, x: int, y: int) -> None:
    high = shot.image.shape[0]
    sheet.image(np.ascontiguousarray(shot.image[..., ::-1]), x, y)
    if len(shot.outline):
        ring = np.vstack([shot.outline, shot.outline[:1]]) + 0.5
        sheet.axes.plot(x + ring[:, 0], y + high - ring[:, 1], color=OUTLINE, lw=1.3)
        box = _box(ring, film.roll)
        sheet.axes.plot(
            x + box[:, 0], y + high - box[:, 1], color=OUTLINE, lw=0.9, ls=(0, (4, 3)), alpha=0.9
        )
    row = shot.row
    value = film.ratio[row]
    said = f"h/d {value:.3f}" if np.isfinite(value) else "h/d –"
    sheet.text(x, y - 17, f"{film.time[row]:g} s   {said}", va="center", fontsize=style.SMALL)
    flags = ", ".join(film.flags[row])
    ink = style.HELD if set(film.flags[row]) & set(DOUBTFUL) else style.MUTED
    sheet.text(x, y - 36, style.shortened(flags, 40), va="center", fontsize=11, color=ink)


def _box(points: np.ndarray, roll: float) -> np.ndarray:
    """The closed rectangle about points whose long side has the level direction, (5, 2)."""
    turn = np.array([[np.cos(roll), np.sin(roll)], [-np.sin(roll), np.cos(roll)]])
    turned = points @ turn.T
    low, high = turned.min(axis=0), turned.max(axis=0)
    corners = np.array([low, [high[0], low[1]], high, [low[0], high[1]], low])
    return np.asarray(corners @ turn)
