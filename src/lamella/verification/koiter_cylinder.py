"""Small deflections of isotropic circular cylinders on rigid diaphragms: solutions of Koiter's theory in series.

With s around, z along, and displacements v around, u along, w outwards, Koiter's linear strains (1960) of a cylinder are

    eps = (v_s + w/R, u_z, u_s + v_z),      kap = (w_ss - 2 v_s/R - w/R^2, w_zz, 2 (w_sz - v_z/R)),

the linear parts of (g - G)/2 and b - B with g and b the metric and the curvature of the deformed surface. The energy per area is
half of eps.A eps + kap.D kap. Diaphragms at z = 0 and L hold v and w and are met by w, v ~ sin(k z), u ~ cos(k z), k = m pi / L.
"""

from __future__ import annotations

import numpy as np
from numpy.polynomial import Chebyshev
from numpy.polynomial.legendre import leggauss

from lamella.material.isotropic import Isotropic
from lamella.material.laminate import Laminate

TERMS = 600
"""Terms of the double series in each direction."""


def pinched_cylinder(material: Isotropic, radius: float, length: float, h: float, force: float) -> float:
    """Inward displacement [m] under two opposite forces [N] at half the length: a double Fourier series.

    With c = cos(n s/R), w = W c sin(kz), v = V sin(n s/R) sin(kz), u = U c cos(kz), each pair of an odd m and an even n has a
    stiffness of its own for (U, V, W). What is left out of the series is taken from half as many terms, a quarter of whose
    remainder it is.
    """
    stiffness = Laminate(material, thickness=h).stiffness
    m, n = np.meshgrid(np.arange(1, 2 * TERMS, 2), np.arange(0, 2 * TERMS, 2), indexing="ij")
    k, j, zero = m * np.pi / length, n / radius, np.zeros(m.shape)
    one = np.ones(m.shape)
    strains = np.array(  # rows: strains, columns: U, V, W
        [
            [zero, j, one / radius],
            [-k, zero, zero],
            [-j, k, zero],
            [zero, -2 * j / radius, -(j**2) - one / radius**2],
            [zero, zero, -(k**2)],
            [zero, -2 * k / radius, -2 * j * k],
        ]
    )
    K = np.einsum("aimn,ab,bjmn->mnij", strains, stiffness, strains)
    area = np.pi * radius * (1 + (n == 0)) * length / 2
    K[:, 0, 1, 1] = 1.0  # no V with n = 0
    load = np.zeros((*m.shape, 3, 1))
    load[..., 2, 0] = 2 * force * np.sin(m * np.pi / 2) / area
    terms = np.linalg.solve(K, load)[..., 2, 0] * np.sin(m * np.pi / 2)
    whole, half = float(terms.sum()), float(terms[: TERMS // 2, : TERMS // 2].sum())
    return whole + (whole - half) / 3


def roof_under_weight(
    material: Isotropic, radius: float, length: float, h: float, half_angle: float, weight: float, degree: int = 24
) -> float:
    """Downward displacement [m] of the middle of a free edge under a weight per area [N/m^2]: a series along, polynomials around.

    For each odd m, even polynomials of s for u and w and odd ones for v, s = 0 at the crown, minimise the energy; free edges are
    natural boundary conditions. Terms of the series fall with m^-5 or faster; those up to 39 are taken.
    """
    stiffness = Laminate(material, thickness=h).stiffness
    x, weights = leggauss(2 * degree)
    x, ds, arc = (x + 1) / 2, weights / 2 * radius * half_angle, radius * half_angle
    even, odd = ([Chebyshev.basis(p) for p in range(first, degree + 1, 2)] for first in (0, 1))
    f, f_s, f_ss = (np.array([p.deriv(d)(x) for p in even]) / arc**d for d in range(3))
    g, g_s = (np.array([p.deriv(d)(x) for p in odd]) / arc**d for d in range(2))
    edge = np.concatenate(
        [np.zeros(len(even)), [p(1.0) * np.sin(half_angle) for p in odd], [-p(1.0) * np.cos(half_angle) for p in even]]
    )
    down = np.concatenate([np.zeros_like(f), g * np.sin(half_angle * x), -f * np.cos(half_angle * x)])
    none, nothing, sag = np.zeros_like(f), np.zeros_like(g), 0.0
    for m in range(1, 40, 2):
        k = m * np.pi / length
        u = (none, -k * f, f_s, none, none, none)
        v = (g_s, nothing, k * g, -2 * g_s / radius, nothing, -2 * k * g / radius)
        w = (f / radius, none, none, f_ss - f / radius**2, -(k**2) * f, 2 * k * f_s)
        strains = np.concatenate([u, v, w], axis=1)
        K = np.einsum("aix,ab,bjx,x->ij", strains, stiffness, strains, ds) * length / 2
        load = weight * 4 / (m * np.pi) * down @ ds * length / 2
        sag += float(edge @ np.linalg.solve(K, load)) * np.sin(m * np.pi / 2)
    return sag
