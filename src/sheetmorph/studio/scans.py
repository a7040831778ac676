"""A scan dropped on the studio: laid over the shape once, measured against every later one."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from sheetmorph.compare.comparison import CompareOptions, compare_surfaces
from sheetmorph.compare.reduce import reduced
from sheetmorph.compare.scan import read_surface
from sheetmorph.compare.surface import Surface
from sheetmorph.core.files import replacing

if TYPE_CHECKING:
    from sheetmorph.studio.worker import Desk
    from sheetmorph.study.result import Result

MAX_SHOWN = 30_000
"""Triangles of a scan that the browser draws."""
LAID = "laid-scan.npz"
"""The scan in the frame of the shape, in the tab's folder; plain arrays."""
ROBUST = 98.0


def compare_scan(job: dict[str, Any], desk: Desk, memory: Any) -> None:
    """Solve the design, lay the scan over its shape, and tell all numbers."""
    from sheetmorph.studio.tasks import designed
    from sheetmorph.study.simulate import simulate

    design = designed(job)
    path = Path(job["path"])
    scan = read_surface(path)
    result = simulate(design, mesh=memory.mesh(design), on_event=desk.listen)
    options = CompareOptions(unit=job.get("unit"), mirror=bool(job.get("mirror")))
    triangles = result.mesh.triangles.astype(np.int64)
    found = compare_surfaces(
        Surface(result.positions[-1], triangles),
        scan,
        flat=Surface(result.mesh.nodes, triangles),
        options=options,
        on_event=desk.listen,
    )
    laid, _ = reduced(found.scan, MAX_SHOWN)
    with replacing(path.parent / LAID) as partial, partial.open("wb") as stream:
        np.savez(stream, allow_pickle=False, points=laid.points, triangles=laid.triangles)
    numbers = found.to_json()
    told = {key: numbers[key] for key in _TOLD}
    told["ssim_flat"] = found.baselines["flat_sheet"].ssim
    desk.answer("scan", {"numbers": told, "notes": [*scan.notes, *found.notes]})


_TOLD = (
    *("ssim", "rms_mm", "p95_mm", "hausdorff_mm", "aspect_ratio", "scale_m_per_unit"),
    *("scale_known", "mirrored", "confidence", "size_mm"),
)


def measured(result: Result, folder: Path) -> tuple[dict[str, Any], dict[str, Any]] | None:
    """Distances between a result and the scan that lies over it; None where there is no scan.

    Returns:
        The field of the distance as the browser is told of it, and the arrays: `field.scan` at
        the nodes, `scan.points`, `scan.triangles` and `scan.distance`, all in mm.
    """
    file = folder / LAID
    if not file.is_file():
        return None
    with np.load(file, allow_pickle=False) as data:
        scan = Surface(data["points"], data["triangles"])
    shape = Surface(result.positions[-1], result.mesh.triangles.astype(np.int64))
    at_nodes = 1e3 * scan.nearest(result.positions[-1]).distance
    at_scan = 1e3 * shape.nearest(scan.points).distance
    top = max(float(np.percentile(np.concatenate([at_nodes, at_scan]), ROBUST)), 0.01)
    told = {"label": "Distance to scan", "unit": "mm", "low": 0.0, "high": top, "diverging": False}
    arrays = {
        "field.scan": at_nodes,
        "scan.points": 1e3 * scan.points,
        "scan.triangles": scan.triangles,
        "scan.distance": at_scan,
    }
    return told, arrays
