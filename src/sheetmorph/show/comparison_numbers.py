"""The numbers of a comparison as text with units, each with what it means."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from sheetmorph.show.numbers import Banner, Row

if TYPE_CHECKING:
    from sheetmorph.compare.comparison import Comparison
    from sheetmorph.show.comparison_views import Names

CERTAIN = 0.05
"""Confidence from which the pose is told as certain: any other fits worse by a twentieth."""


UNLIKE = 0.08
"""Misfit, as a share of the size of the shape, above which two surfaces are told as unlike."""


@dataclass(frozen=True)
class Told:
    """A number and what it means."""

    label: str
    value: str
    meaning: str


def lead_of(names: Names, data: Mapping[str, Any]) -> str:
    """One sentence on what was compared."""
    faces = {"outer": "its outer face", "inner": "its inner face", "both": "both its faces"}
    found = faces.get(str(data.get("face")))
    face = f", {found}" if found else ""
    return (
        f"The shape {names.shape} against the scan {names.scan}{face}. The scan was moved and "
        "turned" + (", and scaled," if not data.get("scale_known") else "") + " until it fitted."
    )


def banner_of(comparison: Comparison) -> Banner:
    """Whether the pose can be trusted."""
    alignment = comparison.alignment
    lines = []
    if alignment.rms > UNLIKE * comparison.shape.size:
        share = 100 * alignment.rms / comparison.shape.size
        wrong = f"The misfit is {share:.0f} % of the size of the shape."
        advice = "Check that it is a scan of this sheet, without stand and floor (--crop)."
        return Banner(False, "Scan and shape are unlike", [wrong, advice])
    if alignment.equivalent_poses:
        lines.append(
            f"The shape looks alike in {len(alignment.equivalent_poses) + 1} poses; the one that "
            "fits best is shown."
        )
    if alignment.next_rms is None:
        return Banner(True, "The pose is certain", lines or ["No other pose was found."])
    other = (
        f"Misfit {millimetres(alignment.rms)}; the best pose that is really different has "
        f"{millimetres(alignment.next_rms)} (confidence {alignment.confidence:.2f})."
    )
    if alignment.confidence >= CERTAIN:
        return Banner(True, "The pose is certain", [other, *lines])
    advice = (
        "Where the sheet is nearly symmetric that is to be expected, and the numbers of both "
        "poses are alike; else look at the overlay, and give the size of the scan (--unit, "
        "--known-length)."
    )
    return Banner(False, "Another pose fits nearly as well", [other, *lines, advice])


def facts_of(comparison: Comparison, data: Mapping[str, Any]) -> list[Row]:
    """The few numbers that are shown large."""
    worst = max(comparison.scan_to_shape.maximum, comparison.shape_to_scan.maximum)
    plain = [f"{name.replace('_', ' ')} {x:.2f}" for name, x in baselines_of(data).items()]
    beside = f" ({', '.join(plain)})" if plain else ""
    return [
        Row(f"structural similarity, SSIM{beside}", f"{comparison.similarity.value:.3f}"),
        Row("RMS distance, scan to shape", millimetres(comparison.scan_to_shape.rms)),
        Row("RMS distance, shape to scan", millimetres(comparison.shape_to_scan.rms)),
        Row("farthest point", millimetres(worst)),
        Row("one unit of the scan", length_of_unit(data)),
    ]


def told_of(comparison: Comparison, data: Mapping[str, Any]) -> dict[str, list[Told]]:
    """All numbers by group; what the comparison lacks is left out."""
    return {
        "Similarity": _similarity(comparison, data),
        "Distances": _distances(comparison),
        "Form": _form(data),
        "Pose": _pose(comparison, data),
    }


def _similarity(comparison: Comparison, data: Mapping[str, Any]) -> list[Told]:
    found = comparison.similarity
    rows = [
        Told(
            f"SSIM, grid {found.grid}, window {found.window}",
            f"{found.value:.3f}",
            "1 when both are the same. It is a mean over the whole box, most of which is empty, "
            "so that even a flat sheet does not reach 0: read it beside the lines below.",
        )
    ]
    meanings = {
        "flat_sheet": "What the sheet would have got had it stayed flat.",
        "spherical_cap": "What the best-fitting part of a sphere gets: a shape that knows "
        "nothing but size and height.",
    }
    for name, value in baselines_of(data).items():
        words = name.replace("_", " ")
        rows.append(Told(f"SSIM of a {words}", f"{value:.3f}", meanings.get(name, "")))
    rows += [
        Told(
            f"SSIM, grid {other.grid}, window {other.window}",
            f"{other.value:.3f}",
            "The same by another grid and window: SSIM is comparable only where these agree.",
        )
        for other in comparison.others
    ]
    return rows


def _distances(comparison: Comparison) -> list[Told]:
    rows = []
    for name, way, meaning in (
        ("scan to shape", comparison.scan_to_shape, "from a point of the scan to the shape"),
        ("shape to scan", comparison.shape_to_scan, "from a point of the shape to the scan"),
    ):
        rows += [
            Told(
                f"RMS, {name}",
                _with_share(way.rms, comparison.shape.size),
                f"Root mean square of the distance {meaning}; % of the shape’s diagonal.",
            ),
            Told(f"Mean, {name}", millimetres(way.mean), f"Mean distance {meaning}."),
            Told(
                f"95 %, {name}",
                millimetres(way.percentile_95),
                "95 % of the area lie nearer than this.",
            ),
            Told(
                f"Farthest, {name}",
                _with_share(way.maximum, comparison.shape.size),
                "Hausdorff distance in this direction: a single spike of a scan decides it.",
            ),
        ]
    return rows


def _form(data: Mapping[str, Any]) -> list[Told]:
    rows = []
    ratios = data.get("aspect_ratio")
    if isinstance(ratios, Mapping) and {"scan", "shape"} <= set(ratios):
        rows.append(
            Told(
                "Height over width, scan and shape",
                f"{ratios['scan']:.3f}, {ratios['shape']:.3f}",
                "h/d of both in the frame of the shape: how far the sheet has morphed.",
            )
        )
    angles = data.get("normal_deviation_deg")
    if isinstance(angles, Mapping):
        rows += [
            Told(
                f"Angle between the surfaces, {_way(way)}",
                f"{value['mean']:.1f}°",
                "Mean angle between the tangent planes at nearest points.",
            )
            for way, value in angles.items()
        ]
    bends = data.get("curvature_deviation_per_m")
    if isinstance(bends, Mapping):
        length = float(data["curvature_averaged_over_mm"])
        rows += [
            Told(
                f"Difference of curvature, {_way(way)}",
                f"{value:.3g} /m",
                f"RMS difference of the mean curvatures, averaged over {length:.1f} mm.",
            )
            for way, value in bends.items()
        ]
    return rows


def _pose(comparison: Comparison, data: Mapping[str, Any]) -> list[Told]:
    alignment = comparison.alignment
    matrix = rows_of(data["rotation"])
    shift = ", ".join(f"{1e3 * float(value):.2f}" for value in data["translation_m"])
    return [
        Told(
            "Scale",
            f"{float(data['scale']):.6g}",
            "Metres in the shape per unit of the scan, "
            + ("as was given." if data.get("scale_known") else "found by the fit."),
        ),
        Told("Rotation", matrix, "Rows of the matrix that turns the scan."),
        Told("Shift", f"{shift} mm", "Added after scaling and turning."),
        Told(
            "Confidence",
            f"{alignment.confidence:.2f}",
            "1 − misfit / misfit of the best pose that is really different: 0 is a toss-up, "
            "1 says that no other was found.",
        ),
        Told("Time", f"{comparison.seconds:.1f} s", "For the comparison, without pictures."),
    ]


def _way(name: str) -> str:
    return name.replace("_", " ")


def baselines_of(data: Mapping[str, Any]) -> dict[str, float]:
    """SSIM of the plain shapes that the number is to be read beside, by name."""
    found = data.get("ssim_baselines") or {}
    return {
        str(name): float(value["ssim"] if isinstance(value, Mapping) else value)
        for name, value in found.items()
    }


def rows_of(rotation: Sequence[Sequence[float]]) -> str:
    """A matrix as text, row by row."""
    rows = ["  ".join(f"{value:+.3f}" for value in row) for row in rotation]
    return " / ".join(rows).replace("-", "−")


def length_of_unit(data: Mapping[str, Any]) -> str:
    """The length of one unit of the scan's file."""
    return f"{1e3 * float(data.get('scale_m_per_unit', data['scale'])):.4g} mm"


def millimetres(length: float) -> str:
    """A length [m] in mm with three digits, for a page of numbers."""
    value = 1e3 * length
    if value >= 100:
        return f"{value:.0f} mm"
    return f"{value:.1f} mm" if value >= 10 else f"{value:.2f} mm"


def _with_share(length: float, size: float) -> str:
    return f"{millimetres(length)} ({100 * length / size:.1f} %)"
