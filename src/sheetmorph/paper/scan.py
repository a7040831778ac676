"""Fig. 8E: the similarity of the computed shapes to the scans that are there."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from sheetmorph.paper.rows import (
    Bare,
    Findings,
    MapFigure,
    Row,
    ShapeFigure,
    Table,
    at_least,
    claims,
    judged,
    near,
)
from sheetmorph.paper.runs import ACTUATIONS, LETTERS, Outcomes, Run, Setting
from sheetmorph.paper.sections import WITHOUT_MESHES, Section, result_of
from sheetmorph.paper.shapes import stage, stages

if TYPE_CHECKING:
    from sheetmorph.compare.comparison import Comparison
    from sheetmorph.study.result import Result

WHERE = "Fig. 8E, Structural Similarity Index Measure"
STATED = 0.8
"""Mean SSIM of all nine stages: "around 0.8"."""

PRINTED_GRID = 10
"""N_s of the text; the released numbers are of 64 voxels a side."""

_AROUND = near(0.1, 0.2)


def _runs(setting: Setting) -> tuple[Run, ...]:
    del setting
    return stages("petals")


def _evaluate(setting: Setting, outcomes: Outcomes) -> Findings:
    rows: list[Row] = []
    last = stage("petals", ACTUATIONS["petals"][-1])
    lack = "There is no scan of this stage."
    compared: Comparison | None = None
    if setting.scan is None:
        lack = "There is no scan here (name it with --scan)."
    elif outcomes[last].failure:
        lack = outcomes[last].failure
    else:
        compared = _compare(result_of(outcomes[last]), setting)
    told: dict[str, Any] = {} if compared is None else compared.to_json()
    found = told.get("ssim")
    rows.append(
        judged(
            "scan-petals--0.50",
            "C at −0.50: mean SSIM to the scan, 64 voxels a side",
            WHERE,
            STATED,
            found,
            _AROUND,
            lack=lack,
            note="The paper says “around 0.8” of all nine stages.",
        )
    )
    if compared is not None:
        rows += _more_rows(compared, told)
    for design, letter in LETTERS.items():
        for eps_pre in ACTUATIONS[design]:
            if design == "petals" and eps_pre == ACTUATIONS["petals"][-1]:
                continue
            rows.append(
                judged(
                    f"scan-{design}-{eps_pre:.2f}",
                    f"{letter} at {eps_pre:.2f}: mean SSIM to the scan".replace("-", "−"),
                    WHERE,
                    STATED,
                    None,
                    _AROUND,
                    lack="The scan of this stage was not released.",
                )
            )
    if compared is None:
        return Findings(rows, notes=() if setting.reference else (WITHOUT_MESHES,))
    figures = _figures(compared, last)
    notes = [f"Scan: {note}" for note in compared.notes]
    if not setting.reference:
        notes.append(WITHOUT_MESHES)
    return Findings(rows, figures, [_table(compared, told)], notes)


def _compare(result: Result, setting: Setting) -> Comparison:
    from sheetmorph.compare.comparison import compare_surfaces
    from sheetmorph.compare.scan import read_surface
    from sheetmorph.compare.surface import Surface

    assert setting.scan is not None  # noqa: S101  the caller looked
    triangles = result.mesh.triangles.astype(np.int64)
    return compare_surfaces(
        Surface(result.positions[-1], triangles),
        read_surface(setting.scan),
        flat=Surface(result.mesh.nodes, triangles),
    )


def _more_rows(compared: Comparison, told: dict[str, Any]) -> list[Row]:
    similar = float(compared.similarity.value)
    baselines = _baselines(told)
    best = max(baselines.values(), default=0.0)
    coarse = [one for one in compared.others if one.grid == PRINTED_GRID]
    return [
        judged(
            "scan-aspect",
            "C: h/d of the scanned sample",
            "Fig. 8D",
            1.2,
            compared.aspect_ratio.scan,
            at_least(0.1),
            note="Of the scan as it lies on the shape, whose h/d is "
            f"{compared.aspect_ratio.shape:.3f}; d is the largest caliper width.",
        ),
        judged(
            "scan-grid-10",
            "C at −0.50: mean SSIM to the scan, N_s = 10 as printed",
            WHERE,
            STATED,
            min((one.value for one in coarse), default=None),
            _AROUND,
            note="The text gives no window; of those tried the lowest value counts: "
            + ", ".join(f"window {one.window}: {one.value:.3f}" for one in coarse)
            + ".",
        ),
        judged(
            "scan-baselines",
            "C at −0.50: closer to the scan than shapes that know nothing of the design",
            WHERE,
            "close agreement",
            f"SSIM {similar:.3f}; "
            + ", ".join(f"{name.replace('_', ' ')} {s:.3f}" for name, s in baselines.items()),
            claims(
                *(
                    (f"above the {name.replace('_', ' ')}", similar > s)
                    for name, s in baselines.items()
                ),
                ("by at least 0.1", similar >= best + 0.1),
            ),
        ),
    ]


def _baselines(told: dict[str, Any]) -> dict[str, float]:
    """SSIM of the baselines, by name."""
    return {str(name): float(value) for name, value in told.get("ssim_baselines", {}).items()}


def _figures(compared: Comparison, last: Run) -> list[MapFigure | ShapeFigure]:
    scan = compared.scan
    field = compared.similarity.field
    return [
        ShapeFigure(
            "scan",
            "The petals at −0.50 as computed, and the scan, turned and scaled onto the shape.",
            (("computed", last), ("scan", Bare(scan.points, scan.triangles.astype(np.int32)))),
            ("shape", "top"),
        ),
        MapFigure(
            "ssim",
            "SSIM seen from above (Fig. 8C): its mean and its least along z.",
            (("mean along z", field.mean(axis=2)), ("least along z", field.min(axis=2))),
            (0.0, 1.0),
            "SSIM",
        ),
    ]


def _table(compared: Comparison, told: dict[str, Any]) -> Table:
    rms, largest = told.get("rms_mm", {}), told.get("hausdorff_mm", {})
    pairs = [
        ("mean SSIM, 64 voxels a side, window 10", f"{compared.similarity.value:.3f}"),
        *(
            (f"mean SSIM, {one.grid} voxels a side, window {one.window}", f"{one.value:.3f}")
            for one in compared.others
        ),
        *(
            (f"mean SSIM of the {k.replace('_', ' ')}", f"{v:.3f}")
            for k, v in _baselines(told).items()
        ),
        ("RMS distance scan → shape, shape → scan [mm]", _pair(rms)),
        ("largest distance scan → shape, shape → scan [mm]", _pair(largest)),
        ("scale found", f"{compared.alignment.pose.scale:.4f}"),
        ("face of the scan", str(compared.face)),
    ]
    return Table("Petals against their scan", ("what", "value"), tuple(pairs))


def _pair(values: dict[str, float]) -> str:
    return f"{values.get('scan_to_shape', np.nan):.2f}, {values.get('shape_to_scan', np.nan):.2f}"


SCAN = Section("scan", "Similarity to the scan", "Fig. 8E", _runs, _evaluate)
