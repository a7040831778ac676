"""Scans laid on a computed shape: the comparison that is told, and the target of a fit."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from dataclasses import asdict, dataclass, field

import numpy as np

from sheetmorph.calibrate.curves import Curve
from sheetmorph.calibrate.misfit import CurveTarget, ScanTarget, Target, shape_of
from sheetmorph.compare.comparison import CompareOptions, Comparison, compare_surfaces
from sheetmorph.compare.scan import Scan
from sheetmorph.compare.surface import Surface
from sheetmorph.core.events import Event, Listener, Notice
from sheetmorph.study.result import Result

Comparisons = tuple[Comparison, ...]


@dataclass(frozen=True, eq=False)
class MeasuredScan:
    """A scan, and how it is to be compared.

    Attributes:
        scan: as it was read.
        options: of the comparison.
    """

    scan: Scan
    options: CompareOptions = field(default_factory=CompareOptions)

    @property
    def fingerprint(self) -> str:
        """A hash of points, triangles and options."""
        digest = hashlib.sha256(repr(sorted(asdict(self.options).items())).encode())
        digest.update(self.scan.name.encode())
        digest.update(repr(self.scan.unit).encode())
        digest.update(np.ascontiguousarray(self.scan.surface.points).tobytes())
        digest.update(np.ascontiguousarray(self.scan.surface.triangles).tobytes())
        return digest.hexdigest()

    @property
    def fixed_scale(self) -> bool:
        """Whether the size of the scan is known, and held."""
        given = (self.scan.unit, self.options.unit, self.options.scale)
        return any(value is not None for value in given)


def lay(
    result: Result, scans: Sequence[MeasuredScan], samples: int, on_event: Listener
) -> tuple[Comparisons, tuple[ScanTarget, ...]]:
    """Compare scans with the shape of a result, from any pose.

    Args:
        result: its last state is the shape.
        scans: what is compared with it.
        samples: points that stand for a scan in a target at most.
        on_event: told of notices.

    Returns:
        The comparisons, and the targets: the face of each scan that was compared, in the
        scan's unit, with the pose that was found.

    Raises:
        InputError: a scan cannot be compared.
    """
    shape = shape_of(result)
    flat = Surface(result.mesh.nodes, result.mesh.triangles.astype(np.int64))

    def only_notices(event: Event) -> None:
        if isinstance(event, Notice):
            on_event(event)

    comparisons, targets = [], []
    for measured in scans:
        comparison = compare_surfaces(
            shape, measured.scan, flat=flat, options=measured.options, on_event=only_notices
        )
        pose = comparison.alignment.pose
        face = comparison.scan.moved(pose.inverse())
        comparisons.append(comparison)
        targets.append(
            ScanTarget(
                measured.scan.name,
                face.points,
                face.triangles,
                pose,
                measured.fixed_scale,
                most=samples,
            )
        )
    return tuple(comparisons), tuple(targets)


def targets(
    scans: Sequence[ScanTarget], curves: Sequence[Curve], curve_weight: float
) -> tuple[Target, ...]:
    """All targets of a fit, the scans first."""
    return (*scans, *(CurveTarget(curve, curve_weight) for curve in curves))
