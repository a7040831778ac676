"""Local energies, gradients and Hessians of layered triangles, compiled.

A triangle has corners 0, 1, 2; side i lies opposite corner i and runs a → b with a = i + 1 and
b = i + 2 (modulo 3), c is corner i, d the node beyond the side. Unit vectors: u along the side,
n normal of the triangle, m = n × u inward; beyond the side n', m' and altitude h'. s and s' are
the feet of the altitudes as fractions of the side, L its length.

The dihedral angle θ of a side changes by dθ = −(n·w)/h − (n'·w')/h', the altitude by dh = m·w,
with w = dc − (1 − s) da − s db, w' likewise, and δ = db − da. With α = k θ + σ ψ + const
(k is 0 or 1, σ ψ the turn of the side's director, see `Patch`)::

    ½ dβ  = α (m·w) − k (n·w) − k (h/h') (n'·w') + σ h dψ
    ½ d²β = α [(n·w)²/h − 2 (u·w)(m·δ)/L − h (m·δ)²/L²]
          + k [2 (u·w)(n·δ)/L + h (m·δ)(n·δ)/L²] − 2 (k/h') (m·w)(n'·w')
          + k h [2 (m'·w')(n'·w')/h'² + 2 (u·w')(n'·δ)/(L h') + (m'·δ)(n'·δ)/L²]
          + 2 σ (m·w) dψ.

A side on the rim whose normal is prescribed has a flap in the place of the triangle beyond: a
vector f from its middle. Then d = (a + b)/2 + f, whose changes w' takes from a and b.
"""

from __future__ import annotations

import math

import numpy as np

from sheetmorph.core.compiled import kernel


@kernel
def laminate_local(  # type: ignore[no-untyped-def]
    x,
    stencil,
    directors,
    share,
    turn,
    lean,
    flap,
    stiffness,
    natural,
    floor,
    start,
    stop,
    order,
    energy,
    grad,
    hess,
):
    """Write the local quantities of triangles start … stop − 1, see `evaluate_elements`.

    Seven local nodes: the corners, the nodes beyond the sides, and the three directors.

    Args:
        x: rows of three degrees of freedom [m].
        stencil: shape (T, 6).
        directors: degrees of freedom of the directors, shape (T, 3).
        share: k of each side, 0 or 1, shape (T, 3).
        turn: σ over the director length [1/m], shape (T, 3).
        lean: α where ψ and θ are zero [rad], shape (T, 3).
        flap: f of each side that has one [m], shape (T, 3, 3).
        stiffness: M, shape (T, 6, 6).
        natural: p̄, shape (T, 6).
        floor: w [J], shape (T,).
    """
    side = np.empty((3, 3))
    own = np.empty((6, 3, 3))
    beyond = np.empty((3, 3))
    by_turn = np.empty(3)
    measure = np.empty(6)
    force = np.empty(6)
    frame = np.empty((3, 4, 3))
    number = np.empty((3, 8))
    pulled = np.empty((6, 3, 3))
    tensor = np.empty((6, 3, 3))
    for i in range(start, stop):
        k = i - start
        nx, ny, nz = _measure(
            x, stencil, directors, share, turn, lean, flap, i, side, frame, number, measure
        )
        total = floor[i]
        for p in range(6):
            value = 0.0
            for q in range(6):
                value += stiffness[i, p, q] * (measure[q] - natural[i, q])
            force[p] = value
            total += 0.5 * value * (measure[p] - natural[i, p])
        energy[k] = total
        if order < 1:
            continue

        for j in range(3):
            a, b = (j + 1) % 3, (j + 2) % 3
            h, s, part, alpha = number[j, 1], number[j, 2], number[j, 3], number[j, 6]
            by_turn[j] = 2.0 * h * turn[i, j]
            across, past, flapped = 0.0, 0.0, 0.0
            if part != 0.0:
                across = -2.0 * part * h / number[j, 4]
                past, flapped = number[j, 5], number[j, 7]
            wa, wb = past - 1.0 + 0.5 * flapped, 0.5 * flapped - past
            normal = (nx, ny, nz)
            for c in range(3):
                own[j, j, c] = 0.0
                own[j, a, c] = -2.0 * side[j, c]
                own[j, b, c] = 2.0 * side[j, c]
                w = 2.0 * (alpha * frame[j, 1, c] - part * normal[c])
                w2 = across * frame[j, 3, c] if part != 0.0 else 0.0
                own[3 + j, j, c] = w
                own[3 + j, a, c] = (s - 1.0) * w + wa * w2
                own[3 + j, b, c] = -s * w + wb * w2
                beyond[j, c] = (1.0 - flapped) * w2
        for p in range(3):
            for c in range(3):
                value = 0.0
                for q in range(6):
                    value += force[q] * own[q, p, c]
                grad[k, p, c] = value
                grad[k, 3 + p, c] = force[3 + p] * beyond[p, c]
            grad[k, 6, p] = force[3 + p] * by_turn[p]
        if order < 2:
            continue
        _products(hess, k, i, stiffness, own, beyond, by_turn, pulled)
        for j in range(3):
            _length_hessian(hess, k, force[j], j, order)
        if order == 3:
            continue
        for j in range(3):
            _bending_hessian(hess, k, j, 2.0 * force[3 + j], number, frame, (nx, ny, nz), tensor)
            for c in range(3):
                value = 2.0 * force[3 + j] * turn[i, j] * frame[j, 1, c]
                s = number[j, 2]
                hess[k, _pair(j, 6), c, j] += value
                hess[k, _pair((j + 1) % 3, 6), c, j] += (s - 1.0) * value
                hess[k, _pair((j + 2) % 3, 6), c, j] -= s * value


