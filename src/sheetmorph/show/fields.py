"""From edges and hinges to what can be coloured, and from states to a smooth motion."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from sheetmorph.geometry.mesh import Floats, SheetMesh

if TYPE_CHECKING:
    from sheetmorph.study.result import Result

MIN_ANGLE_RANGE = 0.01
MIN_STRAIN_RANGE = 1e-3


def edges_to_triangles(mesh: SheetMesh, values: Floats) -> Floats:
    """Mean over the three edges of each triangle; (..., E) becomes (..., T)."""
    return np.asarray(values[..., mesh.triangle_edges].mean(axis=-1))


def edges_to_nodes(mesh: SheetMesh, values: Floats) -> Floats:
    """Mean over the edges that meet at each node; (E,) becomes (V,)."""
    return _mean_at_nodes(mesh.edges, values, len(mesh.nodes))


def hinges_to_nodes(mesh: SheetMesh, values: Floats) -> Floats:
    """Mean over the hinges whose edge meets each node; (H,) becomes (V,).

    A corner where no hinge ends takes the mean of those that lie opposite.
    """
    if len(mesh.hinges) == 0:
        return np.zeros(len(mesh.nodes))
    count = len(mesh.nodes)
    means = _mean_at_nodes(mesh.hinges[:, :2], values, count)
    bare = np.bincount(mesh.hinges[:, :2].ravel(), minlength=count) == 0
    return np.where(bare, _mean_at_nodes(mesh.hinges[:, 2:], values, count), means)


def angle_limits(values: Floats) -> tuple[float, float]:
    """Range of a colour map that begins at zero."""
    return 0.0, max(float(np.max(values, initial=0.0)), MIN_ANGLE_RANGE)


def strain_limits(values: Floats) -> tuple[float, float]:
    """Range of a colour map with zero in its middle."""
    top = max(float(np.max(np.abs(values), initial=0.0)), MIN_STRAIN_RANGE)
    return -top, top


def shown_range(values: Floats, limits: tuple[float, float]) -> tuple[float, float]:
    """The part of a colour map that the values and zero use, a tenth of it at least."""
    low = min(float(np.min(values, initial=0.0)), 0.0)
    high = max(float(np.max(values, initial=0.0)), 0.0)
    lack = 0.1 * (limits[1] - limits[0]) - (high - low)
    return (low, high) if lack <= 0 else (low - 0.5 * lack, high + 0.5 * lack)


def clock_of(result: Result) -> tuple[Floats, Floats]:
    """What `pick_states` and `motion` spread evenly: actuation and load, or time, from 0 to 1."""
    if result.motion is None:
        return result.ramp, result.load_fraction
    time = result.motion.time
    return time / (float(time[-1]) or 1.0), np.zeros(len(time))


def pick_states(ramp: Floats, load: Floats, count: int) -> list[int]:
    """Indices of states that are spread evenly over the motion, first and last included."""
    progress = _progress(ramp, load)
    wanted = np.linspace(0.0, progress[-1], count)[:-1]
    picked = {int(np.argmin(np.abs(progress - share))) for share in wanted}
    return sorted(picked | {len(ramp) - 1})


def motion(
    positions: Floats, ramp: Floats, load: Floats, actuation: Floats, frames: int
) -> tuple[Floats, Floats]:
    """Smooth motion through all states, evenly in actuation.

    Every coordinate follows a monotone cubic (Fritsch–Carlson), which does not overshoot
    where the sheet snaps. The removal of the load takes a tenth of the full ramp.

    Args:
        positions: node positions of the states [m], shape (S, V, 3).
        ramp: fraction of the actuation, shape (S,).
        load: fraction of the perturbation load, shape (S,).
        actuation: eps_pre of the states, shape (S,).
        frames: number of frames F.

    Returns:
        positions of the frames [m], shape (F, V, 3), and their actuation, shape (F,).
    """
    from scipy.interpolate import PchipInterpolator

    progress = _progress(ramp, load)
    keep = np.concatenate([np.diff(progress) > 1e-9, [True]])
    if keep.sum() < 2:
        return np.repeat(positions[-1:], 1, axis=0), actuation[-1:]
    at = np.linspace(0.0, progress[-1], frames)
    progress = progress[keep] - progress[keep][0]
    at = np.minimum(at, progress[-1])
    moved = PchipInterpolator(progress, positions[keep], axis=0)(at)
    return np.asarray(moved), np.asarray(np.interp(at, progress, actuation[keep]))


def _progress(ramp: Floats, load: Floats) -> Floats:
    steps = np.abs(np.diff(ramp)) + 0.1 * np.abs(np.diff(load)) * (np.diff(ramp) < 1e-12)
    return np.concatenate([[0.0], np.cumsum(steps)])


def _mean_at_nodes(groups: NDArray[np.int32], values: Floats, count: int) -> Floats:
    flat = groups.ravel()
    weights = np.repeat(values, groups.shape[1])
    total = np.bincount(flat, weights=weights, minlength=count)
    return np.asarray(total / np.maximum(np.bincount(flat, minlength=count), 1))
