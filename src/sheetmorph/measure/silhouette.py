"""The sheet in a picture: background taken off, threshold, largest piece, its edge."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from sheetmorph.core.errors import InputError
from sheetmorph.geometry.mesh import Floats
from sheetmorph.measure.edges import best_blur, blur_of, enclosed, mean_thickness, refined
from sheetmorph.measure.frames import Image, opencv

Background = Literal["auto", "light", "dark"]
Box = tuple[int, int, int, int]

NOISE = 6.0
"""Standard deviations of the background that a pixel of the sheet must differ by."""
LEAST_CONTRAST = 10.0
"""Grey levels of 255 by which a sheet must differ from its background."""
LARGEST, SMALLEST = 0.9, 2e-5
"""Shares of the region that a sheet may cover."""
SPECK = 12
"""Pixels of the smallest piece that counts."""
LEAST_SHARE = 0.5
"""Share that the largest piece has of all that stands out; less is a sheet in pieces."""
THIN, FAINT = 8.0, 2.0
"""Pixels that a sheet seen from its edge is thick, and thresholds that it then must reach."""
EDGE_REACH = 4
"""Pixels from an edge within which the full contrast of the sheet is looked for."""
EDGE_SHARE = 0.35
"""Share of that contrast at which a first outline is drawn."""
HAIR = 7
"""Pixels up to which what sticks out of the sheet is a hair, blurred as pictures are here."""
SMOOTHING = 1.0, 1.5
"""Blur of the pictures whose edges are measured, and of those whose sheet is found [px]."""


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
        outline: the edge of the sheet, x and y from the centre of the upper left pixel [px],
            shape (N, 2); empty where nothing was found.
        area: inside the outline [px²].
        flags: what makes it doubtful, empty when all is well.
        grain: by how much the sheet is wider and higher than the outline [px]: 1 for an outline
            of pixels, whose centres lie half a pixel inside, 0 for one of edges.
    """

    outline: Floats
    area: float
    flags: tuple[str, ...]
    grain: float = 0.0

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

    A quarter of Otsu's threshold between background and sheet over all pictures, and above the
    noise of the background: low, because edges are found afterwards. All pictures count at once,
    because a flat sheet seen from its edge covers too few pixels for a histogram of its own.

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
    return float(max(0.25 * otsu, float(np.median(noises[1:])), LEAST_CONTRAST))


def find_blur(images: Iterable[Image], threshold: float, options: MaskOptions) -> float | None:
    """The blur of a film's edges [px], for `find_silhouette`.

    Args:
        images: some pictures of the film.
        threshold: see `find_threshold` [grey levels].
        options: how to look at them.

    Returns:
        None where the user gave the threshold, or where no picture shows the sheet.
    """
    if options.threshold is not None:
        return None
    misfits = []
    for image in images:
        difference = _difference(image, options)
        piece, _ = _piece(difference, threshold, options)
        if piece is not None:
            misfits.append(blur_of(difference, _outline(piece)))
    return best_blur(np.array(misfits)) if misfits else None


def find_silhouette(
    image: Image, threshold: float, options: MaskOptions, blur: float | None = None
) -> Silhouette:
    """Find the sheet in a picture.

    The mask is what differs from the background by more than the threshold, its largest piece,
    after an opening that takes away hairs. Unless the user gave that threshold, its outline is
    then moved to the edge of the sheet, see `edges.refined`.

    Args:
        image: blue, green, red, shape (rows, columns, 3).
        threshold: see `find_threshold` [grey levels].
        options: where and how to look.
        blur: see `find_blur`; that of this picture alone by default [px].
    """
    x0, y0, x1, y1 = region_of(image, options.region)
    difference = _difference(image, options)
    piece, found = _piece(difference, threshold, options)
    size = (x1 - x0) * (y1 - y0)
    if piece is None or piece.sum() < max(SMALLEST * size, SPECK):
        return Silhouette(np.empty((0, 2)), 0.0, ("nothing found",))
    if piece.sum() < LEAST_SHARE * found:
        return Silhouette(np.empty((0, 2)), 0.0, ("in pieces",))
    if piece.sum() > LARGEST * size:
        return Silhouette(np.empty((0, 2)), 0.0, ("the sheet fills the region",))
    outline = _outline(piece)
    if options.threshold is None and mean_thickness(outline) < THIN:
        # A flat sheet seen from its edge: where it is faint, parts of it are below the threshold.
        strength = np.median(np.sqrt((difference[piece > 0] ** 2).mean(axis=1)))
        if strength < FAINT * threshold:
            return Silhouette(np.empty((0, 2)), 0.0, ("in pieces",))
    low, high = outline.min(axis=0), outline.max(axis=0)
    cut = (low <= 0).any() or (high >= [x1 - x0 - 1, y1 - y0 - 1]).any()
    flags = ("touches the edge of the region",) if cut else ()
    corner = np.array([x0, y0])
    if options.threshold is not None or len(outline) < 8:
        return Silhouette(outline + corner, float(piece.sum()), flags, 1.0)
    if blur is None:
        blur = best_blur(blur_of(difference, outline)[None, :])
    edge = refined(difference, outline, blur, _noise_beside(difference, piece))
    return Silhouette(edge + corner, abs(enclosed(edge)), flags)