@kernel
def _pair(p, q):  # type: ignore[no-untyped-def]
    """Number of the pair of local nodes p ≤ q of seven."""
    return 7 * p - p * (p - 1) // 2 + q - p


@kernel
def _products(hess, k, i, stiffness, own, beyond, by_turn, pulled):  # type: ignore[no-untyped-def]
    """Write Σ M_pq ∇p ∇qᵀ into all blocks: the part without second derivatives."""
    for p in range(6):
        for node in range(3):
            for c in range(3):
                value = 0.0
                for q in range(6):
                    value += stiffness[i, p, q] * own[q, node, c]
                pulled[p, node, c] = value
    for p in range(3):
        for q in range(p, 3):
            block = _pair(p, q)
            for r in range(3):
                for c in range(3):
                    value = 0.0
                    for m in range(6):
                        value += own[m, p, r] * pulled[m, q, c]
                    hess[k, block, r, c] = value
        for j in range(3):
            block, last = _pair(p, 3 + j), _pair(p, 6)
            for r in range(3):
                value = pulled[3 + j, p, r]
                for c in range(3):
                    hess[k, block, r, c] = value * beyond[j, c]
                hess[k, last, r, j] = value * by_turn[j]
    for g in range(3):
        last = _pair(3 + g, 6)
        for j in range(3):
            m = stiffness[i, 3 + g, 3 + j]
            if j >= g:
                block = _pair(3 + g, 3 + j)
                for r in range(3):
                    for c in range(3):
                        hess[k, block, r, c] = m * beyond[g, r] * beyond[j, c]
            for r in range(3):
                hess[k, last, r, j] = m * beyond[g, r] * by_turn[j]
            hess[k, 27, g, j] = m * by_turn[g] * by_turn[j]


@kernel
def _length_hessian(hess, k, force, j, order):  # type: ignore[no-untyped-def]
    """Add force · ∇²(l²) of side j; at order 3 only where the side is in tension."""
    if order == 3 and force < 0.0:
        return
    a, b = (j + 1) % 3, (j + 2) % 3
    across = _pair(min(a, b), max(a, b))
    for c in range(3):
        hess[k, _pair(a, a), c, c] += 2.0 * force
        hess[k, _pair(b, b), c, c] += 2.0 * force
        hess[k, across, c, c] -= 2.0 * force


