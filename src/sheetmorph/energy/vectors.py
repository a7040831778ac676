"""Vectors of three numbers inside kernels."""

from __future__ import annotations

from sheetmorph.core.compiled import kernel


@kernel
def normal(x, a, b, c, n):  # type: ignore[no-untyped-def]
    """Write the normal of a triangle of nodes, twice its area long; returns its squared length."""
    for r in range(3):
        p, q = (r + 1) % 3, (r + 2) % 3
        n[r] = (x[b, p] - x[a, p]) * (x[c, q] - x[a, q])
        n[r] -= (x[b, q] - x[a, q]) * (x[c, p] - x[a, p])
    return dot(n, n)


@kernel
def dot(v, w):  # type: ignore[no-untyped-def]
    """Scalar product."""
    return v[0] * w[0] + v[1] * w[1] + v[2] * w[2]


@kernel
def cross(v, w):  # type: ignore[no-untyped-def]
    """Vector product."""
    return (
        v[1] * w[2] - v[2] * w[1],
        v[2] * w[0] - v[0] * w[2],
        v[0] * w[1] - v[1] * w[0],
    )
