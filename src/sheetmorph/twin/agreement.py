"""How near the computed shape and its finite-element twin are, node by node."""

from __future__ import annotations

from dataclasses import dataclass
from time import process_time
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sheetmorph.core.events import Listener, silent
from sheetmorph.design.spec import Design
from sheetmorph.geometry.mesh import Floats
from sheetmorph.geometry.surface import aspect_ratio
from sheetmorph.solve.constraints import align_to_reference
from sheetmorph.study.result import Result
from sheetmorph.study.simulate import simulate
from sheetmorph.twin.solve import Twin


@dataclass(frozen=True, eq=False)
class Agreement:
    """A computed shape beside its twin, at the actuation that the twin reached.

    Attributes:
        result: the computed states.
        states: of them, those compared, at the ends of the twin's steps, shape (S,).
        twin: the finite elements.
        moved: states of the twin at these, moved onto the computed ones [m], shape (S, V, 3).
        processor_seconds: for the computed states, meshing and all.
    """

    result: Result
    states: NDArray[np.intp]
    twin: Twin
    moved: Floats
    processor_seconds: float

    @property
    def own(self) -> Floats:
        """Positions of the last computed state that is compared [m], shape (V, 3)."""
        return np.asarray(self.result.positions[self.states[-1]])

    @property
    def positions(self) -> Floats:
        """Positions of the twin there [m], shape (V, 3)."""
        return np.asarray(self.moved[-1])

    @property
    def distances(self) -> Floats:
        """Distance of each node from its twin, at all states compared [m], shape (S, V)."""
        return np.asarray(np.linalg.norm(self.moved - self.result.positions[self.states], axis=2))

    def to_json(self) -> dict[str, Any]:
        """All numbers, ready for a JSON file."""
        distances, twin, ran = self.distances, self.twin, self.twin.ran
        areas, last = twin.mesh.node_areas, self.states[-1]
        size = float(np.linalg.norm(np.ptp(self.own, axis=0)))
        rms = _root_mean_square(distances[-1], areas)
        ratios = {"shape": self.own, "twin": self.positions}
        return {
            "model": self.result.summary["model"],
            "status": self.result.status,
            "node_rms_mm": 1e3 * rms,
            "node_maximum_mm": 1e3 * float(distances[-1].max()),
            "node_rms_percent_of_size": 100.0 * rms / size,
            "size_mm": 1e3 * size,
            "aspect_ratio": {name: float(aspect_ratio(points)) for name, points in ratios.items()},
            "height_mm": {
                name: 1e3 * float(np.ptp(points[:, 2])) for name, points in ratios.items()
            },
            "eps_pre": {
                "shape": float(self.result.actuation[last]),
                "twin": float(twin.ramp[-1] * self.result.summary["eps_pre"]),
                "asked": float(self.result.summary["eps_pre"]),
            },
            "perturbation": {
                "shape": float(self.result.load_fraction[last]),
                "twin": float(twin.load[-1]),
            },
            "path": [
                {
                    "eps_pre": float(self.result.actuation[state]),
                    "node_rms_mm": 1e3 * _root_mean_square(apart, areas),
                    "height_mm": {
                        "shape": 1e3 * float(np.ptp(self.result.positions[state][:, 2])),
                        "twin": 1e3 * float(np.ptp(points[:, 2])),
                    },
                }
                for state, apart, points in zip(self.states, distances, self.moved, strict=True)
            ],
            "seconds": {
                "shape": float(self.result.summary["seconds"]["total"]),
                "twin": ran.seconds,
            },
            "processor_seconds": {
                "shape": self.processor_seconds,
                "twin": ran.processor_seconds,
            },
            "twin": {
                "solver": f"CalculiX {twin.version}".strip(),
                "law": twin.law,
                "ended": ran.ending,
                "message": ran.message,
                "steps": len(twin.ramp),
                "increments": len(ran.times),
                "iterations": ran.iterations,
                "nodes": twin.nodes,
                "elements": twin.elements,
            },
        }


def agree(design: Design, twin: Twin, on_event: Listener = silent) -> Agreement:
    """Compute the shape of a design along the path of its twin, and lay the twin over it.

    The steps of the actuation are those of the twin: a sheet with several stable shapes may
    take another one when it is actuated in other steps. A twin that did not reach the end is
    compared at the actuation it reached, under the same part of the perturbation.

    Raises:
        InputError: the design and its mesh do not fit together.
    """
    design.must_be_still("a finite-element twin")
    inner = np.unique(twin.ramp[(twin.ramp > 0.0) & (twin.ramp < 1.0)])
    began = process_time()
    result = simulate(design, stops=tuple(float(ramp) for ramp in inner), on_event=on_event)
    used = process_time() - began
    pairs = [
        (_state(result, ramp, load), positions)
        for ramp, load, positions in zip(twin.ramp, twin.load, twin.positions, strict=True)
        if ramp > 0.0
    ] or [(0, twin.positions[-1])]
    path = np.array([state for state, _ in pairs])
    moved = np.array([positions for _, positions in pairs])
    if not len(result.held_nodes):
        moved = np.array(
            [
                align_to_reference(positions[None], result.positions[state])[0]
                for state, positions in pairs
            ]
        )
    return Agreement(result, path, twin, moved, used)


def _state(result: Result, ramp: float, load: float) -> int:
    """The state nearest to an actuation and a part of the perturbation."""
    away = np.abs(result.ramp - ramp) + np.abs(result.load_fraction - load)
    return int(away.argmin())


def _root_mean_square(distances: Floats, areas: Floats) -> float:
    return float(np.sqrt(areas @ distances**2 / areas.sum()))
