"""A design that is solved in a tenth of a second, and its result."""

from __future__ import annotations

import pytest
from small import SMALL

import sheetmorph as sm


@pytest.fixture(scope="session")
def small_design() -> sm.Design:
    return sm.Design.from_toml(SMALL)


@pytest.fixture(scope="session")
def small_result(small_design: sm.Design) -> sm.Result:
    return sm.simulate(small_design)
