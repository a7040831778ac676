"""What is kept of a motion beside its states: times, velocities, and the account of energy."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from sheetmorph.geometry.mesh import Floats

COLUMNS: dict[str, tuple[str, str]] = {
    "time_s": ("s", "time at the end of the step"),
    "step_s": ("s", "length of the step"),
    "actuation": ("1", "fraction of the actuation"),
    "loads": ("1", "factor on the loads"),
    "perturbation": ("1", "factor on the perturbation load"),
    "kinetic_J": ("J", "kinetic energy"),
    "elastic_J": ("J", "elastic energy, and that of contact"),
    "actuation_work_J": ("J", "work of the actuation so far"),
    "load_work_J": ("J", "work of all loads so far"),
    "damped_J": ("J", "energy that damping has taken so far"),
    "numerical_J": ("J", "energy that the steps in time have taken so far"),
    "fastest_m_per_s": ("m/s", "speed of the fastest node"),
    "height_m": ("m", "extent along z"),
}
"""Columns of the history: unit and meaning."""


@dataclass(frozen=True, eq=False)
class MotionRecord:
    """The motion of a run with S kept states, N steps and V nodes.

    In every row of the history, kinetic and elastic energy are those of the first row plus the
    works of actuation and loads, less what damping and the steps have taken.

    Attributes:
        time: of the states [s], shape (S,).
        loads: factor on the loads at the states, shape (S,).
        velocity: of the nodes at the states [m/s], shape (S, V, 3).
        history: COLUMNS, shape (N + 1,) each, from the moment at the start.
    """

    time: Floats
    loads: Floats
    velocity: Floats
    history: Mapping[str, Floats]

    @property
    def kinetic_peak(self) -> float:
        """Largest kinetic energy of the motion [J]."""
        return float(self.history["kinetic_J"].max())

    def to_csv(self) -> str:
        """The history as a table, a row per step."""
        rows = np.column_stack([self.history[name] for name in COLUMNS])
        lines = [",".join(COLUMNS)]
        lines += [",".join(f"{value:.9g}" for value in row) for row in rows]
        return "\n".join(lines) + "\n"
