"""What the options of `history` say about films."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from sheetmorph.core.errors import InputError
from sheetmorph.core.units import to_si

if TYPE_CHECKING:
    from sheetmorph.measure.film import FilmOptions
    from sheetmorph.measure.side_view import Reference
    from sheetmorph.study.result import Result


def film_options(results: Sequence[Result], azimuth: float, given: dict[str, Any]) -> FilmOptions:
    """How films are measured.

    Args:
        results: the runs beside which they are shown; the first one serves to correct a tilt.
        azimuth: of the camera [rad].
        given: the options of the command by their names.

    Raises:
        InputError: an option makes no sense; the message names it.
    """
    import numpy as np

    from sheetmorph.measure.camera import Shapes, caps, shapes_of
    from sheetmorph.measure.film import FilmOptions
    from sheetmorph.measure.silhouette import MaskOptions

    region = _numbers(given["region"], "--region")
    tilt = given["tilt"].strip()
    elevation = None if tilt == "auto" else quantity(tilt, "angle", "--tilt")
    if elevation is not None and not 0.0 <= elevation <= np.radians(30.0):
        raise InputError(
            "the camera may look down by 0 to 30°",
            key="--tilt",
            value=tilt,
            allowed='"0 deg" to "30 deg", or auto',
        )
    kind = given["tilt_shape"] or ("run" if results else "cap")
    if kind == "run" and not results:
        raise InputError("needs a RUN", key="--tilt-shape", value=kind, allowed="cap, or a RUN")
    reference = _reference(given["reference"])
    shapes = None
    if results:
        shapes = shapes_of(results[0].positions, results[0].mesh.triangles, azimuth)
        if kind == "cap":
            stretched = caps(shapes.flat_width, shapes.flat_depth)
            shapes = Shapes(stretched.positions, shapes.outline)
    thickness, distance = (
        0.0 if given[name] is None else quantity(given[name], "length", f"--{name}")
        for name in ("thickness", "distance")
    )
    for name in ("thickness", "distance"):
        if given[name] is not None and shapes is None and reference is None:
            raise InputError("needs a RUN or --reference", key=f"--{name}")
    return FilmOptions(
        mask=MaskOptions(
            region=None if region is None else tuple(round(v) for v in region),  # type: ignore[arg-type]
            background=given["background"],
            threshold=_threshold(given["threshold"]),
        ),
        interval=quantity(given["interval"], "time", "--interval"),
        start=quantity(given["start"], "time", "--start"),
        end=None if given["end"] is None else quantity(given["end"], "time", "--end"),
        reference=reference,
        roll=_roll(given["roll"]),
        elevation=elevation,
        distance=distance,
        shapes=shapes,
        thickness=thickness,
    )


def quantity(text: str, kind: Any, option: str) -> float:
    """The quantity that an option gives, in SI units; times and lengths are not negative.

    Raises:
        InputError: no number with a unit of that kind.
    """
    try:
        value = to_si(text.strip(), kind)
    except InputError as error:
        raise InputError(error.message, key=option, value=text, allowed=error.allowed) from None
    if kind in ("time", "length") and value < 0.0:
        raise InputError("must not be below zero", key=option, value=text)
    return value


def _numbers(text: str | None, option: str) -> tuple[float, float, float, float] | None:
    if text is None:
        return None
    parts = text.split(",")
    pattern = r"\s*-?[0-9]{1,6}(\.[0-9]{1,6})?\s*"
    if len(parts) != 4 or not all(re.fullmatch(pattern, part) for part in parts):
        raise InputError(
            "wants four numbers of pixels", key=option, value=text, allowed="as in 10,200,310,205"
        )
    a, b, c, d = (float(part) for part in parts)
    return a, b, c, d


def _reference(text: str | None) -> Reference | None:
    from sheetmorph.measure.side_view import Reference

    if text is None:
        return None
    length, equals, line = text.partition("=")
    points = _numbers(line, "--reference") if equals else None
    if points is None:
        raise InputError(
            "wants a length and its two ends",
            key="--reference",
            value=text,
            allowed='as in "50 mm=10,200,310,205"',
        )
    return Reference(quantity(length, "length", "--reference"), points)


def _roll(text: str) -> float | None:
    from sheetmorph.measure.side_view import angle_of

    if text.strip() == "auto":
        return None
    if "," in text:
        line = _numbers(text, "--roll")
        return None if line is None else angle_of(line)
    return quantity(text, "angle", "--roll")


def _threshold(text: str) -> float | None:
    if text.strip() == "auto":
        return None
    if not re.fullmatch(r"\s*[0-9]{1,3}(\.[0-9]{1,3})?\s*", text) or not 0 < float(text) < 255:
        raise InputError(
            "no threshold", key="--threshold", value=text, allowed="auto, or above 0 to below 255"
        )
    return float(text)
