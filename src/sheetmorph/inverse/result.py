"""What a search for a design found."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

from sheetmorph.compare.surface import Surface
from sheetmorph.design.spec import Design
from sheetmorph.geometry.surface import aspect_ratio, in_plane_width
from sheetmorph.inverse.limits import Limits, Made
from sheetmorph.inverse.misfit import Laid, shape_of
from sheetmorph.inverse.targets import Target
from sheetmorph.study.result import Result


@dataclass(frozen=True)
class Step:
    """A better design than all before.

    Attributes:
        count: designs that had been measured.
        misfit: without unit.
        family: name of the family, or of the stage.
    """

    count: int
    misfit: float
    family: str


@dataclass(frozen=True, eq=False)
class Found:
    """The design whose shape comes closest to a target, and how it was found.

    Attributes:
        target: what was wanted.
        family: of the design.
        values: of its parameters: lengths of sheets in metres, those of patterns as shares of
            the half width.
        design: the design.
        result: its run.
        laid: the target laid on its shape.
        made: how it stands to the limits; None for a sheet without a pattern.
        limits: of fabrication.
        steps: how the best became better.
        evaluations: designs that were measured.
        fresh: of them by this call.
        failed: of them did not reach their end.
        seconds: by this call.
        files: files that the design names, by their names.
        others: other designs that were found on the way, by what they are.
        notes: sentences for the user.
    """

    target: Target
    family: str
    values: Mapping[str, float]
    design: Design
    result: Result
    laid: Laid
    made: Made | None
    limits: Limits
    steps: tuple[Step, ...]
    evaluations: int
    fresh: int
    failed: int
    seconds: float
    files: Mapping[str, bytes] = field(default_factory=dict)
    others: Mapping[str, Found] = field(default_factory=dict)
    notes: tuple[str, ...] = ()

    @property
    def distance(self) -> float:
        """Root mean square distance both ways over the size of the target."""
        return self.laid.distance

    @property
    def distance_m(self) -> float:
        """The same in the size of the sheet [m]."""
        return self.laid.distance * self.laid.target.size

    @cached_property
    def shape(self) -> Surface:
        """The shape of the design [m]."""
        return shape_of(self.result)

    @property
    def scale(self) -> float:
        """By how much the target was scaled; 1 where its size was wanted."""
        return self.laid.pose.scale

    def to_json(self) -> dict[str, Any]:
        """Plain data, lengths in metres."""
        wanted, got = _extents(self.laid.target), _extents(self.shape)
        return {
            "format": "sheetmorph inverse design",
            "target": self.target.text,
            "family": self.family,
            "status": self.result.status,
            "stable": bool(self.result.summary.get("stable", False)),
            "values": dict(self.values),
            "distance_percent": 100.0 * self.distance,
            "distance_m": self.distance_m,
            "size_m": self.laid.target.size,
            "target_scale": self.scale,
            "wanted": wanted,
            "found": got,
            "limits": {
                "minimum_width_m": self.limits.minimum_width,
                "connected": self.limits.connected,
                "most_inert": self.limits.most_inert,
                "symmetry": self.limits.symmetry,
            },
            "pattern": None
            if self.made is None
            else {
                "pieces": self.made.pieces,
                "inert_share": self.made.inert,
                "symmetry": self.made.symmetry,
                "limits_met": not self.made.broken,
                "limits_missed": list(self.made.broken),
            },
            "pose": self.laid.pose.to_json(),
            "evaluations": self.evaluations,
            "computed": self.fresh,
            "failed": self.failed,
            "seconds": self.seconds,
            "steps": [[one.count, one.misfit, one.family] for one in self.steps],
            "others": {name: one.to_json() for name, one in self.others.items()},
            "notes": list(self.notes),
        }


def _extents(surface: Surface) -> dict[str, float]:
    """Sizes of a surface as it lies, with its height along z."""
    points = surface.points[surface.used]
    return {
        "aspect_ratio": float(aspect_ratio(points)),
        "length_m": float(in_plane_width(points)),
        "width_m": float(in_plane_width(points, "feret_min")),
        "height_m": float(points[:, 2].max() - points[:, 2].min()),
        "area_m2": surface.area,
    }
