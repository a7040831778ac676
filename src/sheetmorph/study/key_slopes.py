"""Derivatives by the keys of a design, from those by the fields of its model."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from sheetmorph.core.errors import ComputationError
from sheetmorph.design.laminate import stack_of
from sheetmorph.design.load_tables import WeightLoad
from sheetmorph.design.loads import force_of
from sheetmorph.design.regions import Regions
from sheetmorph.design.spec import Design
from sheetmorph.energy.loads import NodalLoad
from sheetmorph.energy.table import TableContact
from sheetmorph.geometry.mesh import Floats
from sheetmorph.study.contact_slopes import ContactSlopes
from sheetmorph.study.design_keys import piece_with, place_of, with_number
from sheetmorph.study.model import Problem
from sheetmorph.study.parameters import layer_presence, model_arrays
from sheetmorph.study.pattern_slopes import PatternSlopes
from sheetmorph.study.published_slopes import layer_fields

STEP = 1e-5
"""Relative step of the central differences of the arrays of the model."""

SMALL_STEP = 1e-6
"""Relative step by which corners of the pattern are moved."""

FELT = ("layers", "actuation", "published", "gravity", "contact")
"""Tables with keys that the barriers of contact may depend on, the pattern left aside."""


@dataclass(frozen=True, eq=False)
class KeySlopes:
    """What the derivatives by all keys have in common.

    Attributes:
        problem: the problem.
        fields: derivatives by the fields of the model, those by the layers among them.
        motion: λ of the nodes, shape (V, 3).
        ramp: actuation of the state.
        by_mass: derivatives by the masses of the triangles [1/kg], shape (T,); None where
            nothing weighs.
        contact: derivatives by the barriers; None where nothing touches.
        pattern: derivatives by the shapes of the pattern; None where it is sharp.
    """

    problem: Problem
    fields: Mapping[str, Floats]
    motion: Floats
    ramp: float
    by_mass: Floats | None
    contact: ContactSlopes | None
    pattern: PatternSlopes | None

    @classmethod
    def of(
        cls, problem: Problem, fields: Mapping[str, Floats], x: Floats, adjoint: Floats, ramp: float
    ) -> KeySlopes:
        """Prepare what does not depend on the key.

        Args:
            problem: the problem.
            fields: derivatives by the fields of its model.
            x: the state, shape (n,).
            adjoint: λ, shape (n,).
            ramp: actuation of the state.

        Raises:
            ComputationError: a term of the energy that is no part of the chain.
        """
        for term in problem.total.terms[len(problem.model.terms) :]:
            if not isinstance(term, NodalLoad | TableContact):
                raise ComputationError(
                    f"what keys do to the energy term {term.name} is not known, so there are no "
                    "derivatives by keys beside it"
                )
        motion = problem.positions(adjoint)
        contact = ContactSlopes.of(problem, x, adjoint)
        own = dict(fields)
        if "thickness" not in own:
            own |= layer_fields(problem, own)
        by_mass = _by_mass(problem, motion, ramp)
        pattern = None
        if problem.regions.smooth is not None:
            felt, weighed = own, by_mass
            if contact is not None:
                felt = contact.onto_fields(own)
                if not problem.design.laminate:
                    felt |= layer_fields(problem, felt)
                gravity = problem.design.gravity
                if gravity is not None and by_mass is not None:
                    weighed = by_mass + gravity.magnitude * contact.by_scale("weight")
            pattern = PatternSlopes.of(problem, felt, weighed)
        return cls(problem, own, motion, ramp, by_mass, contact, pattern)

    def by_key(self, key: str, value: float) -> float:
        """Derivative by a key of the design [per SI unit].

        Args:
            key: of a number in the design, as `number_at` allows it.
            value: the number.
        """
        design, (table, *rest) = self.problem.design, key.split(".")
        size = abs(value) or 1.0
        if table == "pattern":
            assert self.pattern is not None  # noqa: S101  number_at refuses sharp patterns
            step = SMALL_STEP * size
            more, less = (piece_with(design, key, value + s) for s in (step, -step))
            return self.pattern.by_number(place_of(design.pattern, rest[0]), more, less, step)
        step = STEP * size
        ahead, behind = (with_number(design, key, value + s) for s in (step, -step))
        if table == "layers":
            found = self._by_layer(place_of(design.layers, rest[0]), rest[1])
        elif table == "loads" and not design.is_free:
            found = self._by_load(place_of(design.loads, rest[0]), ahead, behind) / (2.0 * step)
        else:
            found = self._by_arrays(table, ahead, behind) / (2.0 * step)
        if self.contact is not None and table in FELT:
            both = [(one, self._restacked(one)) for one in (ahead, behind)]
            found += self.contact.towards(both[0], both[1]) / (2.0 * step)
        return found

    def _by_layer(self, index: int, name: str) -> float:
        """By a number of a layer, which is the same wherever the layer lies."""
        problem = self.problem
        layer = problem.design.layers[index]
        found = 0.0
        if name == "thickness":
            found = float(self.fields[name][index] @ self._presence(index))
        elif name in self.fields:
            found = float(self.fields[name][index].sum())
        if self.by_mass is not None and name in ("thickness", "density"):
            other = layer.density if name == "thickness" else layer.thickness
            share = layer_presence(problem.design, problem.regions)[index]
            found += other * float(self.by_mass @ (problem.mesh.triangle_areas * share))
        return found

    def _presence(self, index: int) -> Floats:
        """By which the thickness of a layer is multiplied where the fields by layers lie."""
        design, region = self.problem.design, self.problem.regions
        return np.asarray(layer_presence(design, region, edges=not design.laminate)[index])

    def _by_load(self, index: int, ahead: Design, behind: Design) -> float:
        mesh, region = self.problem.mesh, self.problem.regions
        first, last = (
            force_of(design.loads[index], mesh, region, f"loads[{index}]")
            for design in (ahead, behind)
        )
        return self.ramp * float((self.motion * (first - last)).sum())

    def _by_arrays(self, table: str, ahead: Design, behind: Design) -> float:
        mesh = self.problem.mesh
        first, last = (
            model_arrays(design, mesh, self._restacked(design), table) for design in (ahead, behind)
        )
        weights = {**self.fields, "applied": self.ramp * self.motion, "weight": self.motion}
        return sum(float((weights[k] * (first[k] - last[k])).sum()) for k in first)

    def _restacked(self, design: Design) -> Regions:
        """The regions of the problem with the layers of a changed design, nothing moved."""
        cells, smooth = self.problem.regions.cells, self.problem.regions.smooth
        return replace(
            self.problem.regions,
            cells=tuple(replace(cell, stack=stack_of(design, cell.parts)) for cell in cells),
            smooth=None if smooth is None else smooth.with_layers(design),
        )


def _by_mass(problem: Problem, motion: Floats, ramp: float) -> Floats | None:
    """By the masses of the triangles, a third of which goes to each corner, shape (T,)."""
    design = problem.design
    pulls = [
        (ramp * load.gravity, load.direction)
        for load in design.loads
        if isinstance(load, WeightLoad)
    ]
    if design.gravity is not None:
        pulls.append((design.gravity.magnitude, design.gravity.down))
    if not pulls:
        return None
    force = sum(size * np.array(way) / np.linalg.norm(way) for size, way in pulls)
    return np.asarray((motion @ force)[problem.mesh.triangles].mean(axis=1))
