from __future__ import annotations

import io

import ezdxf
import pytest

from sheetmorph.drawing.read import read_drawing

SPACES = 'xmlns="http://www.w3.org/2000/svg" xmlns:xlink="http://www.w3.org/1999/xlink"'
SVG = "<svg " + SPACES + " {}>{}</svg>"
MM = 'width="100mm" height="80mm" viewBox="0 0 100 80"'


@pytest.fixture
def svg(tmp_path):
    """Read an SVG from its body, on a page of 100 mm × 80 mm unless told."""

    def read(body, page=MM, **options):
        path = tmp_path / "drawing.svg"
        path.write_text(SVG.format(page, body), encoding="utf-8")
        return read_drawing(path, **options)

    return read


@pytest.fixture
def dxf(tmp_path):
    """Read a DXF that a function draws into the model space, in mm unless told."""

    def read(draw, units=4, **options):
        document = ezdxf.new("R2010")
        document.header["$INSUNITS"] = units
        draw(document.modelspace())
        stream = io.StringIO()
        document.write(stream)
        path = tmp_path / "drawing.dxf"
        path.write_text(stream.getvalue(), encoding="utf-8")
        return read_drawing(path, **options)

    return read
