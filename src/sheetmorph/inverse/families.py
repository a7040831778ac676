"""Families of designs: what of a sheet may vary, between which bounds, and how it is written.

Lengths of a pattern are shares of the half width of the sheet, so that bounds hold for sheets of
any size. A family needs no more than a function from values to the tables of a design file.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from sheetmorph.core.errors import InputError, nearest
from sheetmorph.design.spec import Design
from sheetmorph.geometry.mesh import Floats
from sheetmorph.inverse import plans
from sheetmorph.inverse.limits import Limits

FINE, COARSE = 31, 20
"""Edges of the mesh along the sheet's longer side: of the design itself, and in the search."""

Values = Mapping[str, float]


@dataclass(frozen=True)
class Parameter:
    """Something that may vary.

    Attributes:
        name: as it is told.
        low, high: bounds, both allowed.
        unit: "m", "share" of the half width, or "" for a plain number.
        whole: whether it takes whole numbers alone.
        key: of the design that follows it while the mesh stays; empty where none does.
        factor: of that key by the parameter; half the width of the sheet for a share.
    """

    name: str
    low: float
    high: float
    unit: Literal["m", "share", ""] = "share"
    whole: bool = False
    key: str = ""
    factor: float = 1.0

    @property
    def choices(self) -> int:
        """How many values a whole parameter takes."""
        return int(self.high - self.low) + 1


EPS_PRE = Parameter("eps_pre", -0.80, -0.05, "", key="actuation.eps_pre")
SIZE = "size"


@dataclass(frozen=True)
class Family:
    """Designs that differ in a few numbers.

    Attributes:
        name: as on the command line.
        about: in a few words.
        parameters: what varies, the size of the sheet and eps_pre left aside.
        plan: from values to outline and pattern, as tables of a design file.
        spread: from values to points that are spread evenly over the sheet [m], shape (n, 2).
    """

    name: str
    about: str
    parameters: tuple[Parameter, ...]
    plan: Callable[[Values], plans.Plan]
    spread: Callable[[Values], Floats]


@dataclass(frozen=True)
class Space:
    """A family with the bounds, limits and settings of one search.

    Attributes:
        family: see there.
        parameters: all that varies.
        fixed: values that do not.
        limits: narrower ribs are made as wide as these want.
        overrides: keys that every design of the search has, as for `Design.with_values`.
    """

    family: Family
    parameters: tuple[Parameter, ...]
    fixed: Values
    limits: Limits
    overrides: Mapping[str, object]

    @property
    def low(self) -> Floats:
        """Lower bounds, shape (n,)."""
        return np.array([one.low for one in self.parameters])

    @property
    def high(self) -> Floats:
        """Upper bounds, shape (n,)."""
        return np.array([one.high for one in self.parameters])

    def values(self, point: Sequence[float]) -> dict[str, float]:
        """Values by name; whole ones are rounded.

        Args:
            point: of the parameters, in their own units, shape (n,).
        """
        given = dict(self.fixed)
        for parameter, value in zip(self.parameters, point, strict=True):
            inside = min(max(float(value), parameter.low), parameter.high)
            given[parameter.name] = float(round(inside)) if parameter.whole else inside
        return given

    def design(self, point: Sequence[float], name: str, *, coarse: bool = False) -> Design:
        """The design at a point.

        With `coarse` its mesh has fewer triangles, and its stretching stiffness is scaled such
        that it stays that of the fine mesh: in the published model it grows with the length of
        the edges.

        Raises:
            InputError: these values make no design.
        """
        values = self.values(point)
        half_width = 0.5 * values[SIZE]
        least = 0.5 * self.limits.minimum_width / half_width
        widths = {
            key: max(value, least) for key, value in values.items() if key.endswith("half_width")
        }
        plan = self.family.plan({**values, **widths})
        text = plans.text_of(plan, name, values["eps_pre"], values[SIZE] / FINE)
        design = Design.from_toml(text)
        if self.overrides:
            design = design.with_values(self.overrides)
        return coarsened(design, values[SIZE] / COARSE) if coarse else design

    def spread(self, point: Sequence[float]) -> Floats:
        """Points spread over the sheet [m], shape (n, 2): each the same place of all designs."""
        return self.family.spread(self.values(point))


def coarsened(design: Design, wanted: float) -> Design:
    """The design on a mesh with longer edges, as stiff against stretching as before.

    In the published model's energy the stretching stiffness per area grows with the length of
    the edges, and that against bending does not.

    Args:
        design: on its own mesh.
        wanted: mean edge length [m]; a mesh that is as coarse as this stays.
    """
    size = design.spec.mesh.size
    if size is None or size >= wanted:
        return design
    factor = wanted / size
    keys: dict[str, object] = {"mesh.size": f"{1e3 * factor * size:.6g} mm"}
    options = design.published
    if not design.laminate and options.stretch_stiffness == "scaled_by_edge_length":
        keys["published.stretch_factor"] = options.stretch_factor / factor
    return design.with_values(keys)


