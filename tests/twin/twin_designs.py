"""Small designs of the tests of the finite-element twin."""

BILAYER = """
name = "twin"
model = "laminate"

[outline]
kind = "rectangle"
width = "12 mm"
height = "8 mm"

[[layers]]
name = "film"
role = "active"
thickness = "0.4 mm"
young_modulus = "1 MPa"
poisson_ratio = 0.3

[[layers]]
name = "rib"
role = "inert"
thickness = "1 mm"
young_modulus = "3 MPa"
poisson_ratio = 0.4
where = "pattern"

[[pattern]]
kind = "rectangle"
width = "4 mm"
height = "8 mm"

[actuation]
eps_pre = -0.2

[mesh]
size = "4 mm"
"""

FILM = """
name = "film"
model = "laminate"

[outline]
kind = "rectangle"
width = "10 mm"
height = "8 mm"

[[layers]]
name = "film"
role = "active"
thickness = "1 mm"
young_modulus = "1 MPa"
poisson_ratio = 0.3

[actuation]
eps_pre = -0.2
profile = "uniform"

[mesh]
size = "4 mm"
"""
