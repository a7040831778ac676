"""A shape against a twin of itself: no distance; against one that is moved by a known amount."""

from __future__ import annotations

import numpy as np
import pytest
from twin_designs import BILAYER

import sheetmorph as sm
from sheetmorph.solve.constraints import align_to_reference
from sheetmorph.twin.agreement import agree
from sheetmorph.twin.ccx import Ran
from sheetmorph.twin.solve import Twin

DESIGN = sm.Design.from_toml(BILAYER).with_values({"mesh.size": "2 mm"})
RAMP = np.array([0.0, 0.25, 0.5, 0.75, 1.0, 1.0])
LOAD = np.array([1.0, 1.0, 1.0, 1.0, 1.0, 0.0])


def twin_of_itself(steps: int, change: float = 0.0) -> Twin:
    """What a perfect solver finds up to a step, the node in the middle moved up by `change`."""
    result = sm.simulate(DESIGN, stops=(0.25, 0.5, 0.75))
    angle = 0.7
    turn = np.array(
        [[np.cos(angle), -np.sin(angle), 0], [np.sin(angle), np.cos(angle), 0], [0, 0, 1]]
    )
    positions = []
    for ramp, load in zip(RAMP[:steps], LOAD[:steps], strict=True):
        away = np.abs(result.ramp - ramp) + np.abs(result.load_fraction - load)
        state = result.positions[int(away.argmin())] @ turn.T + 0.01
        positions.append(state)
    ran = Ran("completed" if steps == len(RAMP) else "time_limit", "", 10.0, (), 0)
    moved = align_to_reference(np.array(positions), result.mesh.nodes)
    middle = int(np.linalg.norm(result.mesh.nodes, axis=1).argmin())
    moved[:, middle, 2] += change
    return Twin(result.mesh, moved, RAMP[:steps], LOAD[:steps], 0, 0, "natural", "0", ran)


def test_a_twin_of_itself_has_no_distance() -> None:
    found = agree(DESIGN, twin_of_itself(6)).to_json()
    assert found["node_maximum_mm"] < 1e-6
    assert found["aspect_ratio"]["shape"] == pytest.approx(found["aspect_ratio"]["twin"])
    assert [round(step["eps_pre"], 6) for step in found["path"]] == [-0.05, -0.1, -0.15, -0.2, -0.2]
    assert found["perturbation"] == {"shape": 0.0, "twin": 0.0}


def test_a_twin_that_stopped_is_compared_where_it_stopped() -> None:
    found = agree(DESIGN, twin_of_itself(3)).to_json()
    assert found["node_maximum_mm"] < 1e-6
    assert found["eps_pre"] == pytest.approx({"shape": -0.1, "twin": -0.1, "asked": -0.2})
    assert found["perturbation"] == {"shape": 1.0, "twin": 1.0}
    assert found["twin"]["ended"] == "time_limit"


def test_distances_are_those_of_the_nodes() -> None:
    found = agree(DESIGN, twin_of_itself(6, 1e-4)).to_json()
    assert found["node_maximum_mm"] == pytest.approx(0.1, rel=0.1)
    assert 0.0 < found["node_rms_mm"] < 0.5 * found["node_maximum_mm"]
