"""A predicted shape against a scan of the made one: cleaned, laid over it, and measured."""

from __future__ import annotations

import time
from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np

from sheetmorph.compare.align import Alignment, align
from sheetmorph.compare.baselines import Baseline, cap, lay_cap, lay_flat_sheet
from sheetmorph.compare.clean import prepare
from sheetmorph.compare.crop import CropOptions
from sheetmorph.compare.distances import distances
from sheetmorph.compare.faces import Face, Faces, face_of, faces_of
from sheetmorph.compare.fit import Pair, refine
from sheetmorph.compare.pose import Similarity
from sheetmorph.compare.result import AspectRatios, Comparison
from sheetmorph.compare.scan import Scan, unit_of_scale
from sheetmorph.compare.similarity import Grid, check_window, ssim, ssim_of_fields
from sheetmorph.compare.surface import Surface
from sheetmorph.core.errors import InputError
from sheetmorph.core.events import Listener, Progress, Started, silent
from sheetmorph.core.units import scale_of
from sheetmorph.geometry.surface import aspect_ratio

__all__ = ["AspectRatios", "CompareOptions", "Comparison", "compare_surfaces"]

# Grids and windows beside the wanted ones: a grid of ten points, with the window that is
# usual for images (7) and the least one that has a middle (3).
OTHER_SSIM = ((10, 7), (10, 3))
POOR_FIT = 0.08  # a misfit above this share of the size says that the two are unlike
UNSURE = 0.05  # a pose with less confidence than this is one of several
SCALE_POINTS = 2000
WRONG_UNIT = 0.4  # logarithm of a scale that no shrinkage explains


@dataclass(frozen=True)
class CompareOptions:
    """How a scan is compared.

    Attributes:
        unit: what lengths in the scan's file are in, such as "mm"; makes the scale known.
        scale: metres per unit of the scan, when it is known otherwise.
        face: which face of a thick scan; "auto" compares both where both are there.
        mirror: whether the scan may be mirrored.
        crop: what to cut off the scan.
        grid: points along each side of the box for the similarity.
        window: its window in grid points.
        seed: of the points and rotations that are drawn.
    """

    unit: str | None = None
    scale: float | None = None
    face: Face = "auto"
    mirror: bool = False
    crop: CropOptions = field(default_factory=CropOptions)
    grid: int = 64
    window: int = 10
    seed: int = 0


def compare_surfaces(
    shape: Surface,
    scan: Scan | Surface,
    *,
    flat: Surface | None = None,
    options: CompareOptions | None = None,
    on_event: Listener = silent,
) -> Comparison:
    """Clean a scan, lay it onto a shape, and measure how far the two are apart.

    Args:
        shape: the predicted shape [m].
        scan: in any pose and, unless its unit is known, of any size.
        flat: the undeformed sheet, for the baseline; a flat disc with the area of the
            shape when None.
        options: see there.
        on_event: is told what is being done.

    Raises:
        InputError: the scan or an option cannot be used.
    """
    began = time.perf_counter()
    chosen = options or CompareOptions()
    on_event(Started("comparing the shape with the scan"))
    raw = scan if isinstance(scan, Scan) else Scan(scan, "scan")
    known = _known_scale(chosen, raw)
    check_window(chosen.grid, chosen.window)
    on_event(Progress(0.0, "cleaning the scan"))
    clean = prepare(raw, crop=chosen.crop, shape=shape)
    faces = faces_of(clean.surface)
    wanted: Face = "both" if chosen.face == "auto" else chosen.face
    part, face = face_of(clean.surface, faces, wanted)
    on_event(Progress(0.15, "aligning the scan"))
    found = align(part, shape, scale=known, mirror=chosen.mirror, seed=chosen.seed)
    laid = part.moved(found.pose)
    on_event(Progress(0.45, "measuring distances"))
    there, back = distances(laid, shape, seed=chosen.seed)
    on_event(Progress(0.55, "comparing distance fields"))
    grid = Grid.around(laid, shape, chosen.grid)
    scan_field = grid.distance(laid)
    similarity = ssim_of_fields(grid, scan_field, grid.distance(shape), chosen.window)
    on_event(Progress(0.75, "scoring a flat sheet and a spherical cap"))
    sheet = flat or cap(shape.area, 0.0)
    baselines = {}
    for name, surface, pose, angle in _laid_baselines(laid, sheet, shape.area, known, chosen.seed):
        distance = surface.nearest(there.points).distance
        baselines[name] = Baseline(
            name,
            surface,
            pose.scale,
            pose.scale * float(np.sqrt((distance**2).mean())),
            ssim_of_fields(grid, scan_field, grid.distance(surface), chosen.window).value,
            angle,
        )
    thickness = None if faces.thickness is None else faces.thickness * found.pose.scale
    unit_length = found.pose.scale * (raw.unit or 1.0)
    notes = [*clean.notes, *faces.notes, *_face_notes(chosen, faces, face, thickness)]
    notes += _pose_notes(found, part, shape, known, chosen)
    on_event(Progress(1.0, "compared"))
    return Comparison(
        shape,
        laid,
        found,
        there,
        back,
        similarity,
        tuple(ssim(laid, shape, *other) for other in OTHER_SSIM),
        baselines,
        AspectRatios(
            float(aspect_ratio(shape.points[shape.used])),
            float(aspect_ratio(laid.points[laid.used])),
        ),
        face,
        thickness,
        unit_length,
        known is not None,
        tuple(notes),
        time.perf_counter() - began,
    )


