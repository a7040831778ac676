"""The text of a design that is solved in a tenth of a second."""

SMALL = """
name = "small"
model = "published"
[outline]
kind = "disc"
radius = "20 mm"
[[pattern]]
kind = "star"
arms = 3
arm_length = "16 mm"
half_width = "3 mm"
[[layers]]
name = "film"
role = "active"
thickness = "0.3 mm"
young_modulus = "1 MPa"
[[layers]]
name = "print"
role = "inert"
thickness = "0.7 mm"
young_modulus = "3 MPa"
where = "pattern"
[actuation]
eps_pre = -0.4
[perturbation]
shape = "bowl"
direction = "up"
ramp_down_steps = 1
[mesh]
size = "3 mm"
"""
