"""Random patterns of polygons, drawn by lines: the generator of the paper as we read it."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Annotated, Literal, Self

import numpy as np
from pydantic import Field, model_validator

from sheetmorph.design.fields import Flag, Number, Quantity, Size, Whole, problem
from sheetmorph.design.kirigami_lines import (
    SNAP,
    far_end,
    grown,
    heart_of,
    is_narrow,
    place,
    shortest_bars,
    shrunk,
    smoothed,
)
from sheetmorph.design.library_tools import tidy
from sheetmorph.design.piece import Piece
from sheetmorph.geometry.mesh import Floats

if TYPE_CHECKING:
    from shapely import Polygon
    from shapely.geometry.base import BaseGeometry

ATTEMPTS = 40
"""Patterns drawn for one seed before the parameters are called impossible."""

SPREAD = 0.6
"""Share of the sheet that the polygons have together, unless their radius is given."""

FINE = 1e-9
"""Contours are rounded to this [m]."""

ROUNDS = 4
"""How often a trial is smoothed until it has no narrow gaps."""

WIDEST = 0.9
"""Greatest minimum feature, in widths of a line: rounding must leave the lines as they are."""

FULL = 0.9
"""A pattern covers less than this fraction of the sheet."""

Coverage = Annotated[Number, Field(ge=0, le=FULL)]


class RandomPolygons(Piece):
    """Random polygons drawn by lines of one width, different for each `seed`.

    A polygon has a random centre and `lines` corners around it. The same parameters on the same
    sheet give the same pattern, on every machine.

    Attributes:
        seed: chooses the pattern.
        polygons: how many.
        lines: how many each polygon has.
        line_width: [m]; their ends are round.
        style: lines from the centre to the corners, the sides of the polygon, or both.
        radius: mean distance from the centre to the corners [m]; by default the polygons have
            together 60 % of the area of the sheet.
        connected: whether what does not touch is joined by bars, along the shortest tree.
        minimum_feature: no rib and no gap is narrower [m]; half of `line_width` by default.
        margin: along the rim, free of lines [m]; `line_width` by default.
        coverage: least and greatest share of the sheet that the pattern covers.
    """

    kind: Literal["random_polygons"]
    seed: Annotated[Whole, Field(ge=0, le=2**63 - 1)]
    polygons: Annotated[Whole, Field(ge=1, le=50)] = 3
    lines: Annotated[Whole, Field(ge=3, le=60)] = 6
    line_width: Size
    style: Literal["spokes", "outline", "both"] = "spokes"
    radius: Size | None = None
    connected: Flag = True
    minimum_feature: Annotated[float, Quantity("length", "0 mm", "1 m")] | None = None
    margin: Annotated[float, Quantity("length", "0 mm", "1 m")] | None = None
    coverage: tuple[Coverage, Coverage] = (0.0, 0.7)

    @model_validator(mode="after")
    def _fits_together(self) -> Self:
        if self.feature > WIDEST * self.line_width * (1 + 1e-9):
            raise problem(
                "leaves nothing of the lines",
                key="minimum_feature",
                value=_mm(self.feature),
                allowed=f"≤ {_mm(WIDEST * self.line_width)}, {WIDEST:g} of line_width",
            )
        if self.rim < self.feature:
            raise problem(
                "is narrower than the smallest gap",
                key="margin",
                value=_mm(self.rim),
                allowed=f"≥ minimum_feature, {_mm(self.feature)}",
            )
        if self.coverage[0] >= self.coverage[1]:
            raise problem("the smaller share comes first", key="coverage", value=self.coverage)
        return self

    @property
    def feature(self) -> float:
        """Width of the narrowest rib and the narrowest gap [m]."""
        return self.line_width / 2 if self.minimum_feature is None else self.minimum_feature

    @property
    def rim(self) -> float:
        """Width of the strip along the rim that stays free [m]."""
        return self.line_width if self.margin is None else self.margin

    def drawn(self, sheet: Polygon) -> BaseGeometry:
        """The pattern [m], within the sheet, of one piece if it is connected.

        Raises:
            PydanticCustomError: the parameters leave no room for a pattern.
        """
        inner = shrunk(sheet, self.rim)
        lanes = shrunk(sheet, self.rim + self.line_width / 2)
        if lanes.is_empty:
            raise problem(
                "leaves no room on the sheet: choose narrower lines or a smaller margin",
                key="line_width",
                value=_mm(self.line_width),
            )
        reach = self.radius or math.sqrt(SPREAD * sheet.area / (math.pi * self.polygons))
        failures: list[str] = []
        for attempt in range(ATTEMPTS):
            random = np.random.Generator(np.random.PCG64([self.seed, attempt]))
            shape, narrow = self._draw(random, lanes, inner, reach)
            failure = self._fault(shape, sheet) or ("narrow" if narrow else "")
            if not failure:
                return shape
            failures.append(failure)
            if self.radius is None:
                reach *= {"full": 0.9, "bare": 1.1}.get(failure, 1.0)
        raise self._refusal(max(failures, key=failures.count))

    def _draw(
        self, random: np.random.Generator, lanes: BaseGeometry, inner: BaseGeometry, reach: float
    ) -> tuple[BaseGeometry, bool]:
        """One trial, and whether it has narrow gaps; what cannot be joined stays apart."""
        import shapely

        heart = heart_of(lanes, reach / 2)
        strokes: list[BaseGeometry] = []
        centres: list[Floats] = []
        for _ in range(self.polygons):
            centres.append(place(random, heart, centres))
            strokes += self._strokes(random, lanes, centres[-1], reach)
        shape = shapely.union_all([grown(stroke, self.line_width / 2) for stroke in strokes])
        if self.connected:
            bars = shortest_bars(shape, strokes, lanes)
            thick = [grown(bar, self.line_width / 2) for bar in bars]
            shape = shapely.union_all([shape, *thick])
        narrow = True
        for _ in range(ROUNDS):
            shape = shapely.intersection(smoothed(shape, self.feature), inner)
            narrow = is_narrow(shape, self.feature)
            if not narrow:
                break
        return tidy(shapely.set_precision(shape, FINE)), narrow

    def _strokes(
        self, random: np.random.Generator, lanes: BaseGeometry, centre: Floats, reach: float
    ) -> list[BaseGeometry]:
        """The middle lines of one polygon."""
        import shapely

        jitter = random.random(self.lines + 1)
        share = 0.7 + 0.5 * random.random(self.lines)
        angles = 2 * math.pi * (np.arange(self.lines) + 0.5 * jitter[1:]) / self.lines
        angles += 2 * math.pi * jitter[0]
        steps = reach * share[:, None] * np.column_stack([np.cos(angles), np.sin(angles)])
        origin = shapely.Point(centre)
        spokes = []
        for end in np.round((centre + steps) / SNAP) * SNAP:
            # What stands in the way ends a line there: the rim, or a hole of the sheet.
            seen = shapely.intersection(shapely.LineString([centre, end]), lanes)
            parts = [part for part in shapely.get_parts(seen) if part.distance(origin) < SNAP]
            long = parts and parts[0].length > self.line_width
            spokes.append(parts[0] if long else origin)
        if self.style == "spokes":
            return [origin, *spokes]
        corners = [far_end(spoke, centre) for spoke in spokes]
        hull = shapely.intersection(shapely.buffer(shapely.Polygon(corners), 0.0), lanes)
        sides = [
            part.exterior for part in shapely.get_parts(hull) if isinstance(part, shapely.Polygon)
        ]
        return [*sides, *(spokes if self.style == "both" or not sides else [])]

    def _fault(self, shape: BaseGeometry, sheet: Polygon) -> str:
        """What is wrong with a pattern but for its gaps, or nothing."""
        share = shape.area / sheet.area
        if shape.geom_type == "MultiPolygon" and self.connected:
            return "apart"
        if share > min(self.coverage[1], FULL):
            return "full"
        if shape.is_empty or share < self.coverage[0]:
            return "bare"
        return ""

    def _refusal(self, failure: str) -> Exception:
        if failure == "bare":
            return problem(
                f"no pattern covers {100 * self.coverage[0]:.3g} % of the sheet: "
                "choose more polygons, more or wider lines, or a lower coverage",
                key="coverage",
            )
        if failure == "full":
            return problem(
                f"every pattern covers more than {100 * self.coverage[1]:.3g} % of the sheet: "
                "choose fewer polygons, fewer or narrower lines, or a higher coverage",
                key="coverage",
            )
        if failure == "narrow":
            return problem(
                "no pattern keeps its ribs and gaps this wide: "
                "choose fewer polygons or lines, or a smaller minimum_feature",
                key="minimum_feature",
                value=_mm(self.feature),
            )
        return problem(
            "the polygons cannot be joined by straight bars on this sheet: choose more or larger "
            "polygons, narrower lines, a smaller margin, or connected = false",
            key="connected",
        )


def _mm(length: float) -> str:
    return f"{1e3 * length:.4g} mm"