def _known_scale(options: CompareOptions, scan: Scan) -> float | None:
    """Metres per unit of the scan's points, when that is known.

    Raises:
        InputError: it is given twice, or is no positive number.
    """
    given = [name for name in ("unit", "scale") if getattr(options, name) is not None]
    if scan.unit is not None:
        given.append("the unit with which the scan was read")
    if len(given) > 1:
        raise InputError(f"the scale of the scan is given twice: {' and '.join(given)}; give one")
    if options.unit is not None:
        return scale_of(options.unit, "length")
    if options.scale is not None and not (np.isfinite(options.scale) and options.scale > 0.0):
        raise InputError("the scale must be a positive number", key="scale", value=options.scale)
    return 1.0 if scan.unit is not None else options.scale


def _laid_baselines(
    scan: Surface, flat: Surface, area: float, known: float | None, seed: int
) -> Iterator[tuple[str, Surface, Similarity, float]]:
    """Name, surface on the scan, map from the scan to it, and opening angle of each."""
    scale = None if known is None else 1.0  # the scan has the size of the shape already
    surface, pose = lay_flat_sheet(scan, flat, scale, seed)
    yield "flat_sheet", surface, pose, 0.0
    surface, pose, angle = lay_cap(scan, area, scale, seed)
    yield "spherical_cap", surface, pose, angle


def _face_notes(
    options: CompareOptions, faces: Faces, face: str, thickness: float | None
) -> Iterator[str]:
    if thickness is None:
        if options.face in ("outer", "inner") and not faces.two_faced:
            yield f"The scan has no two faces: all of it was compared, not the {options.face} one."
        return
    where = {
        "both": "half of that away from the middle of the sheet, on both sides",
        "outer": "half of that outside of the middle of the sheet",
        "inner": "half of that inside of the middle of the sheet",
    }[face]
    yield (
        f"The sheet of the scan is {1e3 * thickness:.2g} mm thick; the shape is its middle "
        f"surface, and what was compared lies {where}."
    )


def _pose_notes(
    found: Alignment,
    scan: Surface,
    shape: Surface,
    known: float | None,
    options: CompareOptions,
) -> Iterator[str]:
    if found.mirrored:
        yield "The scan was mirrored: mirrored it fits clearly better than as it is."
    elif options.mirror:
        yield "The scan was not mirrored: mirrored it does not fit clearly better."
    if found.rms > POOR_FIT * shape.size:
        yield (
            f"The scan does not fit: the misfit is {found.rms / shape.size:.0%} of the size of the "
            "shape. Check that it is a scan of this sheet, without its stand and floor."
        )
    if found.equivalent_poses:
        yield (
            f"The shape is symmetric as far as the scan can tell: of "
            f"{1 + len(found.equivalent_poses)} poses that are alike the best was taken."
        )
    if found.confidence < UNSURE:
        yield (
            "Another pose of the scan fits almost as well; the pose is not certain "
            f"(confidence {found.confidence:.2f})."
        )
    if known is not None:
        free = refine(Pair.of(scan, shape, SCALE_POINTS, None, options.seed), found.pose).pose
        larger = free.scale / found.pose.scale
        yield f"The scale was held; left free it would make the scan {larger:.3f} times as large."
        if abs(np.log(larger)) > WRONG_UNIT:
            yield "So much more or less than 1 says that the unit or the scale given is wrong."
    elif unit := unit_of_scale(found.pose.scale):
        yield (
            f"The size was fitted. One unit of the scan is nearly 1 {unit}; if the file is in "
            f"{unit}, say so, and the true size counts."
        )
