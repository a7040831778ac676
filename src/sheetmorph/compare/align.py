"""The similarity that lays a scan onto a shape, from any pose."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from sheetmorph.compare.fit import NO_GAIN, Fit, Pair, refine, without_holes
from sheetmorph.compare.pose import Similarity
from sheetmorph.compare.surface import Surface
from sheetmorph.core.errors import InputError
from sheetmorph.geometry.mesh import Floats

# Steps of closest points, how many poses go on, and how far apart as a share of the radius.
STAGES = ((3, 64, 0.08), (5, 32, 0.15), (8, 12, 0.3))
COARSE_POINTS = 120
TARGET_POINTS = 800
FINE_POINTS = 600
ROUGHLY = 1e-3  # gain at which the refinement with few points ends
CLOSE = 1.12  # refined poses within this factor of the best are refined to the end
MOST = 4  # of those
SAME = 0.08  # poses that differ by less than this share of the radius are the same
# A shape that lies on itself better than the scan lies on it cannot tell two poses apart;
# within these shares of its radius, so that a bad fit does not make everything symmetric.
EXACT, SYMMETRIC = 0.003, 0.06
MIRROR_GAIN = 0.95  # a mirrored scan wins only with less than this share of the misfit


# What is easily taken for the right pose: the scan upside down or the wrong way round. These
# are refined too, in the shape's principal axes, so that the confidence knows of them.
HALF_TURNS = tuple(
    Similarity(1.0, np.diag(signs), np.zeros(3))
    for signs in ([1.0, -1.0, -1.0], [-1.0, 1.0, -1.0], [-1.0, -1.0, 1.0])
)


@dataclass(frozen=True)
class Effort:
    """How much an alignment tries.

    Attributes:
        starts: rotations to begin with; 192 are about 25 degrees apart.
        kept: poses that are refined.
        points: on each surface, in the end.
        gain: share of the sum of squares by which a last step changes it.
    """

    starts: int = 192
    kept: int = 12
    points: int = 4000
    gain: float = NO_GAIN


FULL = Effort()


@dataclass(frozen=True, eq=False)
class Alignment:
    """Where a scan lies on a shape.

    Attributes:
        pose: the map from the scan to the shape.
        rms: misfit [m]: root mean square distance both ways, of which the way from the
            shape to the scan has half the weight (`fit.WAY_BACK`).
        equivalent_poses: other poses, which differ from `pose` by a symmetry of the shape.
        next_rms: misfit of the best pose that is really different [m]; None when no such
            pose was found.
        confidence: 1 − rms/next_rms, 0 to 1; 1 when no other pose was found. (A scan with
            holes is compared before it is refined without them.)
        starts: rotations from which the search began.
        iterations: steps of the refinements, all together.
        mirrored: whether the scan was mirrored; only when that was asked for.
    """

    pose: Similarity
    rms: float
    equivalent_poses: tuple[Similarity, ...]
    next_rms: float | None
    confidence: float
    starts: int
    iterations: int
    mirrored: bool


def align(
    scan: Surface,
    shape: Surface,
    *,
    scale: float | None = None,
    mirror: bool = False,
    seed: int = 0,
    effort: Effort = FULL,
) -> Alignment:
    """Lay a scan onto a shape by shift, rotation and scale, whatever its pose.

    Rotations spread over all there are (Alexa 2022, super-Fibonacci spirals) start as many
    iterations of closest points (Besl & McKay 1992); the best ends are refined on the
    distances themselves. Both surfaces are first turned into their principal axes, so that
    the answer does not depend on the pose in which the scan comes.

    Args:
        scale: metres per unit of the scan; found by the fit when None.
        mirror: try the mirrored scan, too. It is never mirrored otherwise.
        seed: chooses the points on the surfaces and turns the set of rotations.
        effort: how much to try.

    Raises:
        InputError: `scale` is no positive number.
    """
    if scale is not None and not (np.isfinite(scale) and scale > 0.0):
        raise InputError("the scale must be a positive number", key="scale", value=scale)
    best = _align(scan, shape, scale, seed, effort)
    if not mirror:
        return best
    turned = Similarity(1.0, np.diag([-1.0, 1.0, 1.0]), np.zeros(3))
    other = _align(scan.moved(turned), shape, scale, seed, effort)
    if other.rms >= MIRROR_GAIN * best.rms:
        return best
    return Alignment(
        other.pose.after(turned),
        other.rms,
        tuple(pose.after(turned) for pose in other.equivalent_poses),
        other.next_rms,
        other.confidence,
        other.starts,
        other.iterations,
        True,
    )


def best_pose(
    scan: Surface, shape: Surface, scale: float | None, seed: int, effort: Effort
) -> Similarity:
    """The pose that `align` finds, and nothing about the others: half of the work."""
    found = _search(scan, shape, scale, seed, effort)
    return found.outside(found.best)


@dataclass(frozen=True, eq=False)
class _Found:
    """What a search found; poses in frames with the centroids at the origin and radius 1."""

    scan_frame: Similarity
    shape_frame: Similarity
    fine: Pair
    final: Pair
    fits: list[Fit]  # refined with few points
    near: list[Fit]  # those that were refined to the end
    done: list[Fit]  # the ends of these
    best: Fit  # the first of these without regard to holes

    def outside(self, fit: Fit) -> Similarity:
        return self.shape_frame.after(fit.pose).after(self.scan_frame.inverse())


def _search(
    scan: Surface, shape: Surface, scale: float | None, seed: int, effort: Effort
) -> _Found:
    scan_frame, shape_frame = _frame(scan), _frame(shape)
    # Inside, both surfaces have their centroids at the origin and radius 1.
    inner_scale = None if scale is None else scale * scan_frame.scale / shape_frame.scale
    moved, target = scan.moved(scan_frame.inverse()), shape.moved(shape_frame.inverse())
    coarse = _coarse(moved, target, inner_scale, seed, effort.starts)
    fine = Pair.of(moved, target, FINE_POINTS, inner_scale, seed)
    fits = _refined(fine, coarse[: effort.kept], ROUGHLY)
    final = Pair.of(moved, target, effort.points, inner_scale, seed)
    near: list[Fit] = []
    for fit in fits:
        # The images under an exact symmetry all end alike: one of them is enough.
        seen = any(_lies_on_itself(final, fit, other, EXACT) for other in near)
        if fit.misfit <= CLOSE * fits[0].misfit and not seen and len(near) < MOST:
            near.append(fit)
    done = _refined(final, [fit.pose for fit in near], max(ROUGHLY, effort.gain))
    done[0] = refine(final, done[0].pose, gain=effort.gain)
    best = without_holes(final, done[0])
    return _Found(scan_frame, shape_frame, fine, final, fits, near, done, best)


def _align(
    scan: Surface, shape: Surface, scale: float | None, seed: int, effort: Effort
) -> Alignment:
    found = _search(scan, shape, scale, seed, effort)
    final, fits, done, best = found.final, found.fits, found.done, found.best
    turned = _refined(found.fine, [turn.after(best.pose) for turn in HALF_TURNS], ROUGHLY)
    others = [*done[1:], *(fit for fit in [*fits, *turned] if fit not in found.near)]
    others = _unlike([best, *others], final.scan)[1:]
    equivalent: list[Fit] = []
    different: list[Fit] = []
    for fit in others:
        same = _lies_on_itself(final, fit, best, float(np.clip(best.misfit, EXACT, SYMMETRIC)))
        (equivalent if same else different).append(fit)
    different.sort(key=lambda fit: fit.misfit)
    if different and different[0] not in done:
        different[0] = refine(final, different[0].pose, gain=ROUGHLY)
    next_misfit = different[0].misfit if different else None
    size = found.shape_frame.scale
    return Alignment(
        found.outside(best),
        size * best.misfit,
        tuple(found.outside(fit) for fit in equivalent),
        None if next_misfit is None else size * next_misfit,
        max(0.0, 1.0 - done[0].misfit / next_misfit) if next_misfit else 1.0,
        effort.starts,
        sum(fit.iterations for fit in [best, *done[1:], *fits, *turned]),
        False,
    )


def _frame(surface: Surface) -> Similarity:
    """The map from a surface's own frame: centroid, principal axes and radius."""
    centres = surface.points[surface.triangles].mean(axis=1) - surface.centroid
    share = surface.areas / surface.area
    axes = np.linalg.eigh((centres * share[:, None]).T @ centres)[1][:, ::-1]
    # The heavy tail of each axis points forward, so that the frame turns with the surface.
    skew = share @ (centres @ axes) ** 3
    axes = axes * np.where(skew < 0.0, -1.0, 1.0)
    axes[:, 2] *= np.sign(np.linalg.det(axes))
    return Similarity(surface.radius, axes, surface.centroid)


