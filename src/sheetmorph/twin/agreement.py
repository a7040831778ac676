"""How near the computed shape and its finite-element twin are, node by node."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

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
        state: which of them is compared.
        twin: the finite elements.
        positions: of the twin's last state, moved onto the computed shape [m], shape (V, 3).
    """

    result: Result
    state: int
    twin: Twin
    positions: Floats

    @property
    def own(self) -> Floats:
        """Positions of the computed state [m], shape (V, 3)."""
        return np.asarray(self.result.positions[self.state])

    @property
    def distances(self) -> Floats:
        """Distance of each node from its twin [m], shape (V,)."""
        return np.asarray(np.linalg.norm(self.positions - self.own, axis=1))

    def to_json(self) -> dict[str, Any]:
        """All numbers, ready for a JSON file."""
        distances, twin, ran = self.distances, self.twin, self.twin.ran
        areas = twin.mesh.node_areas
        size = float(np.linalg.norm(np.ptp(self.own, axis=0)))
        rms = float(np.sqrt(areas @ distances**2 / areas.sum()))
        ratios = {"shape": self.own, "twin": self.positions}
        return {
            "model": self.result.summary["model"],
            "status": self.result.status,
            "node_rms_mm": 1e3 * rms,
            "node_maximum_mm": 1e3 * float(distances.max()),
            "node_rms_percent_of_size": 100.0 * rms / size,
            "size_mm": 1e3 * size,
            "aspect_ratio": {name: float(aspect_ratio(points)) for name, points in ratios.items()},
            "height_mm": {
                name: 1e3 * float(np.ptp(points[:, 2])) for name, points in ratios.items()
            },
            "eps_pre": {
                "shape": float(self.result.actuation[self.state]),
                "twin": float(twin.ramp[-1] * self.result.summary["eps_pre"]),
                "asked": float(self.result.summary["eps_pre"]),
            },
            "perturbation": {
                "shape": float(self.result.load_fraction[self.state]),
                "twin": float(twin.load[-1]),
            },
            "seconds": {
                "shape": float(self.result.summary["seconds"]["total"]),
                "twin": ran.seconds,
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
    """Compute the shape of a design where its twin ended, and lay the twin over it.

    A twin that did not reach the end is compared with the design at the actuation it reached,
    under the same part of the perturbation.

    Raises:
        InputError: the design and its mesh do not fit together.
    """
    fraction = float(twin.ramp[-1])
    result = simulate(design, stops=() if fraction == 1.0 else (fraction,), on_event=on_event)
    near = np.abs(result.ramp - fraction) + np.abs(result.load_fraction - twin.load[-1])
    state = int(near.argmin())
    moved = twin.positions[-1:]
    if not len(result.held_nodes):
        moved = align_to_reference(moved, result.positions[state])
    return Agreement(result, state, twin, moved[0])
