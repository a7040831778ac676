"""The tables of the design file other than its shapes, each a frozen model in SI."""

from __future__ import annotations

from typing import Annotated, Any, Literal, Self

from pydantic import Field, model_validator

from sheetmorph.core.errors import InputError
from sheetmorph.design.fields import (
    FileName,
    Flag,
    Number,
    Quantity,
    Section,
    Size,
    Whole,
    problem,
)
from sheetmorph.design.materials import layer_values
from sheetmorph.design.motion_table import DynamicOptions

EVERYWHERE = "everywhere"
"""Where a layer lies that covers the whole sheet."""

Fraction = Annotated[Number, Field(gt=0, le=1)]


class Layer(Section):
    """One layer of the sheet; `layers` lists them from the bottom up.

    Attributes:
        role: "active" layers shrink or swell when actuated, "inert" ones do not.
        where: "everywhere", or the name of a part of the pattern, such as "pattern".
        thickness: [m].
        material: name in the library of materials, which then gives the keys from here on
            that the design leaves out; None for none.
        young_modulus: at the temperature of actuation [Pa].
        density: [kg/m³].
        eigenstrain_factor: factor on the free strain of this active layer; laminate model.
    """

    name: Annotated[str, Field(min_length=1, max_length=60, pattern=r"^[^\x00-\x1f\x7f]+$")]
    role: Literal["active", "inert"]
    thickness: Annotated[float, Quantity("length", "1 um", "10 cm")]
    # Not dumped: the content of a design is the values, wherever they come from.
    material: Annotated[
        Annotated[str, Field(min_length=1, max_length=60)] | None, Field(exclude=True)
    ] = None
    young_modulus: Annotated[float, Quantity("pressure", "0 Pa", "10000 GPa", above=True)]
    poisson_ratio: Annotated[Number, Field(ge=0, lt=0.5)] = 0.33
    density: Annotated[float, Quantity("density", "0.1 kg/m^3", "30000 kg/m^3")] = 1000.0
    where: Annotated[str, Field(min_length=1, max_length=60)] = EVERYWHERE
    eigenstrain_factor: Annotated[Number, Field(ge=-10, le=10)] = 1.0

    @model_validator(mode="before")
    @classmethod
    def _of_material(cls, data: Any) -> Any:
        if not isinstance(data, dict):
            return data
        name = data.get("material")
        if isinstance(name, str) and name:
            try:
                return {**layer_values(name), **data}
            except InputError as error:
                raise problem(
                    error.message, key="material", value=name, allowed=error.allowed
                ) from None
        if "young_modulus" not in data and all(key in cls.model_fields for key in data):
            raise problem(
                "is required, unless a material gives it",
                key="young_modulus",
                allowed='such as "2.7 MPa", or material = "PLA"',
            )
        return data


class Perturbation(Section):
    """A small load that chooses the branch and is removed at the end.

    Attributes:
        shape: "uniform" pushes all nodes alike and needs supports; "bowl" pushes the rim
            one way and the middle the other, without net force or moment.
        force_per_node: mean force on a node [N].
        total_force: sum of the forces on the nodes, signs left aside [N]; does not depend
            on the mesh.
        ramp_down_steps: number of equal steps in which it is removed.
    """

    shape: Literal["uniform", "bowl"] = "bowl"
    force_per_node: Annotated[float, Quantity("force", "0 N", "1000 N")] | None = None
    total_force: Annotated[float, Quantity("force", "0 N", "1000000 N")] | None = None
    direction: Literal["up", "down"] = "up"
    ramp_down_steps: Annotated[Whole, Field(ge=1, le=1000)] = 1

    @model_validator(mode="after")
    def _one_force(self) -> Self:
        if self.force_per_node is not None and self.total_force is not None:
            raise problem(
                "force_per_node and total_force exclude each other; keep one of them",
                key="total_force",
            )
        return self


