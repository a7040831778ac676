"""Draw the pictures of docs/fabrication.md from files that `fabricate` writes.

Run it in the project's environment: .venv/bin/python docs/make_fabrication_pictures.py
"""

from __future__ import annotations

import io
import tempfile
from pathlib import Path

import sheetmorph as sm
from sheetmorph.core.files import write_bytes
from sheetmorph.fabricate.options import FabricationOptions
from sheetmorph.fabricate.package import fabricate_design

DOCS = Path(__file__).resolve().parent
GAP = 16
"""Space between two pages [px]."""
EDGE = (150, 156, 162)
COLOURS = 128

DESIGN = """
name = "two faces"

[outline]
kind = "rectangle"
width = "120 mm"
height = "80 mm"
corner_radius = "6 mm"
unit = "mm"
slits = [[[-60, 0], [-40, 0]]]

[[outline.cutouts]]
kind = "disc"
radius = "6 mm"
centre = ["40 mm", "20 mm"]

[[pattern]]
kind = "star"
part = "ribs"
arms = 5
arm_length = "36 mm"
half_width = "4 mm"
fillet = "4 mm"
rotation = "90 deg"

[[pattern]]
kind = "rectangle"
part = "pad"
width = "24 mm"
height = "10 mm"
centre = ["-42 mm", "-29 mm"]

[[layers]]
name = "pad"
role = "inert"
thickness = "0.6 mm"
young_modulus = "2.6733 MPa"
density = "1250 kg/m^3"
where = "pad"

[[layers]]
name = "polystyrene"
role = "active"
thickness = "0.3 mm"
young_modulus = "0.8911 MPa"
density = "1050 kg/m^3"

[[layers]]
name = "ribs"
role = "inert"
thickness = "0.7 mm"
young_modulus = "2.6733 MPa"
density = "1250 kg/m^3"
where = "ribs"

[actuation]
eps_pre = -0.4

[mesh]
size = "3 mm"
"""


def main() -> None:
    """Write both pictures."""
    design = sm.Design.from_toml(DESIGN)
    with tempfile.TemporaryDirectory() as folder:
        fabricate_design(design, folder, options=FabricationOptions(kerf=0.15e-3, papers=("a4",)))
        sheet, template = (Path(folder) / name for name in ("assembly.pdf", "template-a4.pdf"))
        _draw("fabrication-assembly.png", [(sheet, 0)], 1.15)
        _draw("fabrication-template.png", [(template, 0), (template, 1)], 0.72)


def _draw(name: str, pages: list[tuple[Path, int]], scale: float) -> None:
    """Pages of PDF files side by side, each with a thin edge, as a PNG of few colours."""
    import pypdfium2
    from PIL import Image, ImageOps

    drawn = []
    for file, number in pages:
        document = pypdfium2.PdfDocument(file)
        page = document[number].render(scale=scale).to_pil().convert("RGB")
        document.close()
        drawn.append(ImageOps.expand(page, border=1, fill=EDGE))
    width = sum(page.width for page in drawn) + GAP * (len(drawn) - 1)
    picture = Image.new("RGB", (width, max(page.height for page in drawn)), "white")
    left = 0
    for page in drawn:
        picture.paste(page, (left, 0))
        left += page.width + GAP
    stream = io.BytesIO()
    picture.quantize(COLOURS, dither=Image.Dither.NONE).save(stream, "PNG", optimize=True)
    write_bytes(DOCS / "pictures" / name, stream.getvalue())


if __name__ == "__main__":
    main()
