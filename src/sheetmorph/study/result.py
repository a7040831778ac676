"""What a simulation returns: every state, its fields, and how it was computed."""

from __future__ import annotations

import json
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from sheetmorph.core.errors import InputError
from sheetmorph.core.files import write_text
from sheetmorph.design.regions import Regions, regions
from sheetmorph.design.spec import Design
from sheetmorph.geometry import surface
from sheetmorph.geometry.mesh import Floats, SheetMesh
from sheetmorph.study.motion_record import MotionRecord
from sheetmorph.study.result_file import read_result, write_result

if TYPE_CHECKING:
    from sheetmorph import View

Bools = NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class Result:
    """States of a sheet from flat to actuated, with S states, V nodes, E edges, H hinges.

    Attributes:
        design: the design that was simulated.
        mesh: its reference mesh.
        positions: node positions of every state [m], shape (S, V, 3); state 0 is flat.
        ramp: fraction of the actuation at every state, shape (S,), 0 to 1.
        load_fraction: fraction of the perturbation load at every state, shape (S,).
        residual: largest residual force at every state [N], shape (S,).
        thermal_strain_full: eigenstrain of the edges at full actuation, shape (E,).
        edge_in_pattern: edges whose midpoint lies in the pattern, shape (E,).
        triangle_in_pattern: triangles whose centroid lies in the pattern, shape (T,).
        stretch_stiffness: K of every edge [J], shape (E,); empty for the laminate model.
        bending_stiffness: k_b of every hinge [J], shape (H,); empty for the laminate model.
        coupling: natural dihedral angle per strain mismatch of every hinge, shape (H,); empty
            for the laminate model.
        held_nodes: indices of the nodes that supports hold, shape (N,).
        scalars: scalar unknowns of every state [m], shape (S, n): turns of the directors of the
            laminate model times the mean edge length; n = 0 for the published one.
        summary: the numbers of `summary.json`.
        motion: times, velocities and energies of a dynamic run; None for a quasi-static one.
    """

    design: Design
    mesh: SheetMesh
    positions: Floats
    ramp: Floats
    load_fraction: Floats
    residual: Floats
    thermal_strain_full: Floats
    edge_in_pattern: Bools
    triangle_in_pattern: Bools
    stretch_stiffness: Floats
    bending_stiffness: Floats
    coupling: Floats
    held_nodes: NDArray[np.intp]
    scalars: Floats
    summary: dict[str, Any] = field(default_factory=dict)
    motion: MotionRecord | None = None

    @classmethod
    def load(cls, path: str | Path) -> Result:
        """Read a result.

        Args:
            path: the folder of a run, or its `result.h5`.

        Raises:
            InputError: there is none, or it is damaged; the message names the file.
        """
        place = Path(path)
        file = place / "result.h5" if place.is_dir() else place
        if place.is_dir() and not file.is_file():
            unfinished = (place / "states" / "journal.json").is_file()
            raise InputError(
                "this run is not finished; continue it with sheetmorph run --resume"
                if unfinished
                else "this folder holds no result.h5",
                file=place,
            )
        parts = read_result(file)
        try:
            design = Design.from_toml(parts.pop("design"), file.parent)
        except InputError as error:
            raise error.located(file) from None
        return cls(design=design, mesh=SheetMesh(**parts.pop("mesh")), **parts)

    def save(self, path: str | Path) -> Path:
        """Write `result.h5` and `summary.json` into a folder, or one HDF5 file.

        Args:
            path: a folder, made if need be; or a file name that ends in .h5.

        Returns:
            The path of the HDF5 file.

        Raises:
            OutputError: it cannot be written.
        """
        place = Path(path)
        if place.suffix == ".h5":
            write_result(self, place)
            return place
        write_result(self, place / "result.h5")
        self.save_summary(place)
        return place / "result.h5"

    def save_summary(self, folder: str | Path) -> None:
        """Write `summary.json` into a folder.

        Raises:
            OutputError: it cannot be written.
        """
        text = json.dumps(self.summary, indent=2, ensure_ascii=False, allow_nan=False)
        write_text(Path(folder) / "summary.json", text + "\n")

    def show(self, *, field: str = "", height: int = 480) -> View:
        """The shape in space, to be turned and scrubbed: the last line of a cell in Jupyter.

        Needs `pip install "sheetmorph[studio]"`, and neither a server nor a network.

        Args:
            field: what the colours show at first, such as "height", "angle" or "mean"; the
                material by default.
            height: of the view [px].

        Raises:
            InputError: there is no such field; the packages of the studio are not installed.
        """
        from sheetmorph import view  # the package's table of names, which lies above all rooms

        return view(self, field=field, height=height)

    @property
    def status(self) -> str:
        """How the run ended, such as "completed"; see `sheetmorph.solve.path.Status`."""
        return str(self.summary["status"])

    @cached_property
    def regions(self) -> Regions:
        """In which cell of the plan each edge, triangle, hinge and node lies."""
        return regions(self.design, self.mesh)

    @cached_property
    def actuation(self) -> Floats:
        """Free shrinkage eps_pre reached at every state, shape (S,)."""
        return np.asarray(self.ramp * self.summary["eps_pre"])

    @cached_property
    def strain(self) -> Floats:
        """Edge strain l/l0 − 1, shape (S, E)."""
        return surface.edge_strain(self.positions, self.mesh.edges, self.mesh.edge_lengths)

    @cached_property
    def dihedral(self) -> Floats:
        """Signed dihedral angle of the hinges [rad], shape (S, H); 0 when flat."""
        return surface.dihedral_angles(self.positions, self.mesh.hinges)

    @cached_property
    def thermal_strain(self) -> Floats:
        """Eigenstrain of the edges, shape (S, E)."""
        return np.asarray(self.ramp[:, None] * self.thermal_strain_full)

    @cached_property
    def height(self) -> Floats:
        """Height z of the nodes above the reference plane [m], shape (S, V)."""
        return np.asarray(self.positions[:, :, 2])

    @cached_property
    def stretch_energy_density(self) -> Floats:
        """Stretching energy per area of the flat sheet [J/m²], shape (S, E).

        The area of an edge is a third of that of the triangles beside it. With the laminate
        model it is that of the triangles, shape (S, T), see `energy.laminate_fields`.
        """
        if self.design.laminate:
            return self._laminate_densities[0]
        mismatch = self.strain - self.thermal_strain
        return np.asarray(0.5 * self.stretch_stiffness * mismatch**2 / self.mesh.edge_areas)

    @cached_property
    def bend_energy_density(self) -> Floats:
        """Bending energy per area of the flat sheet [J/m²], shape (S, H).

        The area of a hinge is a third of that of its two triangles. With the laminate model it
        is that of the triangles, shape (S, T).
        """
        if self.design.laminate:
            return self._laminate_densities[1]
        mismatch = self.strain - self.thermal_strain
        ac, ad, bc, bd = (mismatch[:, self.mesh.hinge_edges[:, k]] for k in range(1, 5))
        angle = self.dihedral - self.coupling * (ac - ad + bc - bd)
        areas = self.mesh.edge_areas[self.mesh.hinge_edges[:, 0]]
        return np.asarray(0.5 * self.bending_stiffness * angle**2 / areas)

    @cached_property
    def _laminate_densities(self) -> tuple[Floats, Floats]:
        from sheetmorph.study.laminate_model import energy_densities, laminate_shell

        shell = laminate_shell(self.design, self.mesh, self.regions)
        return energy_densities(shell, self.positions, self.scalars, self.ramp)

    @cached_property
    def mean_curvature(self) -> Floats:
        """Mean curvature at the nodes [1/m], shape (S, V); positive on a dome seen from +z."""
        return surface.mean_curvature(self.positions, self.mesh.triangles)

    @cached_property
    def gaussian_curvature(self) -> Floats:
        """Gaussian curvature at the nodes [1/m²], shape (S, V); zero on the rim."""
        return surface.gaussian_curvature(self.positions, self.mesh.triangles)

    @cached_property
    def aspect_ratio(self) -> Floats:
        """h/d of every state, shape (S,): height over the largest in-plane width."""
        return np.asarray(surface.aspect_ratio(self.positions))

    def aspect_ratios(self, width: surface.Width = "feret_max", azimuth: float = 0.0) -> Floats:
        """h/d of every state for another width d, shape (S,); see `surface.in_plane_width`.

        Raises:
            InputError: there is no such width.
        """
        return np.asarray(surface.aspect_ratio(self.positions, width, azimuth))
