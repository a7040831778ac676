"""The content of a design as plain data in SI units, and its hash."""

from __future__ import annotations

import hashlib
import json
from typing import TYPE_CHECKING, Any

from sheetmorph.design.drawn import Drawing

if TYPE_CHECKING:
    from sheetmorph.design.fields import Section
    from sheetmorph.design.spec import Design

_NOT_HASHED: dict[str, Any] = {
    "name": True,
    "outputs": True,
    # Limits: a run that met one goes on when it is raised.
    "solver": {"max_steps": True, "time_limit": True},
}
_LATER: dict[str, tuple[str, ...]] = {
    "": ("laminate", "loads", "gravity", "contact"),
    "layers": ("eigenstrain_factor",),
    "actuation": ("under_pattern", "transverse", "direction", "centre", "radial_profile", "field"),
    "supports": ("hold", "z", "clamp"),
    "mesh": ("curved", "pattern_smoothing"),
    "solver": ("kind", "dynamic"),
}
"""Keys that came after the first release, by table: with their default they leave no trace, so
that the hashes of designs without them stay what they were."""


def content_hash(design: Design) -> str:
    """SHA-256 of the content, see `Design.hash`.

    Raises:
        InputError: a file that the design names is not there.
    """
    spec = design.spec
    content: dict[str, Any] = spec.model_dump(mode="json", exclude=_NOT_HASHED)
    mesh = design.resolve_mesh_path()
    for name in ("file", "reference_file"):
        del content["mesh"][name]
    if mesh is not None:
        content["mesh"]["sha256"] = hashlib.sha256(mesh.read_bytes()).hexdigest()
    tables = [content["outline"], *content["pattern"]]
    for shape, table in zip([design.outline, *design.pattern], tables, strict=True):
        if isinstance(shape, Drawing):
            table["sha256"] = hashlib.sha256(shape.wkb()).hexdigest()
            del table["file"]
    actuation = content["actuation"]
    if spec.actuation.temperature is None:
        del actuation["shrink_curve"]
    elif spec.actuation.shrink_curve != "polystyrene":
        actuation["shrink_curve"] = _digest(design, "shrink_curve")
    if spec.actuation.radial_profile is not None:
        actuation["radial_profile"] = _digest(design, "radial_profile")
    if spec.actuation.field is not None:
        actuation["field"] = _digest(design, "field")
    _drop_later(spec, content)
    text = json.dumps(content, sort_keys=True, separators=(",", ":"), allow_nan=False)
    return hashlib.sha256(text.encode()).hexdigest()


def _digest(design: Design, key: str) -> str:
    """SHA-256 of a file that the table `actuation` names."""
    path = design.resolve_file(getattr(design.actuation, key), f"actuation.{key}")
    return hashlib.sha256(path.read_bytes()).hexdigest()


def _drop_later(spec: Section, content: dict[str, Any]) -> None:
    """Take keys of `_LATER` that have their default out of the content, in place."""
    for name, keys in _LATER.items():
        table = getattr(spec, name) if name else spec
        rows = content[name] if name else content
        pairs = zip(table, rows, strict=True) if isinstance(table, tuple) else [(table, rows)]
        for section, row in pairs:
            for key in keys:
                field = type(section).model_fields.get(key)
                if field is not None and getattr(section, key) == field.default:
                    del row[key]
