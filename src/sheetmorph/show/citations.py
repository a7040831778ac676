"""Whose ideas a result rests on: references by model, option and solver used."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class Citation:
    """One reference.

    Attributes:
        key: short name, unique.
        authors: family names, with initials where known.
        title: of the article, book or program.
        source: where and when it appeared; empty when not known for sure.
        used_for: what this project takes from it.
    """

    key: str
    authors: str
    title: str
    source: str
    used_for: str


_ALL = (
    Citation(
        "zhang",
        "Y. Zhang, A. Alon, M. K. Jawed",
        "Emergent morphogenesis via planar fabrication enabled by a reduced model of composites",
        "",
        "the published model: one layer of nodes for a film with a pattern on it",
    ),
    Citation(
        "grinspun2003",
        "E. Grinspun, A. N. Hirani, M. Desbrun, P. Schröder",
        "Discrete shells",
        "ACM SIGGRAPH/Eurographics Symposium on Computer Animation, 2003, 62–67",
        "bending energy of hinges",
    ),
    Citation(
        "seung1988",
        "H. S. Seung, D. R. Nelson",
        "Defects in flexible membranes with crystalline order",
        "Physical Review A 38, 1988, 1005–1018",
        "stiffness of edges and hinges from the moduli",
    ),
    Citation(
        "tamstorf2013",
        "R. Tamstorf, E. Grinspun",
        "Discrete bending forces and their Jacobians",
        "Graphical Models 75, 2013, 362–370",
        "derivatives of the dihedral angle",
    ),
    Citation(
        "timoshenko1925",
        "S. Timoshenko",
        "Analysis of bi-metal thermostats",
        "Journal of the Optical Society of America 11, 1925, 233–255",
        "curvature of two layers that shrink differently",
    ),
    Citation(
        "vanrees2017",
        "W. M. van Rees, E. Vouga, L. Mahadevan",
        "Growth patterns for shape-shifting elastic bilayers",
        "Proceedings of the National Academy of Sciences 114, 2017, 11597–11602",
        "bilayers as one surface with a natural curvature",
    ),
    Citation(
        "chen2018",
        "H.-Y. Chen, A. Sastry, W. M. van Rees, E. Vouga",
        "Physical simulation of environmentally induced thin shell deformation",
        "ACM Transactions on Graphics 37, 2018",
        "discrete shells with a natural first and second form",
    ),
    Citation(
        "morley1971",
        "L. S. D. Morley",
        "The constant-moment plate-bending element",
        "Journal of Strain Analysis 6, 1971, 20–24",
        "directors on the edges, with which bending converges on any mesh",
    ),
    Citation(
        "grinspun2006",
        "E. Grinspun, Y. Gingold, J. Reisman, D. Zorin",
        "Computing discrete shape operators on general meshes",
        "Computer Graphics Forum 25, 2006, 547–556",
        "curvature of a triangle from normals at its edges",
    ),
    Citation(
        "nocedal2006",
        "J. Nocedal, S. J. Wright",
        "Numerical Optimization, 2nd edition",
        "Springer, 2006",
        "Newton's method with a shifted Hessian and a line search",
    ),
    Citation(
        "schenk2004",
        "O. Schenk, K. Gärtner",
        "Solving unsymmetric sparse systems of linear equations with PARDISO",
        "Future Generation Computer Systems 20, 2004, 475–487",
        "factorisation of the Hessian (Intel MKL)",
    ),
    Citation(
        "rslab",
        "M. Rother",
        "rslab: sparse direct solver",
        "Python package",
        "factorisation of the Hessian",
    ),
    Citation(
        "li2005",
        "X. S. Li",
        "An overview of SuperLU: algorithms, implementation, and user interface",
        "ACM Transactions on Mathematical Software 31, 2005, 302–325",
        "factorisation of the Hessian (SciPy)",
    ),
    Citation(
        "lam2015",
        "S. K. Lam, A. Pitrou, S. Seibert",
        "Numba: a LLVM-based Python JIT compiler",
        "Second Workshop on the LLVM Compiler Infrastructure in HPC, 2015",
        "compiled energies and derivatives",
    ),
    Citation(
        "fritsch1980",
        "F. N. Fritsch, R. E. Carlson",
        "Monotone piecewise cubic interpolation",
        "SIAM Journal on Numerical Analysis 17, 1980, 238–246",
        "frames between the states in the animation",
    ),
    Citation(
        "schroeder2006",
        "W. Schroeder, K. Martin, B. Lorensen",
        "The Visualization Toolkit, 4th edition",
        "Kitware, 2006",
        "pictures of the shape",
    ),
    Citation(
        "li2020",
        "M. Li, Z. Ferguson, T. Schneider, T. Langlois, D. Zorin, D. Panozzo, C. Jiang, "
        "D. M. Kaufman",
        "Incremental potential contact: intersection- and inversion-free, large-deformation "
        "dynamics",
        "ACM Transactions on Graphics 39, 2020",
        "barriers that keep the sheet off itself and off the table",
    ),
    Citation(
        "li2021",
        "M. Li, D. M. Kaufman, C. Jiang",
        "Codimensional incremental potential contact",
        "ACM Transactions on Graphics 40, 2021",
        "a least distance for the thickness, and collision detection for it",
    ),
    Citation(
        "hunter2007",
        "J. D. Hunter",
        "Matplotlib: a 2D graphics environment",
        "Computing in Science & Engineering 9, 2007, 90–95",
        "diagrams and labels",
    ),
)

_BY_MODEL = {
    "published": ("zhang", "grinspun2003", "seung1988", "tamstorf2013"),
    "laminate": ("morley1971", "grinspun2006", "timoshenko1925", "vanrees2017", "chen2018"),
}
_BY_SOLVER = {"mkl": "schenk2004", "pardiso": "schenk2004", "rslab": "rslab", "scipy": "li2005"}
_ALWAYS = ("nocedal2006", "lam2015", "fritsch1980", "hunter2007")


def references(summary: Mapping[str, Any]) -> list[Citation]:
    """References of what a run used.

    Args:
        summary: the numbers of a result; of these, `model` ("published", "laminate"),
            `solver` ("mkl", "rslab", "scipy") and `renderer` ("vtk", "drawn") are looked at.

    Returns:
        The references, the model's first. Names not known add nothing.
    """
    wanted = {*_ALWAYS, *_BY_MODEL.get(str(summary.get("model", "")), ())}
    solver = str(summary.get("solver", "")).lower()
    wanted |= {key for name, key in _BY_SOLVER.items() if name in solver}
    if "self_contact" in summary:
        wanted |= {"li2020", "li2021"}
    elif "table" in summary:
        wanted.add("li2020")
    if summary.get("renderer") == "vtk":
        wanted.add("schroeder2006")
    return [citation for citation in _ALL if citation.key in wanted]
