"""A design: what the file says, checked, in SI, and what follows from it alone."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

from pydantic import ValidationError

from sheetmorph.core.errors import InputError
from sheetmorph.core.files import write_text
from sheetmorph.design import files, schema
from sheetmorph.design.content import content_hash
from sheetmorph.design.drawn import Drawing
from sheetmorph.design.layout import find_inert_parts
from sheetmorph.design.messages import to_input_error

if TYPE_CHECKING:
    from shapely import MultiPolygon, Polygon

    from sheetmorph.design import load_tables, outlines, sections, support_tables, surroundings
    from sheetmorph.design.actuation_table import Actuation
    from sheetmorph.design.layout import InertPart, Layout
    from sheetmorph.design.shrinkage import ShrinkCurve
    from sheetmorph.geometry.mesh import SheetMesh
    from sheetmorph.geometry.symmetry import Symmetry

LAMINATE_STEP = 0.01
"""First step of the laminate model where the design names none."""


@dataclass(frozen=True, eq=False)
class Design:
    """A checked design. Make one with `load` or `from_toml`; change one with `with_values`.

    Attributes:
        spec: the validated content in SI units, see `sheetmorph.design.schema`.
        source: the TOML text, with its comments.
        folder: where mesh and curve files are looked up; None when there is none.
        file: the design file, for messages; None when made from text.
    """

    spec: schema.DesignSchema
    source: str = field(repr=False)
    folder: Path | None = None
    file: Path | None = None

    @classmethod
    def load(cls, path: str | Path, values: Mapping[str, object] | None = None) -> Design:
        """Read a design file.

        Args:
            path: the file.
            values: keys to set before it is checked, as for `with_values`.

        Raises:
            InputError: the file cannot be read or holds no valid design; the message
                names the file, the dotted key, the value, and what is allowed.
        """
        file = Path(path)
        try:
            text = files.read_design_text(file)
            if values:
                files.parse_design_text(text)  # what is no TOML is told as such
                text = files.edit_design_text(text, values)
            return cls.from_toml(text, file.parent, file)
        except InputError as error:
            raise error.located(file) from None

    @classmethod
    def from_toml(
        cls, text: str, folder: str | Path | None = None, file: Path | None = None
    ) -> Design:
        """Read a design from TOML text.

        Args:
            text: the content of a design file.
            folder: where its mesh and curve files lie.
            file: the file to name in messages.

        Raises:
            InputError: as for `load`.
        """
        data = files.parse_design_text(text)
        place = None if folder is None else Path(folder)
        try:
            spec = schema.DesignSchema.model_validate(data, context=place)
        except ValidationError as error:
            raise to_input_error(error) from None
        return cls(spec, text, place, file)

    def with_values(self, values: Mapping[str, object]) -> Design:
        """A copy with some keys set; this design is left as it is.

        Args:
            values: from dotted key to value, as in `{"actuation.eps_pre": -0.3,
                "layers.1.thickness": "0.8 mm"}`. Text is read as a TOML value if it is
                one. None removes a key. Keys that exclude each other replace each other.

        Raises:
            InputError: unknown key (the nearest one is named) or a value not allowed.
        """
        try:
            text = files.edit_design_text(self.source, values)
            return Design.from_toml(text, self.folder, self.file)
        except InputError as error:
            raise error.located(self.file) if self.file else error from None

    def to_toml(self) -> str:
        """The design as TOML text, comments kept; `from_toml` reads it back."""
        return self.source

    def to_portable_toml(self) -> str:
        """The design as TOML text with polygons in the place of its drawings."""
        from sheetmorph.design.portable import portable_text

        return portable_text(self)

    def save(self, path: str | Path) -> None:
        """Write the design file, whole or not at all.

        Raises:
            OutputError: it cannot be written.
        """
        write_text(path, self.source)

    # The tables of the file.

    @property
    def name(self) -> str:
        """Name of the design."""
        return self.spec.name

    @property
    def model(self) -> str:
        """Name of the mechanical model."""
        return self.spec.model

    @property
    def laminate(self) -> bool:
        """True for the laminate model, False for the published one."""
        return self.spec.model == "laminate"

    @property
    def layers(self) -> tuple[sections.Layer, ...]:
        """The layers from the bottom up."""
        return self.spec.layers

    @property
    def actuation(self) -> Actuation:
        """The table `actuation`."""
        return self.spec.actuation

    @property
    def supports(self) -> tuple[support_tables.Support, ...]:
        """The tables `supports`; empty for a free sheet."""
        return self.spec.supports

    @property
    def loads(self) -> tuple[load_tables.Load, ...]:
        """The tables `loads`."""
        return self.spec.loads

    @property
    def gravity(self) -> surroundings.Gravity | None:
        """The table `gravity`; None where nothing has a weight."""
        return self.spec.gravity

    @property
    def contact(self) -> surroundings.Contact:
        """The table `contact`."""
        return self.spec.contact

    @property
    def perturbation(self) -> sections.Perturbation:
        """The table `perturbation`."""
        return self.spec.perturbation

    @property
    def published(self) -> sections.PublishedOptions:
        """The table `published`."""
        return self.spec.published

    @property
    def solver(self) -> sections.SolverOptions:
        """The table `solver`."""
        return self.spec.solver

    @property
    def initial_step(self) -> float:
        """First step of the path, as a fraction of the actuation.

        As given, or else 0.1, and 0.01 for the laminate model: its flat sheet buckles at a
        strain of about (thickness/size)², and a step far beyond may land on another branch.
        Never longer than the longest step.
        """
        options = self.solver
        if "initial_step" in options.model_fields_set:
            return options.initial_step
        usual = LAMINATE_STEP if self.laminate else options.initial_step
        return max(options.min_step, min(usual, options.max_step))

    def must_be_still(self, what: str) -> None:
        """Refuse a dynamic design where equilibria are followed.

        Args:
            what: follows them, for people.

        Raises:
            InputError: `solver.kind` is "dynamic".
        """
        if self.solver.kind == "dynamic":
            raise InputError(
                f"{what} follows equilibria, and this design moves in time",
                file=self.file,
                key="solver.kind",
                value="dynamic",
                allowed="quasi_static",
            )

    @property
    def outputs(self) -> sections.Outputs:
        """The table `outputs`."""
        return self.spec.outputs

    @property
    def outline(self) -> outlines.Outline:
        """The table `outline`."""
        return self.spec.outline

    @property
    def pattern(self) -> tuple[outlines.PatternShape, ...]:
        """The shapes whose union is the pattern."""
        return self.spec.pattern

    # What follows from them.

    @property
    def is_free(self) -> bool:
        """True when nothing is held and the rigid motions are removed instead."""
        return all(support.kind == "free" for support in self.supports)

    @cached_property
    def eps_pre(self) -> float:
        """Free strain of an unconstrained active layer; negative is shrinkage.

        With a radial profile or a field it is the factor on the strains of the table.

        Raises:
            InputError: the temperature lies outside the shrink curve, or the curve's
                file is not usable.
        """
        if self.actuation.eps_pre is not None:
            return self.actuation.eps_pre
        if self.actuation.profile in ("radial", "field"):
            return 1.0
        assert self.actuation.temperature is not None  # noqa: S101  the schema wants one of the two
        return self._curve.eps_pre(self.actuation.temperature)

    @property
    def eps_pre_scatter(self) -> float | None:
        """Standard deviation of `eps_pre` by the scatter of the shrink curve's measurements.

        None where the design gives `eps_pre` itself, or the curve has no scatter.

        Raises:
            InputError: the curve's file is not usable.
        """
        heat = self.actuation.temperature
        return None if heat is None else self._curve.eps_pre_scatter(heat)

    @cached_property
    def _curve(self) -> ShrinkCurve:
        from sheetmorph.design.shrinkage import load_curve

        return load_curve(self)

    @property
    def layout(self) -> Layout:
        """The plan of the sheet: outline, slits and parts of the pattern."""
        return self.spec.layout

    def outline_polygon(self) -> Polygon:
        """The outline of the sheet [m], circles as inscribed polygons."""
        return self.layout.sheet

    def pattern_polygon(self) -> MultiPolygon:
        """The pattern within the sheet [m], all parts together; empty when there is none."""
        return self.layout.pattern

    @cached_property
    def inert_parts(self) -> tuple[InertPart, ...]:
        """The inert layers of the parts of the pattern, in the order of the layers."""
        return find_inert_parts(self.spec)

    @cached_property
    def symmetry(self) -> Symmetry:
        """The symmetry that outline, slits and every part of the pattern have in common."""
        from sheetmorph.geometry.symmetry import find_symmetry

        layout = self.layout
        shapes = [layout.sheet, *layout.parts.values(), layout.slits]
        return find_symmetry([shape for shape in shapes if not shape.is_empty])

    @property
    def notes(self) -> tuple[str, ...]:
        """What was closed, joined, cut off or left out in drawings and plan."""
        shapes = [self.outline, *self.pattern]
        notes = [note for shape in shapes if isinstance(shape, Drawing) for note in shape.notes()]
        return tuple(dict.fromkeys([*notes, *self.layout.notes]))

    def resolve_mesh_path(self) -> Path | None:
        """Path of the mesh file, or None when the mesh is made from its size.

        Raises:
            InputError: the file is not there, or lies outside its folder.
        """
        mesh = self.spec.mesh
        if mesh.reference_file is not None:
            folder = files.reference_folder(self.folder)
            return self._inside(folder, mesh.reference_file, "mesh.reference_file")
        if mesh.file is not None:
            return self.resolve_file(mesh.file, "mesh.file")
        return None

    def resolve_file(self, name: str, key: str) -> Path:
        """Path of a file that the design names, inside the design's folder.

        Raises:
            InputError: there is no folder or no such file, or the name leads out of it.
        """
        if self.folder is None:
            raise InputError(
                "the design has no folder in which to look for it", key=key, value=name
            )
        return self._inside(self.folder, name, key)

    def _inside(self, folder: Path, name: str, key: str) -> Path:
        try:
            return files.path_inside(folder, name, key)
        except InputError as error:
            raise error.located(self.file) if self.file else error from None

    def build_mesh(self) -> SheetMesh:
        """The reference mesh: made from the outline, or read from the mesh file.

        Its hinges run as `published.hinge_orientation` wants.

        Raises:
            InputError: the mesh file is not usable or does not fit the outline.
        """
        from sheetmorph.design.meshing import build_mesh

        return build_mesh(self)

    @cached_property
    def hash(self) -> str:
        """SHA-256 of the content: SI values, drawings, and the bytes of the other files it names.

        The name, the outputs, the limits of time and steps, comments, and the units in which
        a value is written do not change it.

        Raises:
            InputError: a file that the design names is not there.
        """
        return content_hash(self)
