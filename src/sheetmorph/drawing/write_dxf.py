"""Writing DXF: one layer per ink, in millimetres."""

from __future__ import annotations

import io
import threading
from collections.abc import Iterator, Sequence
from contextlib import contextmanager

from sheetmorph.core.errors import InputError
from sheetmorph.drawing.colours import colour_hex
from sheetmorph.drawing.ink import Ink, check_names

_LOCK = threading.Lock()


def dxf_bytes(inks: Sequence[Ink]) -> bytes:
    """A drawing as DXF R2010 in millimetres, the same bytes for the same inks.

    Every ring is a closed LWPOLYLINE and every line an open one, on the layer of its ink,
    in the layer's colour and as a hairline.

    Raises:
        InputError: two inks have the same name.
    """
    from ezdxf.filemanagement import new

    check_names(inks)
    with _without_time():
        document = new("R2010", setup=False)
        document.header["$INSUNITS"] = 4
        document.header["$MEASUREMENT"] = 1
        space = document.modelspace()
        for ink in inks:
            layer = (
                document.layers.get(ink.name)
                if ink.name in document.layers
                else document.layers.add(ink.name)
            )
            digits = colour_hex(ink.colour) or "#000000"
            layer.rgb = tuple(int(digits[k : k + 2], 16) for k in (1, 3, 5))  # type: ignore[assignment]
            layer.dxf.lineweight = 0
            for curves in ink.outlines:
                for curve in curves:
                    space.add_lwpolyline(
                        (1e3 * curve.points).tolist(),
                        close=curve.closed,
                        dxfattribs={"layer": ink.name, "lineweight": 0},
                    )
        errors = document.audit().errors
        if errors:
            raise InputError(f"the shapes cannot be written as DXF ({errors[0].message[:100]})")
        stream = io.StringIO(newline="\n")
        document.write(stream)
    return stream.getvalue().encode("utf-8")


@contextmanager
def _without_time() -> Iterator[None]:
    """Have the library write fixed dates and identifiers for as long as the block runs."""
    from ezdxf._options import options

    with _LOCK:
        before = options.write_fixed_meta_data_for_testing
        options.write_fixed_meta_data_for_testing = True
        try:
            yield
        finally:
            options.write_fixed_meta_data_for_testing = before
