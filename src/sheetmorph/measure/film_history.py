"""h and d of a sheet in the frames of a film, and the table of them."""

from __future__ import annotations

import csv
import io
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from sheetmorph.core.columns import read_text
from sheetmorph.core.errors import InputError
from sheetmorph.geometry.mesh import Floats
from sheetmorph.measure.frames import Image

COLUMNS = (
    *("frame", "time_s", "h_over_d", "h_over_d_seen", "h_mm", "d_mm", "h_px", "d_px"),
    *("area_px", "flags"),
)
DOUBTFUL = (
    *("nothing found", "in pieces", "the sheet fills the region", "jump"),
    "touches the edge of the region",
)
"""Flags of frames that are left out of means and plots.

"nearly flat" is none of them: it says that a camera that looks down by α cannot tell h/d below
about tan(α/2) from zero.
"""


@dataclass(frozen=True, eq=False)
class Shot:
    """A measured frame as a small picture.

    Attributes:
        row: which of the frames of the history it is.
        image: the region, blue, green, red, shape (rows, columns, 3).
        outline: the outline found, in its pixels, shape (N, 2).
    """

    row: int
    image: Image
    outline: Floats


@dataclass(frozen=True, eq=False)
class FilmHistory:
    """h and d in F frames.

    Attributes:
        name: of the film.
        frame: numbers of the frames, shape (F,).
        time: [s], shape (F,).
        ratio: h/d of a level view from afar, NaN where nothing was found, (F,).
        seen: h/d as it appears in the picture, (F,).
        height, width: h and d, corrected [px], (F,).
        area: in the outline [px²], (F,).
        flags: what makes a frame doubtful, F tuples.
        metre_per_pixel: the scale, None without a known length.
        roll, elevation: of the camera [rad].
        threshold: of the mask [grey levels].
        notes: what the user should know.
        shots: some of the frames.
    """

    name: str
    frame: NDArray[np.int64]
    time: Floats
    ratio: Floats
    seen: Floats
    height: Floats
    width: Floats
    area: Floats
    flags: tuple[tuple[str, ...], ...]
    metre_per_pixel: float | None = None
    roll: float = 0.0
    elevation: float = 0.0
    threshold: float = 0.0
    notes: tuple[str, ...] = ()
    shots: tuple[Shot, ...] = ()

    @property
    def good(self) -> NDArray[np.bool_]:
        """Frames that can be relied on, shape (F,)."""
        clean = [not set(flags) & set(DOUBTFUL) for flags in self.flags]
        return np.asarray(np.isfinite(self.ratio) & np.array(clean, dtype=bool))

    def to_csv(self) -> str:
        """The table: a row per frame, empty cells for what is not known."""
        stream = io.StringIO()
        writer = csv.writer(stream, lineterminator="\n")
        writer.writerow(COLUMNS)
        scale = np.nan if self.metre_per_pixel is None else 1e3 * self.metre_per_pixel
        for k, flags in enumerate(self.flags):
            h, d = self.height[k], self.width[k]
            numbers = (
                f"{self.time[k]:.6g}",
                *(_text(v, 5) for v in (self.ratio[k], self.seen[k])),
                *(_text(v, 4) for v in (h * scale, d * scale)),
                *(_text(v, 2) for v in (h, d)),
                _text(self.area[k], 0),
            )
            writer.writerow([int(self.frame[k]), *numbers, "; ".join(flags)])
        return stream.getvalue()


def read_table(path: str | Path) -> FilmHistory:
    """A history from a table that was written before, or from one typed in by hand.

    The columns time_s and h_over_d are needed; those of `COLUMNS` are taken where they are.

    Raises:
        InputError: it is no such table; the message names the line.
    """
    file = Path(path)
    text = read_text(file)
    try:
        rows = list(csv.DictReader(io.StringIO(text), strict=True))
    except csv.Error as error:
        raise InputError("this file is no table of comma-separated values", file=file) from error
    if not rows or not {"time_s", "h_over_d"} <= set(rows[0]):
        raise InputError(
            "a table of h/d needs the columns time_s and h_over_d, separated by commas",
            file=file,
            allowed=", ".join(COLUMNS),
        )
    columns: dict[str, Floats] = {}
    for name in COLUMNS[:-1]:
        columns[name] = np.array(
            [_number(row.get(name), file, k, name) for k, row in enumerate(rows)]
        )
    if not np.isfinite(columns["time_s"]).all():
        raise InputError("a time is missing", file=file, key="time_s")
    back = np.flatnonzero(np.diff(columns["time_s"]) <= 0.0)
    if len(back):
        raise InputError(
            "the times must increase",
            file=file,
            key=f"line {back[0] + 3}, time_s",
            value=rows[back[0] + 1]["time_s"],
        )
    pixels = np.where(columns["d_px"] > 0.0, columns["d_px"], np.nan)
    scales = columns["d_mm"] / pixels
    scale = float(np.nanmedian(scales)) if np.isfinite(scales).any() else None
    frame = np.nan_to_num(columns["frame"], nan=0.0).astype(np.int64)
    flags = tuple(tuple(f for f in (row.get("flags") or "").split("; ") if f) for row in rows)
    return FilmHistory(
        file.stem,
        frame,
        columns["time_s"],
        columns["h_over_d"],
        columns["h_over_d_seen"],
        columns["h_px"],
        columns["d_px"],
        columns["area_px"],
        flags,
        None if scale is None else 1e-3 * scale,
    )


def is_table(path: Path) -> bool:
    """Whether a file begins as the tables that `FilmHistory.to_csv` writes."""
    titles = ",".join(COLUMNS) + "\n"
    try:
        with path.open(encoding="utf-8") as stream:
            return stream.readline(len(titles) + 1) == titles
    except (OSError, UnicodeDecodeError):
        return False


def _text(value: float, digits: int) -> str:
    return f"{value:.{digits}f}" if np.isfinite(value) else ""


def _number(text: str | None, file: Path, row: int, name: str) -> float:
    if text is None or not text.strip():
        return float("nan")
    try:
        return float(text)
    except ValueError:
        raise InputError(
            "this is no number", file=file, key=f"line {row + 2}, {name}", value=text
        ) from None
