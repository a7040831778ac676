"""How many lobes of the bowl can be inverted, each by itself, in the printed form of the model.

A lobe is a sixth of the bowl: an arm with the film beside it, which is inverted by mirroring it
at the plane of the hub; or, with --film, the film between two arms, which is mirrored at the
surface that hangs between them (harmonic on the mesh). Then the energy is minimised; where that
leads back, other depths than the mirror image's are tried. A lobe stays inverted where the result
is stable, the outer half of its arm turns (its film bulges) to the other side than before, and no
other lobe has changed sides. A shape that leans on a guard is one of the mesh, not of the sheet.

    python benchmarks/lobes.py [--size "4 mm"] [--form printed] [--film] [--all]
"""

from __future__ import annotations

import argparse
from itertools import product

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array, diags_array
from scipy.sparse.linalg import spsolve

import sheetmorph as sm
from sheetmorph.branches.seeds import inverted_sectors, sector_shares, sets_of_sectors
from sheetmorph.design.presets import preset_text
from sheetmorph.geometry.mesh import Floats
from sheetmorph.show.scene import node_normals
from sheetmorph.solve.minimise import NewtonOptions, Outcome, minimise
from sheetmorph.solve.stability import negative_eigenvalues
from sheetmorph.study.model import Problem, build_problem
from sheetmorph.study.stability import system_of

Bools = NDArray[np.bool_]

LOBES = 6
DEPTHS = (1.0, 1.5, 0.6, 2.0)
"""How far a lobe is pushed to the other side, over how far it was on this one; tried in turn."""