def _rotations(count: int, seed: int) -> Floats:
    """Rotation matrices spread evenly over all rotations, shape (count, 3, 3)."""
    from scipy.spatial.transform import Rotation

    step = np.arange(count) + 0.5
    low, high = np.sqrt(step / count), np.sqrt(1.0 - step / count)
    first, second = 2.0 * np.pi * step / np.sqrt(2.0), 2.0 * np.pi * step / 1.5337511687552043
    quaternions = np.stack(
        [low * np.sin(first), low * np.cos(first), high * np.sin(second), high * np.cos(second)], 1
    )
    turn = Rotation.from_quat(np.random.default_rng(seed).normal(size=4))
    return np.asarray((turn * Rotation.from_quat(quaternions)).as_matrix())


def _coarse(
    scan: Surface, shape: Surface, scale: float | None, seed: int, starts: int
) -> list[Similarity]:
    """The best poses that closest points lead to, all different, best first."""
    from scipy.spatial import cKDTree

    p, q = scan.sample(COARSE_POINTS, seed).points, shape.sample(COARSE_POINTS, seed + 1).points
    scan_points = scan.sample(TARGET_POINTS, seed + 2).points
    shape_points = shape.sample(TARGET_POINTS, seed + 3).points
    scan_tree, shape_tree = cKDTree(scan_points), cKDTree(shape_points)
    rotation = _rotations(starts, seed)
    size = np.full(starts, 1.0 if scale is None else scale)
    shift = np.zeros((starts, 3))
    poses: list[Similarity] = []
    for steps, kept, apart in STAGES:
        misfit = np.zeros(len(size))
        for _ in range(steps):
            forth = size[:, None, None] * (p @ rotation.transpose(0, 2, 1)) + shift[:, None]
            there, found = shape_tree.query(forth)
            back = ((q - shift[:, None]) @ rotation) / size[:, None, None]
            here, touched = scan_tree.query(back)
            misfit = (there**2).mean(axis=1) + size**2 * (here**2).mean(axis=1)
            source = np.concatenate([np.broadcast_to(p, forth.shape), scan_points[touched]], 1)
            goal = np.concatenate([shape_points[found], np.broadcast_to(q, back.shape)], 1)
            rotation, size, shift = _umeyama(source, goal, scale)
        order = np.argsort(misfit, kind="stable")
        every = [Similarity(float(size[k]), rotation[k], shift[k]) for k in order]
        poses = _distinct(every, scan, kept, apart)
        rotation = np.stack([pose.rotation for pose in poses])
        size = np.array([pose.scale for pose in poses])
        shift = np.stack([pose.translation for pose in poses])
    return poses


