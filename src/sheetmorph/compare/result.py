"""What a comparison found: every number of it, and the surfaces where they lie."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from sheetmorph.compare.align import Alignment
from sheetmorph.compare.baselines import Baseline
from sheetmorph.compare.distances import OneWay
from sheetmorph.compare.similarity import Ssim
from sheetmorph.compare.surface import Surface


@dataclass(frozen=True)
class AspectRatios:
    """Height over largest width, h/d, with z up in the frame of the shape.

    Attributes:
        shape: of the shape.
        scan: of the scan.
    """

    shape: float
    scan: float

    @property
    def relative_error(self) -> float:
        """The shape's over the scan's, less 1."""
        return self.shape / self.scan - 1.0 if self.scan else float("nan")


@dataclass(frozen=True, eq=False)
class Comparison:
    """A shape and a scan, laid over each other, and all numbers about it.

    Attributes:
        shape: the predicted shape [m].
        scan: the face that was compared, cleaned, in the frame of the shape [m].
        alignment: how the scan got there.
        scan_to_shape: distances from the scan to the shape.
        shape_to_scan: distances from the shape to the scan.
        similarity: structural similarity on the wanted grid.
        others: the same on other grids.
        baselines: "flat_sheet" and "spherical_cap", laid onto the scan and scored the same
            way, on the same grid.
        aspect_ratio: of the shape and of the scan.
        face: which face of the scan was compared: "single", "both", "outer" or "inner".
        thickness: of a scan with two faces [m]; None otherwise.
        unit_length: metres per unit of the scan's file, known or found.
        scale_known: whether it was given.
        notes: sentences for people.
        seconds: time it took.
    """

    shape: Surface
    scan: Surface
    alignment: Alignment
    scan_to_shape: OneWay
    shape_to_scan: OneWay
    similarity: Ssim
    others: tuple[Ssim, ...]
    baselines: dict[str, Baseline]
    aspect_ratio: AspectRatios
    face: str
    thickness: float | None
    unit_length: float
    scale_known: bool
    notes: tuple[str, ...]
    seconds: float

    @property
    def size(self) -> float:
        """Diagonal of the shape's bounding box [m], of which percentages are taken."""
        return self.shape.size

    def to_json(self) -> dict[str, Any]:
        """All numbers, ready for a JSON file: finite, or None where there is none."""
        ways = {"scan_to_shape": self.scan_to_shape, "shape_to_scan": self.shape_to_scan}
        measures = {"rms": "rms", "mean": "mean", "p95": "percentile_95", "hausdorff": "maximum"}
        values: dict[str, Any] = {
            "ssim": self.similarity.value,
            "grid": self.similarity.grid,
            "window": self.similarity.window,
            "ssim_baselines": {name: base.ssim for name, base in self.baselines.items()},
            "ssim_others": [other.to_json() for other in self.others],
            "baselines": {name: base.to_json() for name, base in self.baselines.items()},
        }
        for key, name in measures.items():
            lengths = {way: getattr(one, name) for way, one in ways.items()}
            values[f"{key}_mm"] = {way: 1e3 * length for way, length in lengths.items()}
            values[f"{key}_percent_of_size"] = {
                way: 100.0 * length / self.size for way, length in lengths.items()
            }
        values |= {
            "size_mm": 1e3 * self.size,
            "normal_deviation_deg": {
                way: {"rms": np.degrees(one.normal_rms), "mean": np.degrees(one.normal_mean)}
                for way, one in ways.items()
            },
            "curvature_deviation_per_m": {way: one.curvature_rms for way, one in ways.items()},
            "curvature_deviation_times_size": {
                way: one.curvature_rms * self.size for way, one in ways.items()
            },
            "curvature_averaged_over_mm": 1e3 * self.scan_to_shape.smoothing,
            "aspect_ratio": {
                "shape": self.aspect_ratio.shape,
                "scan": self.aspect_ratio.scan,
                "relative_error": self.aspect_ratio.relative_error,
            },
            **self.alignment.pose.to_json(),
            "scale_m_per_unit": self.unit_length,
            "scale_known": self.scale_known,
            "mirrored": self.alignment.mirrored,
            "misfit_mm": 1e3 * self.alignment.rms,
            "next_misfit_mm": _times(self.alignment.next_rms, 1e3),
            "confidence": self.alignment.confidence,
            "equivalent_poses": [pose.to_json() for pose in self.alignment.equivalent_poses],
            "face": self.face,
            "thickness_mm": _times(self.thickness, 1e3),
            "notes": list(self.notes),
            "seconds": self.seconds,
        }
        plain: dict[str, Any] = _plain(values)
        return plain


def _times(value: float | None, factor: float) -> float | None:
    return None if value is None else factor * value


def _plain(value: Any) -> Any:
    """Python's own numbers and lists; None for numbers that are not finite."""
    if isinstance(value, dict):
        return {key: _plain(part) for key, part in value.items()}
    if isinstance(value, list):
        return [_plain(part) for part in value]
    if isinstance(value, float | np.floating):
        return float(value) if np.isfinite(value) else None
    return value