def main() -> None:
    """Invert lobes one by one, or all sets of them."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--size", default="4 mm")
    parser.add_argument("--form", default="printed")
    parser.add_argument("--film", action="store_true", help="the film between the arms")
    parser.add_argument("--all", action="store_true", help="all sets of lobes up to symmetry")
    given = parser.parse_args()
    values = {
        "mesh.size": given.size,
        "mesh.symmetry": "auto",
        "published.stretch_stiffness": given.form,
    }
    design = sm.Design.from_toml(preset_text("bowl")).with_values(values)
    result = sm.simulate(design)
    if result.status != "completed":
        raise SystemExit(f"{design.name}, {given.form}, {given.size}: {result.status}")
    problem = build_problem(design, result.mesh)
    here = system_of(problem).at(1.0, 0.0)
    options = NewtonOptions(problem.residual_tolerance, max_iterations=1000)
    start = result.positions[-1]
    inside = np.zeros(len(start), dtype=bool)
    inside[result.mesh.triangles[result.triangle_in_pattern]] = True
    kind = Film(problem, inside) if given.film else Arms(problem, inside)
    before = kind.sides(start)
    detail = result.summary["detail"]
    print(
        f"{design.name}, {given.form}, {given.size}: {result.status}, {len(start)} nodes {detail}"
    )
    print(f"{kind.measure} [{kind.unit}]:", np.round(kind.factor * before, 1))
    sets = sets_of_sectors(LOBES) if given.all else [(k,) for k in range(LOBES)]
    held: set[tuple[int, ...]] = set()
    leaning = 0
    for chosen, depth in product(sets, DEPTHS):
        if chosen in held:
            continue
        x = kind.inverted(start, chosen, depth).ravel()
        found = minimise(here, x, options)
        after = kind.sides(found.x.reshape(-1, 3))
        stable = found.outcome is Outcome.CONVERGED and not negative_eigenvalues(here, found.x)
        wanted = np.where(np.isin(np.arange(LOBES), chosen), -1.0, 1.0)
        kept = bool((wanted * after * before > 0.0).all())
        leans = problem.held_open(problem.positions(found.x))
        if stable and kept:
            held.add(chosen)
            leaning += bool(leans)
        print(
            f"{chosen}, depth {depth:g}: {found.outcome}, stable {stable}, inverted {kept}, energy "
            f"{1e3 * found.energy:.4f} mJ, {np.round(kind.factor * after, 1)}"
            + "".join(f", {count} {what}" for what, count in leans.items())
        )
    print(
        f"{len(held)} of {len(sets)} {'sets' if given.all else 'lobes'} stay inverted, "
        f"{leaning} of these lean on a guard"
    )


class Arms:
    """Sixths about the arms, mirrored at the plane of the hub."""

    measure = "turn of the outer half of the arms towards the axis"
    unit, factor = "degrees", 180.0 / np.pi

    def __init__(self, problem: Problem, inside: Bools) -> None:
        self._problem = problem
        nodes = problem.mesh.nodes[:, :2]
        angles = np.arange(LOBES) * np.pi / 3.0 + (problem.design.symmetry.mirror or 0.0)
        self._outward = np.column_stack([np.cos(angles), np.sin(angles)])
        along = nodes @ self._outward.T / np.linalg.norm(nodes, axis=1).max()
        arm = ((sector_shares(problem) > 0.5) & inside).T
        self._pieces = [arm & (along > low) & (along < low + 0.15) for low in (0.4, 0.57, 0.74)]

    def sides(self, positions: Floats) -> Floats:
        """Angles [rad] from the inner to the outer piece, up from outward, shape (6,)."""
        turns = []
        for k, outward in enumerate(self._outward):
            places = np.array([positions[piece[:, k]].mean(axis=0) for piece in self._pieces])
            path = np.column_stack([places[:, :2] @ outward, places[:, 2]])
            slopes = np.arctan2(*np.diff(path, axis=0).T[::-1])
            turns.append((slopes[1] - slopes[0] + np.pi) % (2.0 * np.pi) - np.pi)
        return np.array(turns)

    def inverted(self, positions: Floats, chosen: tuple[int, ...], depth: float) -> Floats:
        """The shape with lobes mirrored, shape (V, 3)."""
        return inverted_sectors(self._problem, positions.ravel(), chosen, depth).reshape(-1, 3)


class Film:
    """The film between arms, mirrored at the surface that hangs between them."""

    measure = "bulge of the film between the arms"
    unit, factor = "mm", 1e3

    def __init__(self, problem: Problem, inside: Bools) -> None:
        mesh = problem.mesh
        self._mesh, self._inside = mesh, inside
        around = np.arctan2(mesh.nodes[:, 1], mesh.nodes[:, 0]) % (2.0 * np.pi)
        self._shares = np.array([around // (np.pi / 3.0) == k for k in range(LOBES)], dtype=float)
        count = len(mesh.nodes)
        a, b = mesh.edges.T
        places = (np.r_[a, b], np.r_[b, a])
        joined = coo_array((np.ones(2 * len(a)), places), shape=(count, count)).tocsr()
        self._laplacian = (diags_array(joined.sum(axis=1)) - joined).tocsr()

    def _hanging(self, positions: Floats) -> Floats:
        free, inside = ~self._inside, self._inside
        rows = self._laplacian[free]
        base = positions.copy()
        base[free] = spsolve(rows[:, free].tocsc(), -rows[:, inside] @ positions[inside])
        return base

    def sides(self, positions: Floats) -> Floats:
        """Mean heights over the hanging surface [m], shape (6,)."""
        base = self._hanging(positions)
        height = ((positions - base) * node_normals(base, self._mesh.triangles)).sum(axis=1)
        weights = self._shares * np.where(self._inside, 0.0, self._mesh.node_areas)
        return np.asarray(weights @ height / weights.sum(axis=1))

    def inverted(self, positions: Floats, chosen: tuple[int, ...], depth: float) -> Floats:
        """The shape with lobes mirrored, shape (V, 3)."""
        base = self._hanging(positions)
        share = self._shares[list(chosen)].sum(axis=0)[:, None]
        return base + (1.0 - (1.0 + depth) * share) * (positions - base)


if __name__ == "__main__":
    main()
