"""What the mesh of a sheet must follow: its outline, regions, slits and locked lines."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from sheetmorph.geometry.mesh import Floats

if TYPE_CHECKING:
    from shapely import Geometry, Polygon


@dataclass(frozen=True, eq=False)
class Plan:
    """The lines of a drawing, before any meshing.

    Attributes:
        outline: boundary of the sheet, holes allowed.
        regions: polygons within the outline; they may overlap, touch and nest.
        slits: lines along which the mesh shall open, noded; may be empty.
        locked: straight lines on the outline whose nodes never slide; may be empty.
    """

    outline: Polygon
    regions: tuple[Geometry, ...]
    slits: Geometry
    locked: Geometry

    def moved(self, move: Callable[[Floats], Floats]) -> Plan:
        """The plan with all its coordinates, shape (N, 2), mapped by a function."""
        import shapely

        return Plan(
            shapely.transform(self.outline, move),
            tuple(shapely.transform(region, move) for region in self.regions),
            shapely.transform(self.slits, move),
            shapely.transform(self.locked, move),
        )

    def with_regions(self, regions: tuple[Geometry, ...]) -> Plan:
        """The same plan with other regions."""
        return replace(self, regions=regions)

    def with_slits(self, slits: Geometry) -> Plan:
        """The same plan with other slits."""
        return replace(self, slits=slits)

    def marked_lines(self) -> Geometry:
        """Boundaries of the regions and slits: where edges are short in a graded mesh.

        Locked lines are no boundaries of a region, the sheet goes on beyond them. Where two
        of them are the sides of a wedge, the lines beyond them are those that a turn of the
        wedge brings there.
        """
        import shapely

        rims = shapely.union_all([region.boundary for region in self.regions])
        if not self.locked.is_empty:
            rims = shapely.difference(rims, self.locked.buffer(1e-6 * self.locked.length))
        lines = [rims, self.slits]
        turn = _turn_between(self.locked)
        if turn is not None:
            angle, centre = turn
            for sign in (-1.0, 1.0):
                lines += [_turned(line, sign * angle, centre) for line in lines[:2]]
        return shapely.unary_union([line for line in lines if not line.is_empty])


def _turn_between(locked: Geometry) -> tuple[float, Floats] | None:
    """Angle [rad] and centre of the turn that maps the first locked line's direction to another."""
    import numpy as np
    import shapely

    ends = np.array([shapely.get_coordinates(part)[[0, -1]] for part in shapely.get_parts(locked)])
    if len(ends) < 2:
        return None
    first, direction = ends[0, 0], ends[:, 1] - ends[:, 0]
    direction /= np.linalg.norm(direction, axis=1)[:, None]
    sines = direction[0, 0] * direction[:, 1] - direction[0, 1] * direction[:, 0]
    if np.abs(sines).max() < 1e-6:
        return None
    other = int(np.argmax(np.abs(sines)))
    apart = ends[other, 0] - first
    along = (apart[0] * direction[other, 1] - apart[1] * direction[other, 0]) / sines[other]
    centre = first + along * direction[0]
    # Each line runs from the centre outwards.
    arms = ends[[0, other]].mean(axis=1) - centre
    cross = arms[0, 0] * arms[1, 1] - arms[0, 1] * arms[1, 0]
    return float(np.arctan2(cross, arms[0] @ arms[1])), centre


def _turned(shape: Geometry, angle: float, centre: Floats) -> Geometry:
    import numpy as np
    import shapely

    c, s = np.cos(angle), np.sin(angle)
    matrix = np.array([[c, s], [-s, c]])
    return shapely.transform(shape, lambda xy: (xy - centre) @ matrix + centre)
