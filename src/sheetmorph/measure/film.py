"""Measuring a film: frame by frame an outline, its level, its scale, h and d."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

from sheetmorph.core.errors import InputError
from sheetmorph.core.events import Listener, Progress, silent
from sheetmorph.geometry.mesh import Floats
from sheetmorph.measure.film_history import FilmHistory, Shot
from sheetmorph.measure.frames import Film, Image, opencv, read_frames
from sheetmorph.measure.side_view import (
    Reference,
    TiltShape,
    cap_ratio,
    elevation_of,
    extents,
    jumps,
    level_of,
)
from sheetmorph.measure.silhouette import (
    MaskOptions,
    Silhouette,
    find_silhouette,
    find_threshold,
    region_of,
)

MAX_FRAMES = 5000
SAMPLES = 12
"""Frames from which the threshold is found."""
SHOTS = 24
"""Frames kept as pictures, at least, of a long film."""
SHOT_SIDE = 320


@dataclass(frozen=True)
class FilmOptions:
    """How a film is measured.

    Attributes:
        mask: how the sheet is told from the background.
        interval: between the frames that are measured [s].
        start, end: part of the film [s].
        reference: a known length; lengths are in pixels without it.
        roll: angle of the level direction in the picture [rad]; None takes it from the long
            axis of the sheet in the first frame, if it lies flat there.
        elevation: by how much the camera looks down [rad]; None finds it from the first
            frame, in which the sheet must lie flat.
        shape: from the elevation, what that camera sees of known shapes; None takes
            spherical caps.
        depth: depth over width of the flat sheet as the camera sees it, 1 for a round one.
        thickness: of the flat sheet [m]; the elevation of the camera is found with it.
        flat_width: width of the flat sheet as the camera sees it [m]; by the reference if None.
    """

    mask: MaskOptions = field(default_factory=MaskOptions)
    interval: float = 1.0
    start: float = 0.0
    end: float | None = None
    reference: Reference | None = None
    roll: float | None = None
    elevation: float | None = 0.0
    shape: Callable[[float], TiltShape] | None = None
    depth: float = 1.0
    thickness: float = 0.0
    flat_width: float | None = None


def read_film(film: Film, options: FilmOptions, on_event: Listener = silent) -> FilmHistory:
    """Measure a film frame by frame (the paper's protocol: threshold mask, known length).

    Args:
        film: what `frames.open_film` found.
        options: how to measure it.
        on_event: told of the progress.

    Raises:
        InputError: it cannot be read, the sheet is found in no frame, or an option does not
            fit its pictures.
    """
    threshold = _threshold(film, options)
    found: list[Silhouette] = []
    numbers, times = [], []
    shots: list[Shot] = []
    every, size = 1, (0, 0)
    for frame in read_frames(film, options.interval, options.start, options.end):
        if len(found) >= MAX_FRAMES:
            raise InputError(
                "too many frames",
                file=film.path,
                key="--interval",
                value=options.interval,
                allowed=f"up to {MAX_FRAMES} frames; take a longer interval or a part of the film",
            )
        size = (frame.image.shape[1], frame.image.shape[0])
        silhouette = find_silhouette(frame.image, threshold, options.mask)
        if len(found) % every == 0:
            shots.append(_shot(len(found), frame.image, silhouette, options.mask))
            if len(shots) > 2 * SHOTS:
                shots, every = shots[::2], 2 * every
        found.append(silhouette)
        numbers.append(frame.index)
        times.append(frame.time)
        if film.count:
            on_event(Progress(min(frame.index / film.count, 1.0), f"{film.name}, {frame.time:g} s"))
    first = next((s for s in found if s.found), None)
    if first is None:
        raise InputError(
            "the sheet was found in no frame; look at another --region, or set --background or "
            "--threshold",
            file=film.path,
        )
    notes: list[str] = []
    roll = _roll(first, options, notes)
    sizes = np.array([extents(s.outline, roll) if s.found else (np.nan, np.nan) for s in found])
    width, seen_height = sizes[:, 0], sizes[:, 1]
    seen = seen_height / width
    scale = None if options.reference is None else options.reference.metre_per_pixel(*size)
    begin = int(np.flatnonzero(np.isfinite(seen))[0])
    flat = options.flat_width or (0.0 if scale is None else scale * float(width[begin]))
    thickness = options.thickness / flat if flat else 0.0
    elevation = _elevation(float(seen[begin]), thickness, options, notes if begin == 0 else [])
    ratio, height = _corrected(seen, seen_height, width, elevation, options)
    jumping = jumps(seen_height, width)
    flags = tuple(
        s.flags
        + (("jump",) if jumping[k] else ())
        + (("nearly flat",) if ratio[k] < np.tan(0.5 * elevation) else ())
        for k, s in enumerate(found)
    )
    if film.count and not film.pictures and options.end is None:
        missing = film.count / film.rate - times[-1]
        if missing > max(2.0 * options.interval, 2.0):
            notes.append(f"the last {missing:.0f} s of the video could not be read")
    return FilmHistory(
        film.name,
        np.array(numbers),
        np.array(times),
        ratio,
        seen,
        height,
        width,
        np.array([s.area for s in found]),
        flags,
        scale,
        roll,
        elevation,
        threshold,
        tuple(notes),
        tuple(shots),
    )


def _threshold(film: Film, options: FilmOptions) -> float:
    if options.mask.threshold is not None:
        return options.mask.threshold
    length = (film.count / film.rate if options.end is None else options.end) - options.start
    step = max(options.interval, length / SAMPLES if length > 0 else 1.0)
    frames = read_frames(film, step, options.start, options.end)
    images = (frame.image for frame, _ in zip(frames, range(2 * SAMPLES), strict=False))
    return find_threshold(images, options.mask)


def _roll(first: Silhouette, options: FilmOptions, notes: list[str]) -> float:
    if options.roll is not None:
        return options.roll
    level = level_of(first.outline)
    if level is None or abs(level) > np.radians(30.0):
        notes.append(
            "the sheet does not lie flat in the first frame, so the picture is taken to be level; "
            "give --roll if it is not"
        )
        return 0.0
    return level


def _elevation(first: float, thickness: float, options: FilmOptions, notes: list[str]) -> float:
    if options.elevation is None:
        return elevation_of(first, options.depth, thickness)
    if options.elevation == 0.0 and 0.05 < first / options.depth < 0.3:
        angle = np.degrees(np.arcsin(first / options.depth))
        notes.append(
            f"the first frame shows h/d {first:.3f}; if the sheet lies flat there, the camera "
            f"looks down by {angle:.1f}°: then add --tilt auto"
        )
    return options.elevation


def _corrected(
    seen: Floats, seen_height: Floats, width: Floats, elevation: float, options: FilmOptions
) -> tuple[Floats, Floats]:
    """h/d and h [px] of a level view."""
    if elevation == 0.0:
        return seen, seen_height
    if options.shape is None:
        ratio = cap_ratio(seen, elevation)
    else:
        ratio = options.shape(elevation).ratio(seen)
    return ratio, ratio * width


def _shot(row: int, image: Image, silhouette: Silhouette, mask: MaskOptions) -> Shot:
    cv2 = opencv()
    x0, y0, x1, y1 = region_of(image, mask.region)
    scale = min(1.0, SHOT_SIDE / max(x1 - x0, y1 - y0))
    size = (max(1, round(scale * (x1 - x0))), max(1, round(scale * (y1 - y0))))
    small = cv2.resize(image[y0:y1, x0:x1], size, interpolation=cv2.INTER_AREA)
    return Shot(row, np.asarray(small), scale * (silhouette.outline - [x0, y0] + 0.5) - 0.5)