def contrast_of(image: Image, options: MaskOptions) -> NDArray[np.float32]:
    """By how much each pixel of the region differs from the background [grey levels].

    The background is a quadratic surface for each colour, fitted to what looks like the rim of
    the region, so that a backdrop lit unevenly counts as even.
    """
    return _contrast(_difference(image, options), options)


def _difference(image: Image, options: MaskOptions) -> NDArray[np.float32]:
    """The region less its background, signed, shape (rows, columns, 3)."""
    cv2 = opencv()
    x0, y0, x1, y1 = region_of(image, options.region)
    colours = cv2.GaussianBlur(image[y0:y1, x0:x1].astype(np.float32), (0, 0), SMOOTHING[0])
    return np.asarray(colours - _background(colours), dtype=np.float32)


def _contrast(difference: NDArray[np.float32], options: MaskOptions) -> NDArray[np.float32]:
    if options.background == "auto":
        return np.asarray(np.sqrt((difference**2).mean(axis=2)))
    sign = -1.0 if options.background == "light" else 1.0
    return np.asarray(np.maximum(sign * difference.mean(axis=2), 0.0), dtype=np.float32)


def _piece(
    difference: NDArray[np.float32], threshold: float, options: MaskOptions
) -> tuple[NDArray[np.uint8] | None, float]:
    """The mask of the sheet, None where nothing stands out, and the area of all that does."""
    cv2 = opencv()
    if options.threshold is not None:
        plain = (_contrast(difference, options) > threshold).astype(np.uint8)
        piece = _largest(cv2, plain)
        return None if piece is None else _shaved(cv2, piece, 3), 0.0
    more = float(np.sqrt(SMOOTHING[1] ** 2 - SMOOTHING[0] ** 2))
    contrast = _contrast(cv2.GaussianBlur(difference, (0, 0), more), options)
    kernel = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (2 * EDGE_REACH + 1,) * 2)
    mask = (contrast > threshold) & (contrast >= EDGE_SHARE * cv2.dilate(contrast, kernel))
    # A line as dark as the background, such as the near rim before the far one, cuts no sheet.
    shaved = _shaved(cv2, mask.astype(np.uint8), HAIR)
    closed = cv2.morphologyEx(shaved, cv2.MORPH_CLOSE, kernel)
    areas = cv2.connectedComponentsWithStats(closed)[2][1:, cv2.CC_STAT_AREA]
    return _largest(cv2, closed), float(areas[areas >= SPECK].sum())


def _outline(piece: NDArray[np.uint8]) -> Floats:
    cv2 = opencv()
    outlines, _ = cv2.findContours(piece, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    return np.asarray(max(outlines, key=len)[:, 0, :].astype(np.float64))


def _noise_beside(difference: NDArray[np.float32], piece: NDArray[np.uint8]) -> float:
    """Standard deviation of what is behind the sheet [grey levels], half a level at least."""
    behind = difference[::3, ::3][piece[::3, ::3] == 0]
    away = abs(behind - np.median(behind, axis=0)) if len(behind) else np.zeros(1)
    return max(0.5, 1.4826 * float(np.median(away)))


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
    across = np.vander(2.0 * np.arange(columns) / columns - 1.0, 3, increasing=True)
    down = np.vander(2.0 * np.arange(rows) / rows - 1.0, 3, increasing=True)
    table = np.zeros((3, 3, 3))
    for k, (i, j) in enumerate(_POWERS):
        table[:, i, j] = coefficients[k]
    fitted = np.empty(colours.shape, dtype=np.float32)
    for colour in range(3):
        along = (table[colour].T @ across.T).astype(np.float32)
        fitted[..., colour] = down.astype(np.float32) @ along
    return fitted


_POWERS = ((0, 0), (1, 0), (0, 1), (2, 0), (1, 1), (0, 2))


def _quadratic(u: Floats, v: Floats) -> Floats:
    return np.stack([u**i * v**j for i, j in _POWERS], axis=1)


def _noise_limit(contrast: NDArray[np.float32]) -> float:
    middle = float(np.median(contrast))
    return middle + NOISE * 1.4826 * float(np.median(abs(contrast - middle)))


def _shaved(cv2: Any, mask: NDArray[np.uint8], hair: int) -> NDArray[np.uint8]:
    """The mask without hairs up to so many pixels wide, as it is where it is as thin itself."""
    kernel = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (hair, hair))
    opened = cv2.morphologyEx(mask, cv2.MORPH_OPEN, kernel)
    if opened.sum() <= 0.9 * mask.sum():
        return mask
    # Half of what an opening takes from tips comes back, and so do the roots of hairs.
    small = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (hair // 2, hair // 2))
    return np.asarray(cv2.dilate(opened, small) & mask)


def _largest(cv2: Any, mask: NDArray[np.uint8]) -> NDArray[np.uint8] | None:
    """The largest piece with its holes filled."""
    outlines, _ = cv2.findContours(mask, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    if not outlines:
        return None
    filled = np.zeros_like(mask)
    areas = [cv2.contourArea(outline) + 0.5 * len(outline) for outline in outlines]
    cv2.drawContours(filled, outlines, int(np.argmax(areas)), 1, cv2.FILLED)
    return filled
