"""What a worker of the studio can do: each task takes a job from the server and answers it."""

from __future__ import annotations

import math
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from time import perf_counter
from typing import Any

from sheetmorph.core.errors import InputError
from sheetmorph.design.files import edit_design_text
from sheetmorph.design.spec import Design
from sheetmorph.geometry.mesh import SheetMesh
from sheetmorph.studio.drawings import look_at_drawing, use_drawing
from sheetmorph.studio.exports import export
from sheetmorph.studio.panel import panel
from sheetmorph.studio.plan import plan
from sheetmorph.studio.scans import compare_scan
from sheetmorph.studio.shapes import find_shapes
from sheetmorph.studio.worker import Desk

PREVIEW_NODES = 260
"""About how many nodes a preview has."""
KEPT_MESHES = 4
APPENDED = "pattern.+"
"""Key of a value that is a new shape of the pattern."""


@dataclass
class Memory:
    """What a worker keeps between jobs: meshes, by the part of the design that makes them."""

    meshes: dict[str, SheetMesh] = field(default_factory=dict)

    def clear(self) -> None:
        """Forget all."""
        self.meshes.clear()

    def mesh(self, design: Design) -> SheetMesh:
        """The mesh of a design, built only when its plan or its mesh has changed."""
        key = mesh_key(design)
        found = self.meshes.pop(key, None) or design.build_mesh()
        self.meshes[key] = found
        while len(self.meshes) > KEPT_MESHES:
            del self.meshes[next(iter(self.meshes))]
        return found


def mesh_key(design: Design) -> str:
    """A text that is the same for designs with the same mesh."""
    path = design.resolve_mesh_path()
    stamp = "" if path is None else f"{path}:{path.stat().st_mtime_ns}"
    layout = design.layout
    parts = [layout.sheet.wkb_hex, layout.slits.wkb_hex]
    parts += [f"{name}:{part.wkb_hex}" for name, part in layout.parts.items()]
    table = design.spec.mesh.model_dump_json()
    return "|".join([*parts, table, str(design.spec.published.hinge_orientation), stamp])


def designed(job: dict[str, Any]) -> Design:
    """The design of a job: a text, changed values, and the folder of the files it names."""
    folder = Path(job["folder"]) if job.get("folder") else None
    values = dict(job.get("values") or {})
    shape = values.pop(APPENDED, None)
    text = job["text"] if shape is None else with_shape(job["text"], shape)
    return Design.from_toml(edit_design_text(text, values) if values else text, folder)


def with_shape(text: str, shape: dict[str, Any]) -> str:
    """The text of a design with one more shape in its pattern."""
    import tomlkit

    document: Any = tomlkit.parse(text)
    if "pattern" not in document:
        document["pattern"] = tomlkit.aot()
    table = tomlkit.table()
    table.update(shape)
    document["pattern"].append(table)
    table.add(tomlkit.nl())
    return tomlkit.dumps(document)


def show_design(job: dict[str, Any], desk: Desk, memory: Memory) -> None:
    """Check a design, draw its plan, and solve it: coarsely, fully, or both."""
    began = perf_counter()
    design = designed(job)
    desk.answer(
        "design",
        {
            "text": design.to_toml(),
            "name": design.name,
            "plan": plan(design),
            "panel": panel(design) if job.get("panel", True) else None,
            "notes": list(design.notes),
            "commit": bool(job.get("commit")),
            "direction": design.perturbation.direction,
        },
    )
    scratch = Path(job["scratch"]) if job.get("scratch") else None
    levels = list(job["levels"])
    if "preview" in levels:
        shown, mesh = _preview(design, memory)
        if shown is not design or levels == ["preview"]:
            _solve(shown, mesh, True, desk, began, scratch)
    if "full" in levels:
        desk.check()
        _solve(design, memory.mesh(design), False, desk, began, scratch)


def _solve(
    design: Design,
    mesh: SheetMesh,
    preview: bool,
    desk: Desk,
    began: float,
    scratch: Path | None,
) -> None:
    from sheetmorph.design.check import describe
    from sheetmorph.studio.scans import measured
    from sheetmorph.studio.scene import scene
    from sheetmorph.study.simulate import simulate

    desk.check()
    result = simulate(design, mesh=mesh, on_event=desk.listen)
    head, arrays = scene(result, preview=preview)
    near = None if scratch is None else measured(result, scratch)
    if near is not None:
        head["fields"]["scan"], distances = near
        arrays |= distances
    head["numbers"]["seconds"] = perf_counter() - began
    desk.answer("scene", head, arrays)
    if not preview:
        desk.answer("checked", {"warnings": describe(design, mesh)["warnings"]})


def _preview(design: Design, memory: Memory) -> tuple[Design, SheetMesh]:
    """The design with a coarse mesh, as far as its ribs are wide enough for one."""
    shown = coarse(design)
    if shown is not design:
        with suppress(InputError):
            return shown, memory.mesh(shown)
    return design, memory.mesh(design)


def coarse(design: Design) -> Design:
    """The design with a mesh that is solved in a moment; itself where its mesh is coarse enough."""
    size = design.spec.mesh.size
    if size is None:
        return design
    low_x, low_y, high_x, high_y = design.layout.sheet.bounds
    wanted = math.sqrt(design.layout.sheet.area / PREVIEW_NODES / (math.sqrt(3) / 2))
    wanted = min(wanted, 0.45 * min(high_x - low_x, high_y - low_y))
    if wanted <= 1.15 * size:
        return design
    values: dict[str, object] = {"mesh.size": f"{1e3 * wanted:.4g} mm"}
    if design.spec.mesh.boundary_size is not None:
        share = design.spec.mesh.boundary_size / size
        values["mesh.boundary_size"] = f"{1e3 * wanted * share:.4g} mm"
    return design.with_values(values)


def warm_up() -> None:
    """Load and compile what a first solve needs, so that it is not the slowest."""
    from sheetmorph.design.presets import preset_text

    desk = Desk(0, lambda packet: None, lambda: False)
    job = {"text": preset_text("blank"), "levels": ["preview"]}
    show_design(job, desk, Memory())


TASKS: dict[str, Callable[[dict[str, Any], Desk, Memory], None]] = {
    "design": show_design,
    "look": look_at_drawing,
    "use": use_drawing,
    "compare": compare_scan,
    "export": export,
    "shapes": find_shapes,
}
"""The tasks by their names in jobs."""
