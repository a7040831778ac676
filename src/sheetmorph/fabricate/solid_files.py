"""Bodies as the bytes of 3MF and STL files, in millimetres; the same bodies, the same bytes."""

from __future__ import annotations

import io
import re
import zipfile
from collections.abc import Callable, Mapping, Sequence
from typing import Any
from xml.sax.saxutils import escape, quoteattr

import numpy as np
from numpy.typing import NDArray

from sheetmorph.core.errors import InputError
from sheetmorph.fabricate.print3d import Body

_TYPES = """<?xml version="1.0" encoding="UTF-8"?>
<Types xmlns="http://schemas.openxmlformats.org/package/2006/content-types">
<Default Extension="rels" ContentType="application/vnd.openxmlformats-package.relationships+xml"/>
<Default Extension="model" ContentType="application/vnd.ms-package.3dmanufacturing-3dmodel+xml"/>
</Types>
"""
_RELATIONS = """<?xml version="1.0" encoding="UTF-8"?>
<Relationships xmlns="http://schemas.openxmlformats.org/package/2006/relationships">
<Relationship Target="/3D/3dmodel.model" Id="model"
 Type="http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"/>
</Relationships>
"""
_NOT_XML = re.compile("[^\t\n\r -\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")
_CORE = "http://schemas.microsoft.com/3dmanufacturing/core/2015/02"


def bytes_3mf(bodies: Sequence[Body], metadata: Mapping[str, str]) -> bytes:
    """A 3MF package: one object for each body, all placed, unit millimetre.

    Args:
        bodies: what to print, in its place on the bed.
        metadata: well-known names of the 3MF core specification, such as Title, Designer,
            Description, Application; and their text.

    Raises:
        InputError: there is nothing to write.
    """
    if not bodies:
        raise InputError("there is no part to write")
    model = [
        '<?xml version="1.0" encoding="UTF-8"?>',
        f'<model unit="millimeter" xml:lang="en-US" xmlns="{_CORE}">',
        *(
            f"<metadata name={quoteattr(name)}>{escape(_printable(text))}</metadata>"
            for name, text in metadata.items()
        ),
        "<resources>",
    ]
    for number, body in enumerate(bodies, 1):
        model.append(
            f'<object id="{number}" type="model" name={quoteattr(_printable(body.name))}><mesh>'
        )
        model += ["<vertices>", *_rows("vertex", "xyz", 1e3 * body.points, _number), "</vertices>"]
        corners = ("v1", "v2", "v3")
        model += ["<triangles>", *_rows("triangle", corners, body.triangles, str), "</triangles>"]
        model.append("</mesh></object>")
    model.append("</resources><build>")
    model += [f'<item objectid="{number}"/>' for number in range(1, len(bodies) + 1)]
    model.append("</build></model>\n")
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w") as package:
        for name, text in (
            ("[Content_Types].xml", _TYPES),
            ("_rels/.rels", _RELATIONS),
            ("3D/3dmodel.model", "\n".join(model)),
        ):
            # A fixed date, system and level: the bytes depend on the bodies alone.
            entry = zipfile.ZipInfo(name, (1980, 1, 1, 0, 0, 0))
            entry.create_system = 0
            entry.compress_type = zipfile.ZIP_DEFLATED
            package.writestr(entry, text.encode("utf-8"), compresslevel=6)
    return buffer.getvalue()


def bytes_stl(bodies: Sequence[Body]) -> bytes:
    """A binary STL file of all bodies, in millimetres.

    Raises:
        InputError: there is nothing to write.
    """
    if not bodies:
        raise InputError("there is no part to write")
    corners = np.concatenate([1e3 * body.points[body.triangles] for body in bodies])
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    lengths = np.linalg.norm(normals, axis=1, keepdims=True)
    normals = np.divide(normals, lengths, out=np.zeros_like(normals), where=lengths > 0.0)
    record = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
    data = np.zeros(len(corners), record)
    data["normal"] = normals + 0.0
    data["corners"] = corners + 0.0
    # A binary file must not begin with "solid", the mark of the text format.
    header = b"sheetmorph, millimetres".ljust(80, b"\0")
    return b"".join([header, len(corners).to_bytes(4, "little"), data.tobytes()])


def _rows(
    tag: str, keys: Sequence[str], table: NDArray[Any], text: Callable[[Any], str]
) -> list[str]:
    pattern = f"<{tag} " + " ".join(f'{key}="%s"' for key in keys) + "/>"
    return [pattern % tuple(text(value) for value in row) for row in table.tolist()]


def _printable(text: str) -> str:
    """Text without the characters that XML cannot carry."""
    return _NOT_XML.sub("\ufffd", text)


def _number(value: float) -> str:
    # Seven decimals of a millimetre, and never "-0".
    return f"{value:.7f}".rstrip("0").rstrip(".") if abs(value) >= 5e-8 else "0"