class MeshSource(Section):
    """Where the mesh comes from: made with elements of `size`, or read from a file.

    Attributes:
        size: edge length of the mesh to make [m].
        boundary_size: edge length at the boundaries of the pattern and along slits [m];
            `size` by default.
        growth: how fast edges grow from there, length per length.
        symmetry: "auto" makes a mesh with all the symmetry that the design has, "mirror" and
            "rotation" with that part of it.
        file: name of a mesh file in the folder of the design file.
        reference_file: name of a mesh file in the folder of reference data.
        unit: unit of length of the coordinates in the file.
        curved: the sheet of the file need not be flat; its form is free of stress.
        pattern_smoothing: width over which layers of the pattern taper off at its boundary, which
            a mesh that is made then does not follow [m]; None for a sharp boundary.
    """

    size: Size | None = None
    boundary_size: Size | None = None
    growth: Annotated[Number, Field(ge=0.05, le=0.5)] = 0.3
    symmetry: Literal["none", "auto", "mirror", "rotation"] = "none"
    file: FileName | None = None
    reference_file: FileName | None = None
    unit: Literal["um", "mm", "cm", "m", "in"] = "mm"
    curved: Flag = False
    pattern_smoothing: Size | None = None

    @model_validator(mode="after")
    def _one_source(self) -> Self:
        sources = ("size", "file", "reference_file")
        given = [name for name in sources if getattr(self, name) is not None]
        if not given:
            raise problem("say where the mesh comes from", key="size", allowed=", ".join(sources))
        if len(given) > 1:
            raise problem(f"{given[0]} and {given[1]} exclude each other; keep one", key=given[1])
        if given == ["size"] and "unit" in self.model_fields_set:
            raise problem("belongs to mesh files; size carries its own unit", key="unit")
        if given == ["size"] and self.curved:
            raise problem("belongs to mesh files; a mesh that is made is flat", key="curved")
        for key in ("boundary_size", "growth", "symmetry"):
            if self.size is None and key in self.model_fields_set:
                raise problem("belongs to meshes made from their size", key=key)
        if self.size is not None and self.boundary_size is not None:
            if not self.size / 20 <= self.boundary_size <= self.size:
                low, high = 1e3 * self.size / 20, 1e3 * self.size
                raise problem(
                    "does not go with the size",
                    key="boundary_size",
                    value=f"{1e3 * self.boundary_size:g} mm",
                    allowed=f"{low:g} to {high:g} mm, a twentieth of the size up to the size",
                )
        elif "growth" in self.model_fields_set:
            raise problem("belongs to boundary_size, which is not given", key="growth")
        return self


class PublishedOptions(Section):
    """Options of the published model, named after what they change.

    Attributes:
        stretch_stiffness: "scaled_by_edge_length" multiplies each edge's stiffness by its
            own length in metres, as in the released numbers; "printed" does not, as in the
            printed energy.
        stretch_factor: factor on the stretching stiffness.
        coupling: natural dihedral angle per strain difference, beta·l0.
        mean_edge_length: l0 of the stiffness formulas [m]; that of the mesh by default.
        hinge_orientation: which way hinges run, and so the sign of the coupling:
            "file_order" as the file lists its edges, "away_from_pattern" by geometry.
    """

    stretch_stiffness: Literal["scaled_by_edge_length", "printed"] = "scaled_by_edge_length"
    stretch_factor: Annotated[Number, Field(gt=0, le=1e9)] = 10.0
    coupling: Annotated[Number, Field(ge=-1e6, le=1e6)] = 1.0
    mean_edge_length: Size | None = None
    hinge_orientation: Literal["file_order", "away_from_pattern"] | None = None


class LaminateOptions(Section):
    """Options of the laminate model.

    Attributes:
        thickening: "volume_conserved": an active layer that shrinks in its plane thickens, so
            that its volume stays; "none": layers keep their thickness.
    """

    thickening: Literal["volume_conserved", "none"] = "volume_conserved"


class SolverOptions(Section):
    """How the equilibrium path is followed. Steps are fractions of the actuation.

    Attributes:
        kind: "quasi_static" follows equilibria; "dynamic" solves the equation of motion, as
            the table `dynamic` says.
        initial_step: the first step; `Design.initial_step` is what it is by default.
        tolerance: residual force that counts as equilibrium, as a fraction of the moment
            of one stiffest hinge bent by 1 rad over a mean edge length.
        max_iterations: iterations allowed per step.
        max_steps: steps allowed in all.
        time_limit: [s]; none by default.
        threads: of the linear solver, where it has any (rslab); 0 is one.
        dynamic: steps in time, damping and course; read where `kind` says so.
    """

    kind: Literal["quasi_static", "dynamic"] = "quasi_static"
    initial_step: Fraction = 0.1
    max_step: Fraction = 0.1
    min_step: Fraction = 1e-3
    tolerance: Annotated[Number, Field(ge=1e-14, le=1e-2)] = 1e-8
    max_iterations: Annotated[Whole, Field(ge=1, le=10_000)] = 100
    max_steps: Annotated[Whole, Field(ge=1, le=100_000)] = 1000
    time_limit: Annotated[float, Quantity("time", "0 s", "720 h", above=True)] | None = None
    linear_solver: Literal["auto", "mkl", "rslab", "scipy"] = "auto"
    threads: Annotated[Whole, Field(ge=0, le=256)] = 0
    dynamic: DynamicOptions | None = None

    @model_validator(mode="after")
    def _has_its_table(self) -> Self:
        if self.kind == "dynamic" and self.dynamic is None:
            raise problem(
                "the dynamic solver needs to know its time step and what acts when",
                key="dynamic",
                allowed="a table [solver.dynamic] with time_step and course",
            )
        return self

    @model_validator(mode="after")
    def _ordered(self) -> Self:
        given = "initial_step" in self.model_fields_set
        if self.min_step > self.max_step or (
            given and not self.min_step <= self.initial_step <= self.max_step
        ):
            raise problem(
                "steps must be in order", key="initial_step", allowed="min_step to max_step"
            )
        return self


class Outputs(Section):
    """What a run writes beside its result."""

    pictures: Flag = True
    animation: Flag = True
    report: Flag = True
    series: Flag = True