@kernel
def _bending_hessian(hess, k, j, factor, number, frame, n, t):  # type: ignore[no-untyped-def]
    """Add factor · ½ ∇²β of side j, but for the part with its director; t is scratch."""
    length, h, s, part, alpha = number[j, 0], number[j, 1], number[j, 2], number[j, 3], number[j, 6]
    ww = factor * alpha / h
    wd_m, wd_n = -factor * alpha / length, factor * part / length
    dd_m, dd_n = -factor * alpha * h / length**2, 0.5 * factor * part * h / length**2
    for r in range(3):
        ur, mr = frame[j, 0, r], frame[j, 1, r]
        for c in range(3):
            mc = frame[j, 1, c]
            t[0, r, c] = ww * n[r] * n[c]
            t[1, r, c] = ur * (wd_m * mc + wd_n * n[c])
            t[2, r, c] = dd_m * mr * mc + dd_n * (mr * n[c] + n[r] * mc)
    own = (j, (j + 1) % 3, (j + 2) % 3, 3 + j)
    w = (1.0, s - 1.0, -s, 0.0)
    delta = (0.0, -1.0, 1.0, 0.0)
    for first in range(3):
        for second in range(first, 3):
            p, q = first, second
            if own[p] > own[q]:
                p, q = q, p
            block = _pair(own[p], own[q])
            a0, a1, a2, a3 = w[p] * w[q], w[p] * delta[q], delta[p] * w[q], delta[p] * delta[q]
            for r in range(3):
                for c in range(3):
                    hess[k, block, r, c] += (
                        a0 * t[0, r, c] + a1 * t[1, r, c] + a2 * t[1, c, r] + a3 * t[2, r, c]
                    )
    if part == 0.0:
        return
    h2, past, flapped = number[j, 4], number[j, 5], number[j, 7]
    w2 = (0.0, past - 1.0 + 0.5 * flapped, 0.5 * flapped - past, 1.0 - flapped)
    w2w2 = factor * part * h / h2**2
    w2d = factor * part * h / (length * h2)
    mixed = -factor * part / h2
    for r in range(3):
        ur, mr, m2r, n2r = frame[j, 0, r], frame[j, 1, r], frame[j, 2, r], frame[j, 3, r]
        for c in range(3):
            n2c = frame[j, 3, c]
            both = m2r * n2c + n2r * frame[j, 2, c]
            t[2, r, c] = dd_n * both
            t[3, r, c] = w2w2 * both
            t[4, r, c] = w2d * ur * n2c
            t[5, r, c] = mixed * mr * n2c
    last = 3 if flapped else 4
    for first in range(last):
        for second in range(first, last):
            p, q = first, second
            if own[p] > own[q]:
                p, q = q, p
            block = _pair(own[p], own[q])
            a3, b0, b1, b2 = delta[p] * delta[q], w2[p] * w2[q], w2[p] * delta[q], delta[p] * w2[q]
            b3, b4 = w[p] * w2[q], w2[p] * w[q]
            for r in range(3):
                for c in range(3):
                    hess[k, block, r, c] += (
                        a3 * t[2, r, c]
                        + b0 * t[3, r, c]
                        + b1 * t[4, r, c]
                        + b2 * t[4, c, r]
                        + b3 * t[5, r, c]
                        + b4 * t[5, c, r]
                    )


