"""Derivatives by keys of a design without a chain rule: the energy is set up anew for each."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

import sheetmorph as sm
from sheetmorph.solve.adjoint import adjoint_state
from sheetmorph.solve.constraints import HeldDofs
from sheetmorph.solve.linear import make_solver
from sheetmorph.solve.system import System
from sheetmorph.study.design_keys import with_number
from sheetmorph.study.model import build_problem
from sheetmorph.study.sensitivity import Objective

STEP = 1e-5


class Anew:
    """The last state of a run, its adjoint, and forces on it by other designs."""

    def __init__(self, result: sm.Result, objective: Objective) -> None:
        """Solve for λ."""
        problem = build_problem(result.design, result.mesh)
        self.result = result
        self.x = np.concatenate([result.positions[-1].ravel(), result.scalars[-1]])
        self.at = float(result.ramp[-1]), float(result.load_fraction[-1])
        pattern, growth = problem.total.pattern, problem.total.growth
        system = System(
            problem.total.at(*self.at),
            HeldDofs.of(pattern, problem.held_dofs),
            make_solver(pattern, growth=growth),
        )
        slope = np.zeros_like(self.x)
        slope[: result.mesh.nodes.size] = objective(result.positions[-1])[1].ravel()
        self.adjoint = adjoint_state(system, self.x, slope, 10.0 * problem.residual_tolerance)

    def work(self, values: Mapping[str, float]) -> float:
        """−λᵀ g with other numbers at some keys."""
        design = self.result.design
        for key, value in values.items():
            design = with_number(design, key, value)
        total = build_problem(design, self.result.mesh).total.at(*self.at)
        gradient = total.evaluate(self.x, 1)[1]
        assert gradient is not None
        return float(-self.adjoint @ gradient)

    def slope(self, values: Mapping[str, float], rates: Mapping[str, float]) -> float:
        """Derivative along a motion of some keys, by a central difference."""
        ahead, behind = (
            self.work({key: value + step * rates[key] for key, value in values.items()})
            for step in (STEP, -STEP)
        )
        return (ahead - behind) / (2.0 * STEP)