def space_of(
    family: Family,
    width: float,
    limits: Limits,
    *,
    sheet: float | None = None,
    fixed: Values | None = None,
    overrides: Mapping[str, object] | None = None,
) -> Space:
    """The space in which a target is sought.

    Args:
        family: of the designs.
        width: largest width of the target in the plan [m]; the sheet is up to 2.4 as large.
        limits: of fabrication.
        sheet: size of the sheet [m] when it is given.
        fixed: values of parameters that do not vary.
        overrides: keys of the design that are set.

    Raises:
        InputError: a fixed parameter is none of the family, or out of its bounds.
    """
    size = Parameter(SIZE, 1.0 * width, 2.4 * width, "m")
    parameters = (size, *family.parameters, EPS_PRE)
    given = dict(fixed or {})
    if sheet is not None:
        given[SIZE] = sheet
        parameters = (replace(size, low=0.5 * sheet, high=2.0 * sheet), *parameters[1:])
    return restricted(Space(family, parameters, {}, limits, dict(overrides or {})), given)


def restricted(space: Space, fixed: Values) -> Space:
    """The space in which some parameters do not vary.

    Raises:
        InputError: one of them is none of the family, or out of its bounds.
    """
    names = [one.name for one in space.parameters]
    for key, value in fixed.items():
        if key not in names:
            guess = nearest(key, names)
            raise InputError(
                f"the family {space.family.name} has no such parameter"
                + (f"; did you mean {guess}?" if guess else ""),
                key="--fix",
                value=key,
                allowed=", ".join(names),
            )
        one = space.parameters[names.index(key)]
        if not one.low <= value <= one.high:
            raise InputError(
                "is out of range",
                key=f"--fix {key}",
                value=value,
                allowed=f"{one.low:g} to {one.high:g}",
            )
    left = tuple(one for one in space.parameters if one.name not in fixed)
    return replace(space, parameters=left, fixed={**space.fixed, **fixed})


def _share(name: str, low: float, high: float) -> Parameter:
    """A length of the first shape of the pattern, as a share of the half width of the sheet."""
    return Parameter(name, low, high, key=f"pattern.0.{name}")


def _angle(low: float, high: float) -> Parameter:
    """The rotation of the first shape of the pattern [deg]."""
    return Parameter("rotation", low, high, "", key="pattern.0.rotation", factor=math.pi / 180.0)


FAMILIES: dict[str, Family] = {
    one.name: one
    for one in (
        Family(
            "star",
            "a disc with a star of straight arms: bowls",
            (
                Parameter("arms", 3, 8, "", whole=True),
                _share("arm_length", 0.35, 0.97),
                _share("half_width", 0.02, 0.20),
                _share("hub_radius", 0.02, 0.60),
            ),
            plans.star,
            plans.spread_disc,
        ),
        Family(
            "lotus",
            "a disc with a round middle and petals: bowls",
            (
                Parameter("petals", 3, 8, "", whole=True),
                _share("disc_radius", 0.10, 0.60),
                _share("radius", 0.65, 0.97),
                _share("petal_half_width", 0.04, 0.25),
            ),
            plans.lotus,
            plans.spread_disc,
        ),
        Family(
            "ring",
            "a disc with a ring near its rim: saddles",
            (_share("radius", 0.60, 1.0), _share("width", 0.05, 0.45)),
            plans.ring,
            plans.spread_disc,
        ),
        Family(
            "cross",
            "a rectangle with a four-armed star: petals, vaults",
            (
                Parameter("aspect", 0.4, 1.0, ""),
                _share("arm_length", 0.4, 1.4),
                _share("half_width", 0.02, 0.25),
                _angle(0.0, 45.0),
            ),
            plans.cross,
            plans.spread_rectangle,
        ),
        Family(
            "canoe",
            "an ellipse or rectangle with two joined stars: long bowls",
            (
                Parameter("aspect", 0.25, 1.0, ""),
                _share("spacing", 0.1, 1.1),
                _share("arm_length", 0.15, 0.6),
                _share("half_width", 0.02, 0.12),
            ),
            plans.canoe,
            plans.spread_ellipse,
        ),
        Family(
            "stripes",
            "a rectangle with parallel ribs: cylinders",
            (
                Parameter("ribs", 1, 6, "", whole=True),
                Parameter("aspect", 0.4, 1.0, ""),
                _share("half_width", 0.02, 0.15),
                Parameter("rotation", 0.0, 90.0, ""),
            ),
            plans.stripes,
            plans.spread_rectangle,
        ),
    )
}
FREE = "free"


def find_family(name: str) -> Family:
    """The family of a name.

    Raises:
        InputError: there is none.
    """
    if name not in FAMILIES:
        guess = nearest(name, [*FAMILIES, FREE])
        raise InputError(
            "there is no such family" + (f"; did you mean {guess}?" if guess else ""),
            key="--family",
            value=name,
            allowed=", ".join([*FAMILIES, FREE]),
        )
    return FAMILIES[name]
