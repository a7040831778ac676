"""The shapes that were found: numbers, states, files."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from sheetmorph import __version__
from sheetmorph.core.files import write_text
from sheetmorph.core.hdf5 import writing_hdf5
from sheetmorph.geometry import surface
from sheetmorph.geometry.mesh import Floats
from sheetmorph.study.result import Result

FORMAT = "sheetmorph branches"


@dataclass(frozen=True)
class Attempt:
    """What became of a seed.

    Attributes:
        seed: its name.
        kind: its kind, see `sheetmorph.branches.seeds.Seed`.
        status: how its path ended, see `sheetmorph.solve.path.Status`; or why its end is no
            branch.
        reached: fraction of the actuation that it reached.
        branch: number of the branch at which it ended, from 1; None where it did not arrive, or
            its end is left out.
        image: the map of the design that takes the branch to its shape, "" for none.
    """

    seed: str
    kind: str
    status: str
    reached: float
    branch: int | None = None
    image: str = ""


@dataclass(frozen=True, eq=False)
class Branch:
    """A shape at full actuation.

    Attributes:
        number: from 1, by energy.
        x: the state, shape (n,).
        positions: of the nodes [m], shape (V, 3).
        energy: with the actuation and without the perturbation load [J].
        negative: negative eigenvalues of the Hessian: 0 where stable.
        eigenvalue: the smallest [N/m³], see `sheetmorph.study.stability`.
        residual: largest residual force [N].
        guarded: in how many places guards hold it: folds and collapsing triangles of the mesh.
        positions_found: states of the first shape in each position, by the name of the map;
            "" is x itself.
    """

    number: int
    x: Floats
    positions: Floats
    energy: float
    negative: int
    eigenvalue: float
    residual: float
    guarded: int = 0
    positions_found: dict[str, Floats] = field(default_factory=dict)

    @property
    def stable(self) -> bool:
        """True for a minimum of the energy."""
        return self.negative == 0


@dataclass(frozen=True)
class Barrier:
    """What it takes to get from one shape to another.

    Attributes:
        first, second: numbers of the branches.
        image: position of the second, "" for the one that was found first.
        height: energy of the saddle over that of the first [J].
        back: the same over that of the second [J].
        negative: negative eigenvalues of the saddle: 1 where it is the top of a path that
            cannot be lowered nearby.
        converged: True where the saddle is an equilibrium.
        connects: True where the sheet falls from the saddle into the two shapes; where it does
            not, there are other shapes on the way.
    """

    first: int
    second: int
    image: str
    height: float
    back: float
    negative: int
    converged: bool
    connects: bool


@dataclass(frozen=True, eq=False)
class Branches:
    """All that a search has found.

    Attributes:
        result: the run of the design as it is.
        branches: the shapes, by energy.
        attempts: the seeds, in the order in which they were followed.
        bifurcations: ramp, negative eigenvalues before and beyond, of the places on the path
            without perturbation.
        followed: ramp up to which that path was followed.
        images: names of the maps of the design, the identity left out.
        barriers: between shapes, where they were asked for.
    """

    result: Result
    branches: tuple[Branch, ...]
    attempts: tuple[Attempt, ...]
    bifurcations: tuple[tuple[float, int, int], ...]
    followed: float
    images: tuple[str, ...]
    barriers: tuple[Barrier, ...] = field(default=())

    def with_barriers(self, barriers: Sequence[Barrier]) -> Branches:
        """The same with barriers."""
        return replace(self, barriers=tuple(barriers))

    def seeds_of(self, number: int) -> list[Attempt]:
        """The seeds that ended at a branch."""
        return [one for one in self.attempts if one.branch == number]

    def to_json(self) -> dict[str, Any]:
        """The content of `branches.json`."""
        lowest = self.branches[0].energy if self.branches else 0.0
        return {
            "format": FORMAT,
            "version": __version__,
            "name": self.result.design.name,
            "design_hash": self.result.design.hash,
            "eps_pre": self.result.design.eps_pre,
            "bifurcations": [
                {"actuation": ramp, "negative_before": before, "negative_beyond": beyond}
                for ramp, before, beyond in self.bifurcations
            ],
            "unperturbed_path_followed_to": self.followed,
            "symmetry": list(self.images),
            "branches": [
                {
                    "number": one.number,
                    "stable": one.stable,
                    "negative_eigenvalues": one.negative,
                    "smallest_eigenvalue_N_per_m3": one.eigenvalue,
                    "energy_J": one.energy,
                    "above_lowest_J": one.energy - lowest,
                    "residual_max_N": one.residual,
                    "places_held_by_guards": one.guarded,
                    "height_m": float(np.ptp(one.positions[:, 2])),
                    "aspect_ratio": float(surface.aspect_ratio(one.positions)),
                    "images": sorted({a.image for a in self.seeds_of(one.number)}),
                    "seeds": [a.seed for a in self.seeds_of(one.number)],
                }
                for one in self.branches
            ],
            "barriers": [
                {
                    "first": one.first,
                    "second": one.second,
                    "image": one.image,
                    "height_J": one.height,
                    "back_J": one.back,
                    "negative_eigenvalues": one.negative,
                    "converged": one.converged,
                    "connects": one.connects,
                }
                for one in self.barriers
            ],
            "attempts": [
                {
                    "seed": one.seed,
                    "kind": one.kind,
                    "status": one.status,
                    "actuation_reached": one.reached,
                    "branch": one.branch,
                    "image": one.image,
                }
                for one in self.attempts
            ],
        }


def write_json(found: Branches, path: Path) -> None:
    """Write `branches.json`.

    Raises:
        OutputError: it cannot be written.
    """
    text = json.dumps(found.to_json(), indent=2, ensure_ascii=False, allow_nan=False)
    write_text(path, text + "\n")


def write_states(found: Branches, path: Path) -> None:
    """Write the states as HDF5: `nodes`, `triangles`, `positions` (B, V, 3), `scalars`, `energy`,
    `negative`, `smallest_eigenvalue`, `guarded`, and the design.

    Raises:
        OutputError: it cannot be written.
    """
    mesh, branches = found.result.mesh, found.branches
    with writing_hdf5(path) as (file, _):
        file.attrs["format"] = FORMAT
        file.attrs["version"] = __version__
        file.attrs["design_hash"] = found.result.design.hash
        file.create_dataset("design", data=found.result.design.to_portable_toml())
        file.create_dataset("nodes", data=mesh.nodes)
        file.create_dataset("triangles", data=mesh.triangles)
        file.create_dataset("positions", data=np.array([one.positions for one in branches]))
        file.create_dataset(
            "scalars", data=np.array([one.x[mesh.nodes.size :] for one in branches])
        )
        file.create_dataset("energy", data=np.array([one.energy for one in branches]))
        file.create_dataset("guarded", data=np.array([one.guarded for one in branches]))
        file.create_dataset("negative", data=np.array([one.negative for one in branches]))
        values = np.array([one.eigenvalue for one in branches])
        file.create_dataset("smallest_eigenvalue", data=values)
