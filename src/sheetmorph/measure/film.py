"""Measuring a film: frame by frame an outline, its level, its scale, h and d."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, replace

import numpy as np

from sheetmorph.core.errors import InputError
from sheetmorph.core.events import Listener, Progress, silent
from sheetmorph.geometry.mesh import Floats
from sheetmorph.measure.camera import Shapes, SideCamera, caps, corrected, elevation_of
from sheetmorph.measure.film_history import FilmHistory, Shot
from sheetmorph.measure.frames import Film, Image, opencv, read_frames
from sheetmorph.measure.side_view import Reference, extents, jumps, level_of, place_of
from sheetmorph.measure.silhouette import (
    MaskOptions,
    Silhouette,
    find_blur,
    find_silhouette,
    find_threshold,
    region_of,
)

MAX_FRAMES = 5000
SAMPLES, SHARPNESS = 12, 4
"""Frames from which the threshold and the blur are found."""
NEAREST = 2.0
"""Distance of the camera over the width of the sheet, at least."""
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
        distance: from the camera to the sheet [m]; 0 takes the views for parallel.
        shapes: by which a camera that looks down or is near is corrected, with the rim of the
            flat sheet; None takes spherical caps on a round one.
        thickness: of the flat sheet [m]; the elevation of the camera is found with it.
    """

    mask: MaskOptions = field(default_factory=MaskOptions)
    interval: float = 1.0
    start: float = 0.0
    end: float | None = None
    reference: Reference | None = None
    roll: float | None = None
    elevation: float | None = 0.0
    distance: float = 0.0
    shapes: Shapes | None = None
    thickness: float = 0.0


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
    threshold = find_threshold(_samples(film, options, SAMPLES), options.mask)
    blur = find_blur(_samples(film, options, SHARPNESS), threshold, options.mask)
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
        silhouette = find_silhouette(frame.image, threshold, options.mask, blur)
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
    none = (np.nan, np.nan)
    sizes = np.array([extents(s.outline, roll, s.grain) if s.found else none for s in found])
    places = np.array([place_of(s.outline, roll, *size) if s.found else none for s in found])
    seen_width, seen_height = sizes.T
    seen = seen_height / seen_width
    scale = None if options.reference is None else options.reference.metre_per_pixel(*size)
    begin = found.index(first)
    shapes, per_pixel = _shapes(scale, float(seen_width[begin]), options)
    _check_distance(film, options.distance, shapes)
    places *= per_pixel
    camera = _camera(
        *(first, seen_width[begin], seen[begin], places[begin]),
        *(shapes, options, notes if begin == 0 else []),
    )
    elevation = camera.elevation
    ratio, width = corrected(seen, seen_width, places, shapes, camera)
    height = ratio * width
    jumping = jumps(seen_height, seen_width)
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


def _samples(film: Film, options: FilmOptions, count: int) -> Iterator[Image]:
    """Some pictures of the film, one at a time."""
    length = (film.count / film.rate if options.end is None else options.end) - options.start
    step = max(options.interval, length / count if length > 0 else 1.0)
    frames = read_frames(film, step, options.start, options.end)
    return (frame.image for frame, _ in zip(frames, range(2 * count), strict=False))


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


def _shapes(scale: float | None, width: float, options: FilmOptions) -> tuple[Shapes, float]:
    """The shapes by which views are corrected, and the scale [m/px].

    Args:
        scale: by the known length [m/px].
        width: of the sheet in the first frame [px].
    """
    shapes = options.shapes
    if shapes is None and scale is None:
        if options.distance > 0.0:
            raise InputError(
                "needs a RUN, which knows the size of the sheet, or --reference", key="--distance"
            )
        return caps(), 1.0 / width
    if shapes is None:
        return caps(float(scale) * width), float(scale)  # type: ignore[arg-type]
    return shapes, shapes.flat_width / width if scale is None else scale


def _check_distance(film: Film, distance: float, shapes: Shapes) -> None:
    nearest = NEAREST * shapes.flat_width
    if 0.0 < distance < nearest:
        raise InputError(
            "the camera is too near for its views to be corrected",
            file=film.path,
            key="--distance",
            value=f"{1e3 * distance:g} mm",
            allowed=f"{1e3 * nearest:.0f} mm and more, twice the width of the sheet",
        )


def _camera(
    first: Silhouette,
    width: float,
    seen: float,
    place: Floats,
    shapes: Shapes,
    options: FilmOptions,
    notes: list[str],
) -> SideCamera:
    """The camera by its first frame, with the sheet in it that is seen this wide [px] and high."""
    camera = SideCamera(0.0, options.distance, (float(place[0]), float(place[1])))
    if options.elevation is None:
        found = elevation_of(first.area, width, shapes, camera, options.thickness)
        return replace(camera, elevation=found)
    ratio = seen / shapes.flat_depth
    if options.elevation == 0.0 and 0.05 < ratio < 0.3:
        notes.append(
            f"the first frame shows h/d {seen:.3f}; if the sheet lies flat there, the camera "
            f"looks down by {np.degrees(np.arcsin(ratio)):.1f}°: then add --tilt auto"
        )
    return replace(camera, elevation=options.elevation)


def _shot(row: int, image: Image, silhouette: Silhouette, mask: MaskOptions) -> Shot:
    cv2 = opencv()
    x0, y0, x1, y1 = region_of(image, mask.region)
    scale = min(1.0, SHOT_SIDE / max(x1 - x0, y1 - y0))
    size = (max(1, round(scale * (x1 - x0))), max(1, round(scale * (y1 - y0))))
    small = cv2.resize(image[y0:y1, x0:x1], size, interpolation=cv2.INTER_AREA)
    return Shot(row, np.asarray(small), scale * (silhouette.outline - [x0, y0] + 0.5) - 0.5)
