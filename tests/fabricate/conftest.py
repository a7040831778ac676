"""Designs to make, from the text of their pattern."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path

import pytest

from sheetmorph.design.presets import preset_text
from sheetmorph.design.spec import Design

DISC = '[outline]\nkind = "disc"\nradius = "50 mm"\n'
FILM = """
[[layers]]
name = "polystyrene"
role = "active"
thickness = "0.3 mm"
young_modulus = "0.9 MPa"
density = "1050 kg/m^3"
"""
INERT = """
[[layers]]
name = "inert {part}"
role = "inert"
thickness = "0.8 mm"
young_modulus = "2.7 MPa"
density = "1250 kg/m^3"
where = "{part}"
"""
REST = '\n[actuation]\n{actuation}\n[mesh]\nsize = "4 mm"\n'

TWO_FACES = """
[outline]
kind = "rectangle"
width = "120 mm"
height = "80 mm"
corner_radius = "8 mm"
slits = [[["-50 mm", "0 mm"], ["-30 mm", "0 mm"]]]
[[outline.cutouts]]
kind = "disc"
radius = "5 mm"
centre = ["45 mm", "0 mm"]
[[pattern]]
part = "arms"
kind = "star"
arms = 5
arm_length = "35 mm"
half_width = "3 mm"
[[pattern]]
part = "rail"
kind = "rectangle"
width = "90 mm"
height = "6 mm"
centre = ["-10 mm", "-25 mm"]
rotation = "10 deg"
"""

Make = Callable[..., Design]


def complete(
    text: str,
    *,
    below: tuple[str, ...] = (),
    actuation: str = "eps_pre = -0.3",
    name: str = "test",
    folder: Path | None = None,
) -> Design:
    """A design from its outline and pattern: each part has a layer, those in `below` on the
    underside."""
    outline = "" if "[outline]" in text else DISC
    parts = list(dict.fromkeys(re.findall(r'^part = "([^"]+)"$', text, re.MULTILINE)))
    blocks = text.split("[[pattern]]")[1:]
    if any("part =" not in block for block in blocks):
        parts.insert(0, "pattern")
    lower = "".join(INERT.format(part=part) for part in parts if part in below)
    upper = "".join(INERT.format(part=part) for part in parts if part not in below)
    rest = REST.format(actuation=actuation)
    toml = f'name = "{name}"\n{text}\n{outline}\n{lower}{FILM}{upper}{rest}'
    return Design.from_toml(toml, folder)


@pytest.fixture
def make() -> Make:
    """`make(text, below=(), actuation=...)` gives a design."""
    return complete


@pytest.fixture(scope="session")
def bowl() -> Design:
    return Design.from_toml(preset_text("bowl"))


@pytest.fixture(scope="session")
def two_faces() -> Design:
    """A rounded plate with a hole and a slit, five arms on top, a rail on the underside."""
    return complete(TWO_FACES, below=("rail",))


SKINNED = """
name = "skinned"
[outline]
kind = "disc"
radius = "50 mm"
[[pattern]]
kind = "rectangle"
part = "up"
width = "60 mm"
height = "10 mm"
[[pattern]]
kind = "rectangle"
part = "down"
width = "10 mm"
height = "60 mm"
"""
_STACK = (
    ("outer", "inert", "0.2 mm", 2000, "down"),
    ("inner", "inert", "0.4 mm", 1250, "down"),
    ("polystyrene", "active", "0.3 mm", 1050, "everywhere"),
    ("skin", "inert", "0.1 mm", 1000, "everywhere"),
    ("rib", "inert", "0.8 mm", 1250, "up"),
)


@pytest.fixture(scope="session")
def skinned() -> Design:
    """Two layers of one part beneath, a whole inert sheet on top and a part on that."""
    layers = "".join(
        f'[[layers]]\nname = "{name}"\nrole = "{role}"\nthickness = "{thickness}"\n'
        f'young_modulus = "1 MPa"\ndensity = "{density} kg/m^3"\nwhere = "{where}"\n'
        for name, role, thickness, density, where in _STACK
    )
    return Design.from_toml(SKINNED + layers + REST.format(actuation="eps_pre = -0.3"))


@pytest.fixture(scope="session")
def bare() -> Design:
    """A sheet without pattern."""
    return complete("")
