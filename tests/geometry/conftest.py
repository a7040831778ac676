"""Sheets of the paper."""

from __future__ import annotations

import numpy as np
import pytest
import shapely
from shapely import affinity

from sheetmorph.geometry.generate import generate_mesh
from sheetmorph.geometry.topology import build_mesh


def in_metres(shape):
    return affinity.scale(shape, 1e-3, 1e-3, origin=(0, 0))


def arm(length, half_width, angle, x=0.0, back=0.0):
    bar = shapely.box(-back, -half_width, length, half_width)
    return affinity.translate(affinity.rotate(bar, angle, origin=(0, 0)), x)


def bowl():
    arms = [arm(44.1, 5.9, 60 * k) for k in range(6)]
    pattern = shapely.unary_union([*arms, shapely.Point(0, 0).buffer(2.9)])
    return in_metres(shapely.Point(0, 0).buffer(50, quad_segs=64)), in_metres(pattern), 3.2e-3


def canoe():
    arms = [arm(44.595, 2.787, 60 * k, x) for k in range(6) for x in (-27.87, 27.87)]
    pattern = shapely.unary_union([*arms, shapely.box(-27.87, -2.787, 27.87, 2.787)])
    return in_metres(shapely.box(-77.65, -50, 77.65, 50)), in_metres(pattern), 4.0e-3


def petals():
    outline = shapely.box(-50, -50.95, 50, 50.95)
    arms = shapely.unary_union([arm(70.7, 5.9, angle, back=70.7) for angle in (45, 135)])
    return in_metres(outline), in_metres(arms.intersection(outline)), 5.8e-3


SHEETS = {"bowl": bowl, "canoe": canoe, "petals": petals}


@pytest.fixture(scope="session")
def sheets():
    """Outline, pattern and mesh size of the paper's designs [m]."""
    return {name: make() for name, make in SHEETS.items()}


@pytest.fixture(scope="session")
def meshes(sheets):
    """The three meshes of the paper's designs, made once."""
    return {name: generate_mesh(*sheet) for name, sheet in sheets.items()}


@pytest.fixture
def square():
    """Four triangles around the middle of a unit square."""
    nodes = [[0, 0], [1, 0], [1, 1], [0, 1], [0.5, 0.5]]
    return build_mesh(np.array(nodes, float), [[0, 1, 4], [1, 2, 4], [2, 3, 4], [3, 0, 4]])
