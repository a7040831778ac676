"""Where the search for other shapes begins: kicks, loads, mirrored states."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Self

import numpy as np

from sheetmorph.branches.walk import Bifurcation
from sheetmorph.core.sparse import SymmetricPattern
from sheetmorph.geometry.mesh import Floats
from sheetmorph.solve.path import Waypoint
from sheetmorph.solve.system import Energy, System
from sheetmorph.study.model import Problem

KICK = 0.01
"""Largest displacement of a kick at a bifurcation, over the size of the sheet."""

FAR_KICKS = (0.05, 0.2)
"""The same of kicks from a final shape, which have to leave its valley."""

RANDOM_RISE = 0.02
"""Largest displacement that a random load would bring about on the flat sheet without
actuation, over its size."""

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
        kind: "perturbation", "opposite perturbation", "bifurcation", "mode", "random load" or
            "mirrored".
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