@kernel
def _measure(x, stencil, directors, share, turn, lean, flap, i, side, frame, number, measure):  # type: ignore[no-untyped-def]
    """Sides, unit vectors (u, m, m', n'), numbers (L, h, s, k, h', s', α, flap) and measures p.

    Returns the unit normal of triangle i.
    """
    v0, v1, v2 = stencil[i, 0], stencil[i, 1], stencil[i, 2]
    for c in range(3):
        side[0, c] = x[v2, c] - x[v1, c]
        side[1, c] = x[v0, c] - x[v2, c]
        side[2, c] = x[v1, c] - x[v0, c]
    nx = side[2, 1] * side[0, 2] - side[2, 2] * side[0, 1]
    ny = side[2, 2] * side[0, 0] - side[2, 0] * side[0, 2]
    nz = side[2, 0] * side[0, 1] - side[2, 1] * side[0, 0]
    double = math.sqrt(nx * nx + ny * ny + nz * nz)
    nx, ny, nz = nx / double, ny / double, nz / double
    for j in range(3):
        l2 = side[j, 0] ** 2 + side[j, 1] ** 2 + side[j, 2] ** 2
        measure[j] = l2
        length = math.sqrt(l2)
        ux, uy, uz = side[j, 0] / length, side[j, 1] / length, side[j, 2] / length
        mx, my, mz = ny * uz - nz * uy, nz * ux - nx * uz, nx * uy - ny * ux
        h = double / length
        ahead = (j + 1) % 3  # the side from b to c
        s = 1.0 + (side[ahead, 0] * ux + side[ahead, 1] * uy + side[ahead, 2] * uz) / length
        number[j, 0], number[j, 1], number[j, 2] = length, h, s
        frame[j, 0, 0], frame[j, 0, 1], frame[j, 0, 2] = ux, uy, uz
        frame[j, 1, 0], frame[j, 1, 1], frame[j, 1, 2] = mx, my, mz
        part = share[i, j]
        number[j, 3] = part
        alpha = lean[i, j] + turn[i, j] * x[directors[i, j] // 3, directors[i, j] % 3]
        if part != 0.0:
            a = stencil[i, (j + 1) % 3]
            flapped = stencil[i, 3 + j] == stencil[i, j]
            number[j, 7] = 1.0 if flapped else 0.0
            if flapped:
                dx = 0.5 * side[j, 0] + flap[i, j, 0]
                dy = 0.5 * side[j, 1] + flap[i, j, 1]
                dz = 0.5 * side[j, 2] + flap[i, j, 2]
            else:
                d = stencil[i, 3 + j]
                dx, dy, dz = x[d, 0] - x[a, 0], x[d, 1] - x[a, 1], x[d, 2] - x[a, 2]
            t = dx * ux + dy * uy + dz * uz
            dx, dy, dz = dx - t * ux, dy - t * uy, dz - t * uz
            h2 = math.sqrt(dx * dx + dy * dy + dz * dz)
            dx, dy, dz = dx / h2, dy / h2, dz / h2
            n2x, n2y, n2z = dy * uz - dz * uy, dz * ux - dx * uz, dx * uy - dy * ux
            cosine = nx * n2x + ny * n2y + nz * n2z
            sine = -(nx * dx + ny * dy + nz * dz)
            theta = math.atan2(sine, cosine)
            alpha += part * theta
            frame[j, 2, 0], frame[j, 2, 1], frame[j, 2, 2] = dx, dy, dz
            frame[j, 3, 0], frame[j, 3, 1], frame[j, 3, 2] = n2x, n2y, n2z
            number[j, 4], number[j, 5] = h2, t / length
        number[j, 6] = alpha
        measure[3 + j] = 2.0 * h * alpha
    return nx, ny, nz


@kernel
def measure_shapes(x, stencil, directors, share, turn, lean, flap, measures):  # type: ignore[no-untyped-def]
    """Write the six measures p of every triangle, shape (T, 6); arguments as `laminate_local`."""
    side = np.empty((3, 3))
    frame = np.empty((3, 4, 3))
    number = np.empty((3, 8))
    for i in range(len(stencil)):
        _measure(
            x, stencil, directors, share, turn, lean, flap, i, side, frame, number, measures[i]
        )
