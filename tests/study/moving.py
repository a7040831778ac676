"""Designs that move."""

from __future__ import annotations

from small import SMALL

import sheetmorph as sm
from sheetmorph.proofs.bilayer_disc import DESIGN, RADIUS, THICKNESS
from sheetmorph.proofs.sheets import QUARTER

LENGTH, WIDTH, HEIGHT = 0.1, 0.01, 1e-3
YOUNG, DENSITY, FORCE = 1e9, 1000.0, 5e-4

CANTILEVER = f"""
name = "cantilever"
model = "laminate"
[outline]
kind = "rectangle"
width = "{LENGTH} m"
height = "{WIDTH} m"
centre = ["{LENGTH / 2} m", "{WIDTH / 2} m"]
[[layers]]
name = "strip"
role = "inert"
thickness = "{HEIGHT} m"
young_modulus = "{YOUNG} Pa"
poisson_ratio = 0
density = "{DENSITY} kg/m^3"
[perturbation]
total_force = "0 N"
[[supports]]
kind = "box"
x = ["0 m", "0 m"]
y = ["0 m", "{WIDTH} m"]
clamp = true
[[loads]]
kind = "line"
x = ["{LENGTH} m", "{LENGTH} m"]
y = ["0 m", "{WIDTH} m"]
force_per_length = ["0 N/m", "0 N/m", "{FORCE / WIDTH} N/m"]
[mesh]
size = "5 mm"
[solver]
kind = "dynamic"
[solver.dynamic]
time_step = "1 ms"
integrator = "trapezoidal"
start = "equilibrium"
end_time = "70 ms"
output_interval = "1 us"
[solver.dynamic.course]
times = ["0 s", "1 us"]
actuation = [0, 0]
loads = [1, 0]
"""
"""A strip that is bent by a force at its end and let go."""

POKED = (
    DESIGN.replace('young_modulus = "1 MPa"', 'young_modulus = "1 GPa"\ndensity = "1100 kg/m^3"')
    + QUARTER
    + f"""
[[loads]]
kind = "point"
at = ["{RADIUS} m", "0 m"]
force = ["0 N", "0 N", "-{1.5 * 0.1 * 1e9 * THICKNESS**4 / RADIUS**2} N"]
[solver]
kind = "dynamic"
[solver.dynamic]
time_step = "4 ms"
damping = "20 1/s"
[solver.dynamic.course]
times = ["0 s", "0.4 s", "0.6 s", "0.7 s", "0.8 s", "1 s", "1.1 s"]
actuation = [0, 1, 1, 1, 1, 1, 1]
loads = [-0.2, -0.2, 0, 0, 1, 1, 0]
"""
)
"""A quarter of the bistable disc: raised along x by a small force, then pressed down there."""


def moving(model: str = "published", **more: object) -> sm.Design:
    """The small design in motion: actuated in a second, held, and let settle."""
    text = SMALL.replace('"published"', f'"{model}"')
    for modulus, density in (("1 MPa", 1050), ("3 MPa", 1250)):
        key = f'young_modulus = "{modulus}"'
        text = text.replace(key, f'{key}\ndensity = "{density} kg/m^3"')
    text += """
[solver]
kind = "dynamic"
[solver.dynamic]
time_step = "20 ms"
damping = "20 1/s"
[solver.dynamic.course]
times = ["0 s", "1 s", "1.2 s"]
actuation = [0, 1, 1]
"""
    design = sm.Design.from_toml(text)
    return design.with_values({f"solver.dynamic.{key}": value for key, value in more.items()})
