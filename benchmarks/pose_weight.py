"""Which weight of the way from the shape to the scan finds the pose of a scan best.

    .venv/bin/python benchmarks/pose_weight.py [SEEDS]

Computed shapes are made into scans: rougher, bent differently by what a model may miss, or taken
from an earlier state; whole, with holes, without their tips, or with both faces. Their unit is
known, and which of their points belongs to which of the shape, and so is the pose (Umeyama 1991).
For every weight the table has how far the fitted pose moves a scan from there, RMS over its area
in % of the size, and the error of the fitted scale; RMS over designs and seeds.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from dataclasses import replace

import numpy as np
from scipy.spatial.transform import Rotation

import sheetmorph as sm
from sheetmorph.compare.distances import bending
from sheetmorph.compare.fit import Pair, refine, without_holes
from sheetmorph.compare.pose import Similarity, best_similarity
from sheetmorph.compare.surface import Surface
from sheetmorph.design.presets import preset_text
from sheetmorph.geometry.mesh import Floats

WEIGHTS = (0.0, 0.1, 0.25, 0.5, 1.0, 2.0, 4.0)
DESIGNS = ("petals", "bowl", "canoe")
NOISE = 0.001  # of the size, at every point
MISSED = 0.02  # of the size, RMS: what a model may miss, waves as long as half the size
EARLIER = 0.85  # share of the actuation in the earlier state
HOLES, HOLE = 10, 0.07  # how many, and their radius as a share of the size
TIP = 0.1  # share of the largest distance from the middle that is cut off
THICKNESS = 0.012  # of the size, where both faces are there
POINTS = 4000


def cases(
    result: sm.Result, random: np.random.Generator
) -> Iterator[tuple[str, str, Surface, Floats]]:
    """What differs, what is missing, the scan, and where each of its points belongs."""
    triangles = result.mesh.triangles.astype(np.int64)
    last = result.positions[-1]
    earlier = int(np.argmin(np.abs(result.ramp - EARLIER)))
    size = Surface(last, triangles).size
    fine, faces = finer(np.stack([last, result.positions[earlier]]), triangles)
    fine, faces = finer(fine, faces)
    target, before = fine
    waves = missed(target, size, random)
    for differs, place in (("rough", target), ("bent", target + waves), ("earlier", before)):
        surface = Surface(place, faces)
        normals = unit(bending(surface, 0.02 * size).normals)
        rough = place + NOISE * size * random.normal(size=len(place))[:, None] * normals
        surface = Surface(rough, faces)
        middle = place[faces].mean(axis=1)
        reach = np.linalg.norm(middle - surface.centroid, axis=1)
        seeds = surface.sample(HOLES, int(random.integers(1000))).points
        away = np.linalg.norm(middle[:, None] - seeds, axis=2).min(axis=1)
        yield differs, "whole", surface, target
        yield differs, "holes", Surface(rough, faces[away > HOLE * size]), target
        yield differs, "no tips", Surface(rough, faces[reach < (1.0 - TIP) * reach.max()]), target
        half = 0.5 * THICKNESS * size * normals
        both = np.concatenate([rough + half, rough - half])
        whole = np.concatenate([faces, faces[:, ::-1] + len(rough)])
        yield differs, "both faces", Surface(both, whole), np.concatenate([target, target])


def missed(points: Floats, size: float, random: np.random.Generator) -> Floats:
    """A smooth displacement of points, shape (V, 3), of the size `MISSED`."""
    waves = np.zeros_like(points)
    for _ in range(6):
        direction = unit(random.normal(size=3))
        phase = 2.0 * np.pi * (points @ direction / (0.5 * size) + random.random())
        waves += np.sin(phase)[:, None] * random.normal(size=3)
    return MISSED * size * waves / np.sqrt((waves**2).sum(axis=1).mean())


def finer(states: Floats, triangles: np.ndarray) -> tuple[Floats, np.ndarray]:
    """Every triangle cut into four, for states of shape (S, V, 3)."""
    edges = np.sort(triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    ends, edge = np.unique(edges, axis=0, return_inverse=True)
    a, b, c = triangles.T
    ab, bc, ca = (edge.reshape(-1, 3) + states.shape[1]).T
    parts = [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
    middles = states[:, ends].mean(axis=2)
    faces = np.concatenate([np.stack(part, axis=1) for part in parts])
    return np.concatenate([states, middles], axis=1), faces


def unit(vectors: Floats) -> Floats:
    """Vectors of length 1."""
    return np.asarray(vectors / np.linalg.norm(vectors, axis=-1, keepdims=True))


def errors(
    scan: Surface, target: Floats, shape: Surface, seed: int
) -> tuple[Floats, Floats, float]:
    """For each weight the error of the pose and of the scale [%], and the ratio of areas."""
    weights = np.bincount(scan.triangles.ravel(), np.repeat(scan.areas, 3), len(scan.points))
    truth = best_similarity(scan.points, target, weights, scale=1.0)
    rough = Rotation.from_rotvec([0.05, -0.04, 0.06]).as_matrix()
    start = Similarity(1.03, rough, 0.01 * shape.size * np.ones(3)).after(truth)
    pair = Pair.of(scan, shape, POINTS, None, seed)
    on = scan.sample(POINTS, seed + 7).points
    poses, scales = [], []
    for weight in WEIGHTS:
        one = replace(pair, way_back=weight)
        pose = without_holes(one, refine(one, start)).pose
        gap = pose.apply(on) - truth.apply(on)
        poses.append(100.0 * np.sqrt((gap**2).sum(axis=1).mean()) / shape.size)
        scales.append(100.0 * (pose.scale / truth.scale - 1.0))
    return np.array(poses), np.array(scales), shape.area / (scan.area * truth.scale**2)


def main(seeds: int) -> None:
    """Print a line for each kind of scan."""
    found: dict[tuple[str, str], list[tuple[Floats, Floats, float]]] = {}
    for name in DESIGNS:
        result = sm.simulate(sm.Design.from_toml(preset_text(name)))
        shape = Surface(result.positions[-1], result.mesh.triangles.astype(np.int64))
        for seed in range(seeds):
            for differs, lacks, scan, target in cases(result, np.random.default_rng(seed)):
                one = errors(scan, target, shape, seed)
                found.setdefault((differs, lacks), []).append(one)
    line = "{:9} {:11} {:>6} " + " {:>6}" * len(WEIGHTS)
    for k, title in enumerate(("error of the pose, % of the size", "error of the scale, RMS in %")):
        print(title)
        print(line.format("scan", "", "areas", *WEIGHTS))
        groups: dict[str, list[Floats]] = {"rough and bent": [], "earlier": []}
        for (differs, lacks), values in found.items():
            means = np.sqrt(np.mean([np.square(value[k]) for value in values], axis=0))
            groups["earlier" if differs == "earlier" else "rough and bent"].append(means)
            ratio = np.mean([value[2] for value in values])
            print(line.format(differs, lacks, f"{ratio:.2f}", *(f"{mean:.2f}" for mean in means)))
        for name, rows in groups.items():
            means = np.mean(rows, axis=0)
            print(f"{name:28} " + "".join(f" {mean:>6.3f}" for mean in means))


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 4)
