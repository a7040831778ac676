"""The two faces of a scanned sheet: whether both are there, and which triangle is on which."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Literal

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array, csr_array
from scipy.sparse.csgraph import (
    connected_components,
    dijkstra,
    minimum_spanning_tree,
)

from sheetmorph.compare.topology import Edges, components, edges_of, is_closed, loop_lengths
from sheetmorph.core.errors import InputError
from sheetmorph.geometry.mesh import Floats

if TYPE_CHECKING:
    from sheetmorph.compare.surface import Surface

Face = Literal["auto", "both", "outer", "inner"]
Mask = NDArray[np.bool_]
Indices = NDArray[np.int64]

THIN = 0.1  # a sheet is thinner than this share of the square root of its area
OPPOSED = 0.7  # cosine between the normals of opposite faces, at least; less at a rim
SPLIT = 0.6  # share of the faces' area that must lie opposite to the other face
TWO_FACED = 0.55  # share of the area that must have an opposite face
CURVED = 0.03  # outer and inner differ by this share of the radius, or are not told apart
BLOCKS = 40_000  # a larger scan is looked at in about so many patches


@dataclass(frozen=True, eq=False)
class Faces:
    """What the two sides of a scan are.

    Attributes:
        kind: "one" face of a sheet, "two" faces of a thick sheet, or a "solid" body.
        outer: triangles of the outer (convex) face with its half of the rim, shape (T,);
            all of them where there is one face or the two run into each other.
        inner: all other triangles, those of the inner (concave) face, shape (T,).
        turned: triangles to turn over for normals that point out of the sheet, shape (T,).
        thickness: median distance between the faces, in the unit of the surface; None
            where there is one face.
        told_apart: False where neither face is the convex one, as on a flat plate; then
            "outer" is the one that looks up (+z).
        notes: sentences for people.
    """

    kind: Literal["one", "two", "solid"]
    outer: Mask
    inner: Mask
    turned: Mask
    thickness: float | None
    told_apart: bool
    notes: tuple[str, ...] = ()

    @property
    def two_faced(self) -> bool:
        """Whether both faces of the sheet are there."""
        return self.kind == "two"


@dataclass(frozen=True, eq=False)
class _Blocks:
    """Small patches of a surface, each with a triangle that speaks for it."""

    of_triangle: Indices
    points: Floats
    normals: Floats
    areas: Floats
    speaker: Indices


def faces_of(surface: Surface) -> Faces:
    """Find out whether a scan holds both faces of a sheet, and split it into them.

    From every triangle a ray runs through the material, against the normal; where both
    faces are there it soon meets the other one from behind, and the length of the way is
    the thickness. Patches that meet each other so are opposite faces, and what lies
    between them (the rim) goes to the nearer one. Outer is the face whose normals point
    away from the middle of the scan.
    """
    blocks = _blocks(surface)
    limit = THIN * float(np.sqrt(surface.area / 2.0))
    pieces = components(surface.triangles, len(surface.points))
    piece = pieces[blocks.speaker]
    inward, way = _meet(surface, blocks, -blocks.normals)
    outward, back = _meet(surface, blocks, blocks.normals)
    # A separate face may be turned either way: the sheet's material decides.
    gain = [
        np.bincount(piece, blocks.areas * _thin(blocks, meets, length, limit, None))
        for meets, length in ((inward, way), (outward, back))
    ]
    flip = (gain[1] > gain[0])[piece]
    mate = np.where(flip, outward, inward)
    length = np.where(flip, back, way)
    sign = np.where(flip, -1.0, 1.0)
    blocks = replace(blocks, normals=blocks.normals * sign[:, None])
    paired = _thin(blocks, mate, length, limit, -OPPOSED)
    share = float(blocks.areas @ paired) / surface.area
    if share < TWO_FACED:
        return _one_face(surface, blocks, mate, length)
    thickness = _weighted_median(length[paired], blocks.areas[paired])
    turned = flip[blocks.of_triangle]
    notes = [
        f"The scan holds both faces of a sheet, {thickness / surface.size:.2%} of its size thick."
    ]
    side, clean = _sides(surface, blocks, mate, paired)
    if clean < SPLIT:
        notes.append("The two faces run into each other and cannot be told apart.")
        every = np.ones(len(turned), dtype=bool)
        return Faces("two", every, ~every, turned, thickness, False, tuple(notes))
    side, told_apart = _outer_first(blocks, side)
    outer = side[blocks.of_triangle]
    if not told_apart:
        notes.append("Neither face is the convex one; the one that looks up is called outer.")
    if clean < 0.9:
        notes.append(f"{1.0 - clean:.0%} of the area may be counted to the wrong face.")
    return Faces("two", outer, ~outer, turned, thickness, told_apart, tuple(notes))


def face_of(surface: Surface, faces: Faces, face: Face) -> tuple[Surface, str]:
    """The face to compare, with normals that point out of the sheet, and its name.

    "auto" takes the outer face of two and all of one. A scan with one face ("single") is
    that face whatever is asked for, and one whose faces cannot be told apart is "both".

    Raises:
        InputError: no such face.
    """
    from sheetmorph.compare.surface import Surface as NewSurface

    if face not in ("auto", "both", "outer", "inner"):
        raise InputError("no such face", key="face", value=face, allowed="auto, both, outer, inner")
    triangles = np.where(faces.turned[:, None], surface.triangles[:, ::-1], surface.triangles)
    whole = NewSurface(surface.points, triangles)
    if not faces.two_faced:
        return whole, "both" if faces.kind == "solid" else "single"
    if face == "both" or not faces.inner.any():
        return whole, "both"
    inner = face == "inner"
    return whole.part(faces.inner if inner else faces.outer), "inner" if inner else "outer"


def _one_face(surface: Surface, blocks: _Blocks, mate: Indices, length: Floats) -> Faces:
    opposed = _thin(blocks, mate, length, np.inf, 0.0)
    solid = float(blocks.areas @ opposed) > 0.9 * surface.area and _closed(surface)
    notes = []
    if solid:
        depth = _weighted_median(length[opposed], blocks.areas[opposed]) / surface.size
        notes.append(
            "This looks like a solid body, not a sheet: it is closed and about "
            f"{depth:.0%} of its size thick."
        )
    every = np.ones(len(surface.triangles), dtype=bool)
    none = ~every
    return Faces("solid" if solid else "one", every, none, none, None, False, tuple(notes))


def _blocks(surface: Surface) -> _Blocks:
    """Every triangle on its own, or those together that share a cell and a direction."""
    centres = surface.points[surface.triangles].mean(axis=1)
    count = len(centres)
    if count <= 1.5 * BLOCKS:
        every = np.arange(count, dtype=np.int64)
        return _Blocks(every, centres, surface.normals, surface.areas, every)
    cell = np.sqrt(surface.area / BLOCKS)
    place = ((centres - surface.box[0]) / cell).astype(np.int64)
    axis = np.abs(surface.normals).argmax(axis=1)
    facing = 2 * axis + (np.take_along_axis(surface.normals, axis[:, None], 1)[:, 0] > 0.0)
    spans = place.max(axis=0) + 1
    key = ((place[:, 0] * spans[1] + place[:, 1]) * spans[2] + place[:, 2]) * 6 + facing
    order = np.lexsort((-surface.areas, key))
    new = np.concatenate([[True], np.diff(key[order]) != 0])
    block = np.empty(count, dtype=np.int64)
    block[order] = np.cumsum(new) - 1
    speaker = order[new]
    areas = np.bincount(block, surface.areas).astype(np.float64)
    return _Blocks(block, centres[speaker], surface.normals[speaker], areas, speaker)


def _meet(surface: Surface, blocks: _Blocks, directions: Floats) -> tuple[Indices, Floats]:
    """The block that a ray from each block meets first, -1 for none, and its length."""
    triangle, length = surface.meets(blocks.points, directions)
    return np.where(triangle >= 0, blocks.of_triangle[triangle], -1), length


def _thin(
    blocks: _Blocks, mate: Indices, length: Floats, limit: float, cosine: float | None
) -> Mask:
    """Blocks with a mate nearer than a limit whose normal is opposed (parallel for None)."""
    product = (blocks.normals * blocks.normals[mate]).sum(axis=1)
    fits = np.abs(product) >= OPPOSED if cosine is None else product <= cosine
    return np.asarray((mate >= 0) & (length <= limit) & fits)


def _sides(surface: Surface, blocks: _Blocks, mate: Indices, paired: Mask) -> tuple[Mask, float]:
    """Two colours for the blocks, and the share of paired area that faces the other colour."""
    count = len(blocks.areas)
    edges = edges_of(surface.triangles, len(surface.points))
    first, second = _neighbours(edges, blocks.of_triangle)
    # Over a rim neighbours are not paired, so that the faces come apart there.
    joined = paired[first] & paired[second]
    joined &= (blocks.normals[first] * blocks.normals[second]).sum(axis=1) > 0.5
    patch = connected_components(_graph(first[joined], second[joined], None, count), False)[1]
    patch = np.asarray(patch, dtype=np.int64)
    colour = _two_colours(patch[paired], patch[mate[paired]], blocks.areas[paired], patch)
    # Small patches say little; everything that is not on a large one follows its neighbours.
    sizes = np.bincount(patch, blocks.areas * paired)
    sure = paired & (sizes[patch] > 1e-3 * sizes.max()) & (colour[patch] >= 0)
    step = np.linalg.norm(blocks.points[first] - blocks.points[second], axis=1) + 1e-12
    graph = _graph(first, second, step, count)
    sources = np.flatnonzero(sure)
    nearest = dijkstra(
        graph, directed=False, indices=sources, min_only=True, return_predecessors=True
    )[2]
    lost = nearest < 0
    nearest[lost] = sources[0]
    side = colour[patch[nearest]] == 0
    facing = side[paired] != side[mate[paired]]
    return side, float(np.average(facing, weights=blocks.areas[paired]))


def _two_colours(first: Indices, second: Indices, weights: Floats, patch: Indices) -> Indices:
    """Opposite colours 0 and 1 for patches that face each other, -1 for those that do not."""
    count = int(patch.max()) + 1
    other = first != second
    votes = coo_array((weights[other], (first[other], second[other])), shape=(count, count)).tocsr()
    votes = votes + votes.T
    # The heaviest votes first: a spanning tree of least 1/weight, coloured by depth.
    tree = votes.copy()
    tree.data = 1.0 / tree.data
    tree = minimum_spanning_tree(tree)
    root = int(np.argmax(np.bincount(first, weights, minlength=count)))
    depth = dijkstra(tree, directed=False, indices=root, unweighted=True)
    depth[np.isinf(depth)] = -1.0
    return np.where(depth < 0.0, -1, depth % 2).astype(np.int64)


def _outer_first(blocks: _Blocks, side: Mask) -> tuple[Mask, bool]:
    """The side whose normals point away from the middle; False: told by +z alone."""
    middle = np.average(blocks.points, weights=blocks.areas, axis=0)
    arm = blocks.points - middle
    radius = float(np.sqrt(np.average((arm**2).sum(axis=1), weights=blocks.areas)))
    away = (blocks.normals * arm).sum(axis=1)
    means = [float(np.average(away[s], weights=blocks.areas[s])) for s in (side, ~side)]
    difference = (means[0] - means[1]) / (2.0 * radius)
    if abs(difference) >= CURVED:
        return (side if difference > 0.0 else ~side), True
    up = float(np.average(blocks.normals[side, 2], weights=blocks.areas[side]))
    return (side if up >= 0.0 else ~side), False


def _neighbours(edges: Edges, block: Indices) -> tuple[Indices, Indices]:
    """Pairs of different blocks that share an edge."""
    order = np.argsort(edges.of_corner.ravel(), kind="stable")
    edge = edges.of_corner.ravel()[order]
    same = np.flatnonzero(edge[1:] == edge[:-1])
    owner = block[order // 3]
    first, second = owner[same], owner[same + 1]
    different = first != second
    return first[different], second[different]


def _graph(first: Indices, second: Indices, weights: Floats | None, count: int) -> csr_array:
    if weights is None:
        return coo_array(
            (np.ones(len(first), dtype=bool), (first, second)), shape=(count, count)
        ).tocsr()
    # Of pairs that are there twice the first counts, so that no weights are summed up.
    pair = np.unique(first * count + second, return_index=True)[1]
    return coo_array((weights[pair], (first[pair], second[pair])), shape=(count, count)).tocsr()


def _closed(surface: Surface) -> bool:
    edges = edges_of(surface.triangles, len(surface.points))
    return is_closed(loop_lengths(surface.points, edges), surface.area)


def _weighted_median(values: Floats, weights: Floats) -> float:
    order = np.argsort(values)
    below = np.cumsum(weights[order])
    return float(values[order[np.searchsorted(below, 0.5 * below[-1])]])
