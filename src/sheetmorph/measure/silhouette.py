"""The sheet in a picture: background taken off, threshold, largest piece, its outline."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from sheetmorph.core.errors import InputError
from sheetmorph.geometry.mesh import Floats
from sheetmorph.measure.frames import Image, opencv

Background = Literal["auto", "light", "dark"]
Box = tuple[int, int, int, int]

NOISE = 6.0
"""Standard deviations of the background that a pixel of the sheet must differ by."""
LEAST_CONTRAST = 10.0
"""Grey levels of 255 by which a sheet must differ from its background."""
LARGEST, SMALLEST = 0.9, 2e-5
"""Shares of the region that a sheet may cover."""
EDGE_REACH = 4
"""Pixels from an edge within which the full contrast of the sheet is looked for."""


@dataclass(frozen=True)
class MaskOptions:
    """How the sheet is told from what is behind it.

    Attributes:
        region: the part of the picture to look at, x0, y0, x1, y1 [px]; all of it by default.
        background: "light" takes what is darker than its surroundings for the sheet, "dark"
            what is lighter, "auto" what has another colour.
        threshold: difference from the background [grey levels of 255] from which on a pixel
            belongs to the sheet; None finds it from the film.
    """

    region: Box | None = None
    background: Background = "auto"
    threshold: float | None = None


@dataclass(frozen=True, eq=False)
class Silhouette:
    """What was found in a picture.

    Attributes:
        outline: the pixels along the outer rim, x and y from the upper left corner of the
            picture [px], shape (N, 2); empty where nothing was found.
        area: pixels inside the outline.
        flags: what makes it doubtful, empty when all is well.
    """

    outline: Floats
    area: float
    flags: tuple[str, ...]

    @property
    def found(self) -> bool:
        """Whether there is an outline."""
        return len(self.outline) > 0


def region_of(image: Image, region: Box | None) -> Box:
    """The region to look at [px], all of the picture by default.

    Raises:
        InputError: it is empty, or reaches out of the picture.
    """
    rows, columns = image.shape[:2]
    if region is None:
        return 0, 0, columns, rows
    x0, y0, x1, y1 = region
    if not (0 <= x0 < x1 - 7 and x1 <= columns and 0 <= y0 < y1 - 7 and y1 <= rows):
        raise InputError(
            "the region must lie in the picture and be 8 px wide and high at least",
            key="--region",
            value=",".join(str(v) for v in region),
            allowed=f"x0,y0,x1,y1 within 0,0,{columns},{rows}",
        )
    return region


def find_threshold(images: Iterable[Image], options: MaskOptions) -> float:
    """One threshold for a whole film [grey levels].

    Half of Otsu's threshold between background and sheet over all pictures, and above the
    noise of the background. All pictures count at once, because a flat sheet seen from its edge
    covers too few pixels for a histogram of its own.

    Args:
        images: some pictures of the film.
        options: how to look at them; a given threshold is returned as it is.
    """
    if options.threshold is not None:
        return options.threshold
    cv2 = opencv()
    samples, noises = [], [0.0]
    for image in images:
        contrast = contrast_of(image, options)
        samples.append(np.clip(contrast, 0.0, 255.0).astype(np.uint8).ravel())
        noises.append(_noise_limit(contrast))
    together = np.concatenate(samples)
    otsu, _ = cv2.threshold(together[None, :], 0, 255, cv2.THRESH_BINARY + cv2.THRESH_OTSU)
    return float(max(0.5 * otsu, float(np.median(noises[1:])), LEAST_CONTRAST))


def find_silhouette(image: Image, threshold: float, options: MaskOptions) -> Silhouette:
    """Find the sheet in a picture.

    The mask is what differs from the background by more than the threshold. Unless the user
    gave that threshold, an edge is then put where the contrast falls to half of what it is
    beside it, which does not depend on how sharp the picture is. The largest piece is kept,
    after an opening that takes away hairs.

    Args:
        image: blue, green, red, shape (rows, columns, 3).
        threshold: see `find_threshold` [grey levels].
        options: where and how to look.
    """
    cv2 = opencv()
    x0, y0, x1, y1 = region_of(image, options.region)
    contrast = contrast_of(image, options)
    mask = (contrast > threshold).astype(np.uint8)
    if options.threshold is None:
        kernel = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (2 * EDGE_REACH + 1,) * 2)
        mask &= (contrast >= 0.5 * cv2.dilate(contrast, kernel)).astype(np.uint8)
        mask = cv2.morphologyEx(mask, cv2.MORPH_CLOSE, cv2.getStructuringElement(0, (3, 3)))
    piece = _largest(cv2, mask)
    size = (x1 - x0) * (y1 - y0)
    if piece is None or piece.sum() < max(SMALLEST * size, 12):
        return Silhouette(np.empty((0, 2)), 0.0, ("nothing found",))
    if piece.sum() > LARGEST * size:
        return Silhouette(np.empty((0, 2)), 0.0, ("the sheet fills the region",))
    outlines, _ = cv2.findContours(piece, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    outline = max(outlines, key=len)[:, 0, :].astype(np.float64)
    flags = []
    if (outline.min(axis=0) <= 0).any() or (
        outline.max(axis=0) >= [x1 - x0 - 1, y1 - y0 - 1]
    ).any():
        flags.append("touches the edge of the region")
    return Silhouette(outline + np.array([x0, y0]), float(piece.sum()), tuple(flags))


def contrast_of(image: Image, options: MaskOptions) -> NDArray[np.float32]:
    """By how much each pixel of the region differs from the background [grey levels].

    The background is a quadratic surface for each colour, fitted to what looks like the rim of
    the region, so that a backdrop lit unevenly counts as even.
    """
    cv2 = opencv()
    x0, y0, x1, y1 = region_of(image, options.region)
    colours = cv2.GaussianBlur(image[y0:y1, x0:x1].astype(np.float32), (0, 0), 1.0)
    difference = colours - _background(colours)
    if options.background == "auto":
        return np.asarray(np.sqrt((difference**2).mean(axis=2)))
    sign = -1.0 if options.background == "light" else 1.0
    return np.asarray(np.maximum(sign * difference.mean(axis=2), 0.0), dtype=np.float32)


def _background(colours: NDArray[np.float32]) -> NDArray[np.float32]:
    rows, columns = colours.shape[:2]
    step = max(1, int(np.sqrt(rows * columns / 6_000)))
    y, x = np.mgrid[0:rows:step, 0:columns:step]
    u, v = (2.0 * x.ravel() / columns - 1.0), (2.0 * y.ravel() / rows - 1.0)
    values = colours[::step, ::step].reshape(-1, 3).astype(np.float64)
    kept = np.maximum(abs(u), abs(v)) > 0.88
    coefficients = np.zeros((6, 3))
    for _ in range(6):
        basis = _quadratic(u, v)
        coefficients = np.linalg.lstsq(basis[kept], values[kept], rcond=None)[0]
        away = np.sqrt(((values - basis @ coefficients) ** 2).mean(axis=1))
        spread = 1.4826 * float(np.median(away[kept]))
        kept = away < max(3.0 * spread, 3.0)
        if kept.sum() < 0.05 * len(kept):
            break
    across = 2.0 * np.arange(columns) / columns - 1.0
    down = 2.0 * np.arange(rows) / rows - 1.0
    fitted = np.zeros(colours.shape, dtype=np.float32)
    for k, (i, j) in enumerate(_POWERS):
        fitted += (np.outer(down**j, across**i)[..., None] * coefficients[k]).astype(np.float32)
    return fitted


_POWERS = ((0, 0), (1, 0), (0, 1), (2, 0), (1, 1), (0, 2))


def _quadratic(u: Floats, v: Floats) -> Floats:
    return np.stack([u**i * v**j for i, j in _POWERS], axis=1)


def _noise_limit(contrast: NDArray[np.float32]) -> float:
    middle = float(np.median(contrast))
    return middle + NOISE * 1.4826 * float(np.median(abs(contrast - middle)))


def _largest(cv2: Any, mask: NDArray[np.uint8]) -> NDArray[np.uint8] | None:
    """The largest piece with its holes filled, opened unless it is too thin for that."""
    piece = _largest_of(cv2, mask)
    if piece is None:
        return None
    opened = _largest_of(
        cv2, cv2.morphologyEx(piece, cv2.MORPH_OPEN, cv2.getStructuringElement(2, (3, 3)))
    )
    # A sheet seen from its edge is thinner than the opening: then it stays as it is.
    return opened if opened is not None and opened.sum() > 0.9 * piece.sum() else piece


def _largest_of(cv2: Any, mask: NDArray[np.uint8]) -> NDArray[np.uint8] | None:
    outlines, _ = cv2.findContours(mask, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    if not outlines:
        return None
    filled = np.zeros_like(mask)
    areas = [cv2.contourArea(outline) + 0.5 * len(outline) for outline in outlines]
    cv2.drawContours(filled, outlines, int(np.argmax(areas)), 1, cv2.FILLED)
    return filled
