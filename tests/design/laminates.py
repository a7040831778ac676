"""A small design of the laminate model: a bar on a 40 mm x 20 mm sheet, held at its middle."""

LAMINATE = """\
name = "strip"
model = "laminate"

[outline]
kind = "rectangle"
width = "40 mm"
height = "20 mm"

[[pattern]]
kind = "bar"
start = ["-10 mm", "0 mm"]
end = ["10 mm", "0 mm"]
half_width = "3 mm"

[[layers]]
name = "film"
role = "active"
thickness = "0.3 mm"
young_modulus = "0.9 MPa"

[[layers]]
name = "PLA"
role = "inert"
thickness = "1.0 mm"
young_modulus = "2.7 MPa"
where = "pattern"

[actuation]
eps_pre = -0.3

[[supports]]
kind = "box"
x = ["-5 mm", "5 mm"]
y = ["-5 mm", "5 mm"]

[mesh]
size = "2 mm"
"""
