"""Where the search for other shapes begins: kicks, loads, mirrored states."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import combinations
from typing import Self

import numpy as np

from sheetmorph.branches.walk import Bifurcation
from sheetmorph.core.sparse import SymmetricPattern
from sheetmorph.geometry.mesh import Floats
from sheetmorph.solve.path import Waypoint
from sheetmorph.solve.system import Energy, System, allowed
from sheetmorph.study.model import Problem

KICK = 0.01
"""Largest displacement of a kick at a bifurcation, over the size of the sheet."""

FAR_KICKS = (0.05, 0.2)
"""The same of kicks from a final shape, which have to leave its valley."""

RANDOM_RISE = 0.02
"""Largest displacement that a random load would bring about on the flat sheet without
actuation, over its size."""

MOST_SECTORS = 6
"""Order of rotations up to which all sets of sectors are inverted."""

FADE = np.radians(8.0)
"""Angle at the side of a sector over which its inversion fades."""

WAVES = 3
"""Most waves of random loads over the size of the sheet."""


@dataclass(frozen=True, eq=False)
class Loaded:
    """An energy with a load of its own in the place of the perturbation.

    Attributes:
        energy: without load.
        force: at the full load [N], shape (n,).
        load: fraction of it.
    """

    energy: Energy
    force: Floats
    load: float = 0.0

    @property
    def pattern(self) -> SymmetricPattern:
        """Pattern of the Hessian."""
        return self.energy.pattern

    @property
    def linear_in_ramp(self) -> bool:
        """As without the load."""
        return bool(getattr(self.energy, "linear_in_ramp", True))

    def at(self, ramp: float, load: float) -> Self:
        """The energy at a fraction of the actuation and of this load."""
        return replace(self, energy=self.energy.at(ramp, 0.0), load=load)

    def reach(self, x: Floats, step: Floats) -> float:
        """As without the load."""
        return allowed(self.energy, x, step)

    def evaluate(self, x: Floats, order: int) -> tuple[float, Floats | None, Floats | None]:
        """See `Energy.evaluate`."""
        energy, gradient, data = self.energy.evaluate(x, order)
        if gradient is not None:
            gradient = gradient - self.load * self.force
        return energy - self.load * float(self.force @ x), gradient, data


@dataclass(frozen=True, eq=False)
class Seed:
    """A start from which a path is followed to full actuation.

    Attributes:
        name: for people, such as "kick + along mode 1 at 3.1 %".
        kind: "perturbation", "opposite perturbation", "bifurcation", "mode", "sectors",
            "random load" or "mirrored".
        waypoints: the loading path; a single one where the actuation is full.
        x: the state at its first point, or near it, shape (n,).
        system: the problem with the load of this seed.
    """

    name: str
    kind: str
    waypoints: tuple[Waypoint, ...]
    x: Floats
    system: System


def opposite(problem: Problem, system: System) -> Seed:
    """The run of the design with its perturbation load reversed."""
    way = (Waypoint(0.0, -1.0), Waypoint(1.0, -1.0), Waypoint(1.0, 0.0))
    name = "opposite perturbation"
    return Seed(name, name, way, problem.start, system)


def at_bifurcations(
    problem: Problem, system: System, found: Sequence[Bifurcation], most: int
) -> list[Seed]:
    """Kicks of both signs along the modes that have lost their stability."""
    seeds = []
    for place in found:
        ramp, x = place.beyond.ramp, place.beyond.x
        way = (Waypoint(ramp, 0.0), *((Waypoint(1.0, 0.0),) if ramp < 1.0 else ()))
        for k, mode in enumerate(place.modes[:most]):
            for sign, text in ((1.0, "+"), (-1.0, "−")):
                name = f"kick {text} along mode {place.before + k + 1} at {100 * ramp:.3g} %"
                kicked = x + sign * KICK * problem.mesh.size * mode
                seeds.append(Seed(name, "bifurcation", way, kicked, system))
    return seeds


def from_modes(problem: Problem, system: System, x: Floats, modes: Floats, of: str) -> list[Seed]:
    """Wide kicks of both signs along the modes (k, n) of a final state."""
    seeds = []
    for k, mode in enumerate(modes):
        for far in FAR_KICKS:
            for sign, text in ((1.0, "+"), (-1.0, "−")):
                name = f"kick {text} of {100 * far:g} % along mode {k + 1} of {of}"
                kicked = x + sign * far * problem.mesh.size * mode
                seeds.append(Seed(name, "mode", (Waypoint(1.0, 0.0),), kicked, system))
    return seeds


def with_sectors_inverted(problem: Problem, system: System, x: Floats) -> list[Seed]:
    """A final state with sectors of the design's rotations mirrored at the plane of its middle.

    All sets of sectors but the whole sheet, those alone that no rotation or mirror image takes
    into each other. None for designs without rotations, or with more of them than 6.
    """
    order = problem.design.symmetry.order
    if not 2 <= order <= MOST_SECTORS:
        return []
    seeds = []
    for chosen in sets_of_sectors(order):
        name = f"sectors {', '.join(str(k + 1) for k in chosen)} of {order} inverted"
        moved = inverted_sectors(problem, x, chosen)
        seeds.append(Seed(name, "sectors", (Waypoint(1.0, 0.0),), moved, system))
    return seeds


def sets_of_sectors(order: int) -> list[tuple[int, ...]]:
    """Sets of 1 to order − 1 of the sectors around, one of each kind of necklace."""
    seen: set[tuple[int, ...]] = set()
    kept = []
    for count in range(1, order):
        for chosen in combinations(range(order), count):
            if chosen not in seen:
                kept.append(chosen)
            seen |= {
                tuple(sorted((sign * k + turn) % order for k in chosen))
                for turn in range(order)
                for sign in (1, -1)
            }
    return kept


def sector_shares(problem: Problem) -> Floats:
    """How far each node belongs to each sector of the design, 0 to 1, shape (order, V).

    With mirror lines the first sector lies about the first of them.
    """
    symmetry = problem.design.symmetry
    x, y = (problem.mesh.nodes[:, :2] - symmetry.centre).T
    first, width = symmetry.mirror or 0.0, 2.0 * np.pi / symmetry.order
    rows = []
    for k in range(symmetry.order):
        off = np.arctan2(y, x) - first - k * width
        off = np.abs((off + np.pi) % (2.0 * np.pi) - np.pi)
        rows.append(np.clip((0.5 * width - off) / FADE, 0.0, 1.0))
    return np.array(rows)


def inverted_sectors(
    problem: Problem, x: Floats, chosen: Sequence[int], depth: float = 1.0
) -> Floats:
    """A state with sectors mirrored at the height of the sheet's middle, shape (n,).

    Args:
        problem: the problem.
        x: the state, shape (n,).
        chosen: numbers of the sectors.
        depth: height beyond the middle over that on this side of it; 1 for a mirror image.
    """
    share = sector_shares(problem)[list(chosen)].sum(axis=0)
    moved, size = x.copy(), problem.mesh.nodes.size
    middle = np.linalg.norm(problem.mesh.nodes[:, :2] - problem.design.symmetry.centre, axis=1)
    z = x[2:size:3]
    level = float(z[middle.argmin()])
    moved[2:size:3] = level + (1.0 - (1.0 + depth) * share) * (z - level)
    return moved


def random_loads(problem: Problem, system: System, count: int, seed: int) -> list[Seed]:
    """Runs under smooth random loads out of the plane, each from its own seed."""
    way = (Waypoint(0.0, 1.0), Waypoint(1.0, 1.0), Waypoint(1.0, 0.0))
    flat = system.at(0.0, 0.0)
    _, _, data = flat.hessian(problem.start)
    # The flat sheet without actuation is stable; a trace of stiffness where it just is.
    shift = 0.0
    while not flat.factorise(data, shift):
        shift = max(10.0 * shift, 1e-12 * float(np.abs(data).max()))
    responses = []
    for k in range(count):
        force = _smooth_force(problem, seed + k)
        rise = np.abs(flat.solve(force)[: problem.mesh.nodes.size]).max()
        responses.append(force * (RANDOM_RISE * problem.mesh.size / rise))
    return [
        Seed(
            f"random load {seed + k}",
            "random load",
            way,
            problem.start,
            replace(system, energy=Loaded(system.energy, force)),
        )
        for k, force in enumerate(responses)
    ]


def _smooth_force(problem: Problem, seed: int) -> Floats:
    rng = np.random.default_rng(seed)
    mesh = problem.mesh
    plane = (mesh.nodes[:, :2] - mesh.nodes[:, :2].mean(axis=0)) / mesh.size
    waves = rng.uniform(-WAVES, WAVES, (8, 2))
    phases = rng.uniform(0.0, 2.0 * np.pi, 8)
    height = np.cos(2.0 * np.pi * plane @ waves.T + phases) @ rng.standard_normal(8)
    force = np.zeros(len(problem.held_dofs))
    force[2 : mesh.nodes.size : 3] = mesh.node_areas * (height - height.mean())
    force[problem.held_dofs] = 0.0
    return force
