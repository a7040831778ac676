"""What a comparison is worth: a flat sheet and a spherical cap, scored as the shape is."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from sheetmorph.compare.align import Effort, best_pose
from sheetmorph.compare.fit import Pair, refine
from sheetmorph.compare.pose import Similarity
from sheetmorph.compare.surface import Indices, Surface
from sheetmorph.core.errors import InputError

RINGS, SPOKES = 14, 48
EFFORT = Effort(starts=32, kept=4, points=800, gain=1e-4)
FEW_POINTS = 300  # while the angle of the cap is searched for
ANGLE_TOLERANCE = 0.02  # [rad]
LEAST_ANGLE, LARGEST_ANGLE = 0.05, 3.0  # [rad], from which the search for the angle starts
FLAT = 0.02  # curvature times the radius of the scan below which the scan is flat


@dataclass(frozen=True, eq=False)
class Baseline:
    """A shape that needs no skill to predict, laid onto the scan.

    Attributes:
        name: "flat_sheet" or "spherical_cap".
        surface: where it lies in the frame of the scan [m].
        scale: length of the scan when laid onto it, over the length it had [1].
        rms: root mean square distance from the scan to it [m], at its own size.
        ssim: structural similarity with the scan.
        opening_angle: half the angle of the cap, seen from its centre [rad]; 0 when flat.
    """

    name: str
    surface: Surface
    scale: float
    rms: float
    ssim: float
    opening_angle: float

    def to_json(self) -> dict[str, float]:
        """Plain numbers."""
        return {
            "ssim": self.ssim,
            "rms_mm": 1e3 * self.rms,
            "scale": self.scale,
            "opening_angle_deg": float(np.degrees(self.opening_angle)),
        }


def cap(area: float, angle: float) -> Surface:
    """A spherical cap around the z axis, open downwards; a flat disc for angle 0.

    Args:
        area: its area [m²].
        angle: half the angle under which it is seen from its centre [rad], 0 to π.

    Raises:
        InputError: no such area or angle.
    """
    if not (np.isfinite(area) and area > 0.0):
        raise InputError("a cap needs a positive area", value=area)
    if not 0.0 <= angle <= np.pi:
        raise InputError("no such cap", key="angle", value=angle, allowed="0 to π")
    along = (np.arange(RINGS * SPOKES) // SPOKES + 1) / RINGS
    round_ = 2.0 * np.pi * (np.arange(RINGS * SPOKES) % SPOKES) / SPOKES
    # area = π chord²: the chord from the pole to the rim is the radius of the disc.
    chord = np.sqrt(area / np.pi)
    if angle < 1e-6:
        across, height = chord * along, np.zeros(len(along))
    else:
        radius = 0.5 * chord / np.sin(0.5 * angle)
        across = radius * np.sin(angle * along)
        height = -2.0 * radius * np.sin(0.5 * angle * along) ** 2
    points = np.stack([across * np.cos(round_), across * np.sin(round_), height], axis=1)
    return Surface(np.vstack([np.zeros(3), points]), _cap_triangles())


def _cap_triangles() -> Indices:
    spoke = np.arange(SPOKES)
    after = (spoke + 1) % SPOKES
    inner = np.stack([np.zeros(SPOKES, dtype=np.int64), 1 + spoke, 1 + after], axis=1)
    ring = (1 + SPOKES * np.arange(RINGS - 1))[:, None]
    a, b = (ring + spoke).ravel(), (ring + after).ravel()
    c, d = a + SPOKES, b + SPOKES
    return np.concatenate([inner, np.stack([a, c, d], 1), np.stack([a, d, b], 1)])


def lay_flat_sheet(
    scan: Surface, flat: Surface, scale: float | None, seed: int = 0
) -> tuple[Surface, Similarity]:
    """A flat sheet in the frame of a scan, and the map from the scan to it."""
    pose = best_pose(scan, flat, scale, seed, EFFORT)
    return flat.moved(pose.inverse()), pose


def lay_cap(
    scan: Surface, area: float, scale: float | None, seed: int = 0
) -> tuple[Surface, Similarity, float]:
    """The spherical cap of an area that fits a scan best, in the frame of the scan.

    It starts from the sphere through the scan, in the pose that `align` finds; the angle
    is then searched for with the misfit of the alignment as the measure.

    Returns:
        The cap, the map from the scan to it, and its opening angle [rad].
    """
    from scipy.optimize import minimize_scalar

    start = _sphere_angle(scan)
    pose = best_pose(scan, cap(area, start), scale, seed, EFFORT)

    def misfit(angle: float) -> float:
        return refine(
            Pair.of(scan, cap(area, angle), FEW_POINTS, scale, seed), pose, gain=1e-3
        ).misfit

    limits = max(0.5 * start, 0.4 * LEAST_ANGLE), min(1.6 * start + 0.1, np.pi)
    options = {"xatol": ANGLE_TOLERANCE, "maxiter": 10}
    found = minimize_scalar(misfit, bounds=limits, method="bounded", options=options)
    angle = float(found.x) if found.fun < misfit(start) else start
    best = cap(area, angle)
    pose = refine(Pair.of(scan, best, EFFORT.points, scale, seed), pose).pose
    return best.moved(pose.inverse()), pose, angle


def _sphere_angle(scan: Surface) -> float:
    """Opening angle of the cap that the scan fills on the sphere through it.

    The sphere is that of Pratt (1987): a |x|² + b·x + c with the least sum of squares under
    |b|² − 4ac = 1, which is a plane where the scan is flat.
    """
    from scipy.linalg import eig

    points = (scan.sample(2000).points - scan.centroid) / scan.radius
    rows = np.column_stack([(points**2).sum(axis=1), points, np.ones(len(points))])
    constraint = np.diag([0.0, 1.0, 1.0, 1.0, 0.0])
    constraint[0, 4] = constraint[4, 0] = -2.0
    values, vectors = eig(rows.T @ rows / len(rows), constraint)
    value = np.where(np.isfinite(values.real) & (values.real > -1e-9), values.real, np.inf)
    best = vectors[:, int(np.argmin(value))].real
    if abs(best[0]) < FLAT * float(np.linalg.norm(best[1:4])):
        return LEAST_ANGLE
    from_centre = points + best[1:4] / (2.0 * best[0])
    middle = from_centre.mean(axis=0)
    # Seen from the centre a cap is spread evenly: the mean of the cosine is (1 + cos α)/2.
    long = np.linalg.norm(from_centre, axis=1) * np.linalg.norm(middle)
    cosine = 2.0 * float((from_centre @ middle / np.maximum(long, 1e-30)).mean()) - 1.0
    return float(np.clip(np.arccos(np.clip(cosine, -1.0, 1.0)), LEAST_ANGLE, LARGEST_ANGLE))
