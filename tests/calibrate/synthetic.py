"""Scans and curves that were computed, so that what made them is known."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

import sheetmorph as sm
from sheetmorph.calibrate.curves import Curve
from sheetmorph.calibrate.fit import CalibrateOptions
from sheetmorph.calibrate.misfit import shape_of
from sheetmorph.calibrate.parameters import Parameter, with_parameters
from sheetmorph.calibrate.targets import MeasuredScan
from sheetmorph.compare.pose import Similarity
from sheetmorph.compare.scan import Scan
from sheetmorph.compare.surface import Surface
from sheetmorph.geometry.surface import vertex_normals

TRUTH = {"eps_pre": -0.47, "gamma": 1.2, "moduli_ratio": 1.5, "stretch_factor": 6.0}
QUICK = CalibrateOptions(starts=3, descents=1)


def subdivided(surface: Surface, times: int) -> Surface:
    import trimesh

    points, triangles = surface.points, surface.triangles
    for _ in range(times):
        points, triangles = trimesh.remesh.subdivide(points, triangles)
    return Surface(points, triangles)


def noisy(shape: Surface, share: float, seed: int) -> Surface:
    """Every vertex shifted along its normal by chance, by a share of the size."""
    shift = np.random.default_rng(seed).normal(0.0, share * shape.size, (len(shape.points), 1))
    normals = vertex_normals(shape.points, shape.triangles)
    return Surface(shape.points + shift * normals, shape.triangles)


def scanned(result: sm.Result, *, known: bool, times: int = 2, seed: int = 0) -> MeasuredScan:
    """A scan with 1 % noise in an unknown pose, and of unknown size unless it is known."""
    surface = noisy(subdivided(shape_of(result), times), 0.01, seed)
    turn = Rotation.random(random_state=seed).as_matrix()
    pose = Similarity(1.0 if known else 370.0, turn, np.array([0.3, -0.2, 0.1]))
    return MeasuredScan(Scan(surface.moved(pose), "synthetic", (), 1.0 if known else None))


def curve_of(result: sm.Result, noise: float = 0.0, seed: int = 0, count: int = 40) -> Curve:
    at = np.linspace(0.05, 1.0, count)
    zero = Curve("film.csv", "actuation", at, np.zeros(count)).differences(result)
    return Curve(
        "film.csv",
        "actuation",
        at,
        np.abs(zero + np.random.default_rng(seed).normal(0.0, noise * zero.max(), count)),
    )


def made_with(design: sm.Design, *names: str) -> sm.Result:
    parameters = [Parameter(name, -1e9, 1e9) for name in names]
    return sm.simulate(with_parameters(design, parameters, [TRUTH[name] for name in names]))
