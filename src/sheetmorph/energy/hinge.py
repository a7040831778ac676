"""Bending of the hinges, coupled to the mismatch of the strains around them."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from sheetmorph.core.compiled import kernel
from sheetmorph.energy.term import Kernel
from sheetmorph.geometry.mesh import Floats, Ints, SheetMesh


@dataclass(frozen=True, eq=False)
class CoupledHinge:
    """½ k_b (θ − c Δ)² for every hinge (a, b, c, d), with
    Δ = (e − t·eth)_ac − (e − t·eth)_ad + (e − t·eth)_bc − (e − t·eth)_bd.

    θ is the signed angle between the normals of abc and adb about a→b, zero when flat.

    Attributes:
        stencil: nodes (a, b, c, d), shape (n, 4).
        rest_length: reference lengths of ac, ad, bc, bd [m], shape (n, 4).
        stiffness: k_b [J], shape (n,).
        coupling: c = β l0 of the paper, without unit, shape (n,).
        eigenstrain_mismatch: Δ of the eigenstrains eth at full actuation, shape (n,).
        ramp: fraction t of the actuation.
    """

    stencil: Ints
    rest_length: Floats
    stiffness: Floats
    coupling: Floats
    eigenstrain_mismatch: Floats
    ramp: float = 0.0

    name = "bend"
    reference = (
        "Zhang, Alon, Jawed, Emergent morphogenesis via planar fabrication, eq. (bilayer_energy), "
        "second sum; Grinspun et al., Discrete shells, 2003"
    )
    linear = False

    def at(self, ramp: float, load: float) -> CoupledHinge:
        """The same hinges at a fraction of the actuation."""
        return replace(self, ramp=ramp)

    @classmethod
    def specimen(cls, mesh: SheetMesh, rng: np.random.Generator) -> CoupledHinge:
        """Every hinge, with random stiffness, coupling and eigenstrain."""
        count = len(mesh.hinges)
        return cls(
            mesh.hinges,
            mesh.edge_lengths[mesh.hinge_edges[:, 1:]],
            rng.uniform(0.1, 1.0, count),
            rng.uniform(-1.0, 1.0, count),
            rng.uniform(-0.5, 0.5, count),
        )

    def local_kernel(self) -> Kernel:
        """Kernel and parameters; see `sheetmorph.energy.term.Term.local_kernel`."""
        lengths, stiffness, coupling = self.rest_length, self.stiffness, self.coupling
        parameters = (lengths, stiffness, coupling, self.eigenstrain_mismatch, self.ramp)
        return _coupled_hinge, (self.stencil, *parameters)


@kernel
def _coupled_hinge(  # type: ignore[no-untyped-def]
    x,
    stencil,
    rest_length,
    stiffness,
    coupling,
    eigen,
    ramp,
    start,
    stop,
    order,
    energy,
    grad,
    hess,
):
    """Angle and derivatives by the altitudes of the two triangles.

    Per side, with unit edge vector u = (b − a)/L, unit normal n, unit in-plane direction m
    from the edge to the opposite node, altitude h and foot of the altitude at the fraction s
    of a→b:
        ∇θ at the opposite node = σ n / h,   at a: −(1 − s) of it,   at b: −s of it,
    with σ = −1 for the sign convention of the class (lifting c or d off a flat sheet makes θ
    negative). The Hessian follows from the changes of h, n and s with the nodes, where
    w = d(opposite) − (1 − s) da − s db:
        dh = m·w,   dn = −m (n·w)/h − u (n·(db − da))/L,
        ds/da = −(1 − s) u/L − h m/L²,   ds/db = −s u/L + h m/L²,   ds/d(opposite) = u/L.
    """
    g = np.empty((4, 3))
    for i in range(start, stop):
        k = i - start
        a, b = stencil[i, 0], stencil[i, 1]
        c, d = stencil[i, 2], stencil[i, 3]
        ax, ay, az = x[a, 0], x[a, 1], x[a, 2]
        bx, by, bz = x[b, 0], x[b, 1], x[b, 2]
        cx, cy, cz = x[c, 0], x[c, 1], x[c, 2]
        dx, dy, dz = x[d, 0], x[d, 1], x[d, 2]
        ux, uy, uz = bx - ax, by - ay, bz - az
        length2 = ux * ux + uy * uy + uz * uz
        inv_length = 1.0 / math.sqrt(length2)
        # Sides of the two triangles, as vectors towards the opposite nodes.
        acx, acy, acz = cx - ax, cy - ay, cz - az
        adx, ady, adz = dx - ax, dy - ay, dz - az
        bcx, bcy, bcz = cx - bx, cy - by, cz - bz
        bdx, bdy, bdz = dx - bx, dy - by, dz - bz
        s1 = (acx * ux + acy * uy + acz * uz) / length2
        s2 = (adx * ux + ady * uy + adz * uz) / length2
        # Altitudes h m, from the foot on the edge to the opposite node.
        m1x, m1y, m1z = acx - s1 * ux, acy - s1 * uy, acz - s1 * uz
        m2x, m2y, m2z = adx - s2 * ux, ady - s2 * uy, adz - s2 * uz
        inv_h1 = 1.0 / math.sqrt(m1x * m1x + m1y * m1y + m1z * m1z)
        inv_h2 = 1.0 / math.sqrt(m2x * m2x + m2y * m2y + m2z * m2z)
        ux, uy, uz = ux * inv_length, uy * inv_length, uz * inv_length
        m1x, m1y, m1z = m1x * inv_h1, m1y * inv_h1, m1z * inv_h1
        m2x, m2y, m2z = m2x * inv_h2, m2y * inv_h2, m2z * inv_h2
        n1x, n1y, n1z = uy * m1z - uz * m1y, uz * m1x - ux * m1z, ux * m1y - uy * m1x
        n2x, n2y, n2z = m2y * uz - m2z * uy, m2z * ux - m2x * uz, m2x * uy - m2y * ux
        cosine = n1x * n2x + n1y * n2y + n1z * n2z
        # (n1 × n2)·u = n1·(n2 × u) = −n1·m2, which saves a cross product.
        sine = -(n1x * m2x + n1y * m2y + n1z * m2z)
        theta = math.atan2(sine, cosine)

        l_ac = math.sqrt(acx * acx + acy * acy + acz * acz)
        l_ad = math.sqrt(adx * adx + ady * ady + adz * adz)
        l_bc = math.sqrt(bcx * bcx + bcy * bcy + bcz * bcz)
        l_bd = math.sqrt(bdx * bdx + bdy * bdy + bdz * bdz)
        r_ac, r_ad = rest_length[i, 0], rest_length[i, 1]
        r_bc, r_bd = rest_length[i, 2], rest_length[i, 3]
        beta = coupling[i]
        mismatch = (
            (l_ac - r_ac) / r_ac
            - (l_ad - r_ad) / r_ad
            + (l_bc - r_bc) / r_bc
            - (l_bd - r_bd) / r_bd
        ) - ramp * eigen[i]
        phi = theta - beta * mismatch
        kb = stiffness[i]
        energy[k] = 0.5 * kb * phi * phi
        if order < 1:
            continue

        # Gradient of φ. p_xy = β ∇_y e_xy, so that φ loses p_ac and p_bc and gains p_ad, p_bd.
        f_ac, f_ad = beta / (r_ac * l_ac), beta / (r_ad * l_ad)
        f_bc, f_bd = beta / (r_bc * l_bc), beta / (r_bd * l_bd)
        s1c, s2c = 1.0 - s1, 1.0 - s2
        p1, p2 = -inv_h1, -inv_h2
        g[0, 0] = -s1c * p1 * n1x - s2c * p2 * n2x + f_ac * acx - f_ad * adx
        g[0, 1] = -s1c * p1 * n1y - s2c * p2 * n2y + f_ac * acy - f_ad * ady
        g[0, 2] = -s1c * p1 * n1z - s2c * p2 * n2z + f_ac * acz - f_ad * adz
        g[1, 0] = -s1 * p1 * n1x - s2 * p2 * n2x + f_bc * bcx - f_bd * bdx
        g[1, 1] = -s1 * p1 * n1y - s2 * p2 * n2y + f_bc * bcy - f_bd * bdy
        g[1, 2] = -s1 * p1 * n1z - s2 * p2 * n2z + f_bc * bcz - f_bd * bdz
        g[2, 0] = p1 * n1x - f_ac * acx - f_bc * bcx
        g[2, 1] = p1 * n1y - f_ac * acy - f_bc * bcy
        g[2, 2] = p1 * n1z - f_ac * acz - f_bc * bcz
        g[3, 0] = p2 * n2x + f_ad * adx + f_bd * bdx
        g[3, 1] = p2 * n2y + f_ad * ady + f_bd * bdy
        g[3, 2] = p2 * n2z + f_ad * adz + f_bd * bdz
        moment = kb * phi
        for p in range(4):
            for r in range(3):
                grad[k, p, r] = moment * g[p, r]
        if order < 2:
            continue
        outer_products(hess, k, kb, g)
        if order == 3:
            continue
        u = (ux, uy, uz)
        add_angle_hessian(
            hess, k, -moment, inv_length, inv_h1, s1, u, (n1x, n1y, n1z), (m1x, m1y, m1z), 2
        )
        add_angle_hessian(
            hess, k, -moment, inv_length, inv_h2, s2, u, (n2x, n2y, n2z), (m2x, m2y, m2z), 3
        )
        _strain_hessian(hess, k, -moment * f_ac, l_ac, acx, acy, acz, 0, 2, 7)
        _strain_hessian(hess, k, moment * f_ad, l_ad, adx, ady, adz, 0, 3, 9)
        _strain_hessian(hess, k, -moment * f_bc, l_bc, bcx, bcy, bcz, 4, 5, 7)
        _strain_hessian(hess, k, moment * f_bd, l_bd, bdx, bdy, bdz, 4, 6, 9)


@kernel
def outer_products(hess, k, factor, g):  # type: ignore[no-untyped-def]
    """Write factor · g_p g_qᵀ into the blocks of all pairs of four nodes."""
    pair = 0
    for p in range(4):
        for q in range(p, 4):
            for r in range(3):
                f = factor * g[p, r]
                for c in range(3):
                    hess[k, pair, r, c] = f * g[q, c]
            pair += 1


@kernel
def add_angle_hessian(hess, k, moment, inv_length, inv_h, s, u, n, m, node):  # type: ignore[no-untyped-def]
    """Add moment · ∇²θ of one side (σ = +1) to the blocks aa, ab, bb, a·, b·, ··."""
    o = 1.0 - s
    hh = moment * inv_h * inv_h
    lh = moment * inv_h * inv_length
    ll = moment * inv_length * inv_length
    to_a, to_b, own = node, 3 + node, 7 if node == 2 else 9
    for r in range(3):
        for c in range(3):
            nm = n[r] * m[c]
            un, nu = u[r] * n[c], n[r] * u[c]
            bend = hh * (nm + m[r] * n[c])
            twist = lh * nu
            hess[k, 0, r, c] -= o * o * bend + o * lh * (un + nu) + ll * nm
            hess[k, 1, r, c] -= s * o * bend - o * lh * un + s * twist - ll * nm
            hess[k, 4, r, c] -= s * s * bend - s * lh * (un + nu) + ll * nm
            hess[k, to_a, r, c] += o * bend + twist
            hess[k, to_b, r, c] += s * bend - twist
            hess[k, own, r, c] -= bend


@kernel
def _strain_hessian(hess, k, factor, length, vx, vy, vz, first, cross, last):  # type: ignore[no-untyped-def]
    """Add factor · (I − vvᵀ/l²) to two diagonal blocks and take it from their cross block."""
    w = factor / (length * length)
    v = (vx, vy, vz)
    for r in range(3):
        for c in range(3):
            value = -w * v[r] * v[c]
            if r == c:
                value += factor
            hess[k, first, r, c] += value
            hess[k, cross, r, c] -= value
            hess[k, last, r, c] += value