def _umeyama(source: Floats, goal: Floats, scale: float | None) -> tuple[Floats, Floats, Floats]:
    """Best rotation, scale and shift of many sets of pairs at once (Umeyama 1991).

    Args:
        source: shape (K, n, 3).
        goal: shape (K, n, 3).
    """
    source_mean, goal_mean = source.mean(axis=1), goal.mean(axis=1)
    p, q = source - source_mean[:, None], goal - goal_mean[:, None]
    left, stretch, right = np.linalg.svd(q.transpose(0, 2, 1) @ p)
    stretch[:, 2] *= (sign := np.sign(np.linalg.det(left @ right)))
    left[:, :, 2] *= sign[:, None]
    rotation = left @ right
    if scale is None:
        size = np.clip(stretch.sum(axis=1) / (p**2).sum(axis=(1, 2)), 1e-3, 1e3)
    else:
        size = np.full(len(source), scale)
    return (
        rotation,
        size,
        goal_mean - size[:, None] * np.einsum("kij,kj->ki", rotation, source_mean),
    )


def _refined(pair: Pair, starts: list[Similarity], gain: float) -> list[Fit]:
    """Refined poses without repetitions, best first."""
    fits = sorted((refine(pair, start, gain=gain) for start in starts), key=lambda fit: fit.misfit)
    return _unlike(fits, pair.scan)


def _unlike(fits: list[Fit], scan: Surface) -> list[Fit]:
    """The fits without those that end where an earlier one does."""
    kept = _distinct([fit.pose for fit in fits], scan, len(fits), SAME)
    return [fit for fit in fits if fit.pose in kept]


def _distinct(poses: list[Similarity], scan: Surface, most: int, apart: float) -> list[Similarity]:
    """The first poses that move the scan to different places."""
    corners = scan.sample(40).points
    kept: list[Similarity] = []
    places = np.empty((0, *corners.shape))
    for pose in poses:
        place = pose.apply(corners)
        gaps = np.sqrt(((places - place) ** 2).sum(axis=2).mean(axis=1))
        if not (gaps < apart).any():
            kept.append(pose)
            places = np.concatenate([places, place[None]])
        if len(kept) == most:
            break
    return kept


def _lies_on_itself(pair: Pair, fit: Fit, other: Fit, share: float) -> bool:
    """Whether what leads from one pose to another moves the shape by little off itself."""
    relative = fit.pose.after(other.pose.inverse())
    points = pair.shape_samples.points[::8]
    there = pair.shape.nearest(relative.apply(points)).distance
    back = pair.shape.nearest(relative.inverse().apply(points)).distance
    own = float(np.sqrt(0.5 * ((there**2).mean() + (back**2).mean())))
    return own < share * pair.shape.radius
