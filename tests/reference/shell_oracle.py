"""Slow and plain strain energy of a Plate48 element, written apart from the package: physical coordinates, tensors, complex numbers.

Forces come from the energy by complex step, which has no cancellation; tangents by a complex step in one direction and a Richardson
difference in the other.
"""

from __future__ import annotations

import numpy as np

NODES = ((0, 0), (1, 0), (1, 1), (0, 1))


def hermite(s, length):
    """Cubics with unit value and slope (by s * length) at 0 and 1: rows value, d, d2 by the physical coordinate."""
    conditions = np.array([[1, 0, 0, 0], [0, 1, 0, 0], [1, 1, 1, 1], [0, 1, 2, 3]], float)
    coefficients = np.linalg.inv(conditions) @ np.diag([1, length, 1, length])
    powers = np.array([[1, s, s**2, s**3], [0, 1, 2 * s, 3 * s**2], [0, 0, 2, 6 * s]], float)
    return (powers @ coefficients) / np.array([1, length, length**2])[:, None]


def surface(e, lengths, xi, eta):
    """Derivatives {(p, q): vector} by physical x, y of the surface with the unscaled coordinates e (48,)."""
    in_x, in_y = hermite(xi, lengths[0]), hermite(eta, lengths[1])
    vectors = np.asarray(e).reshape(4, 4, 3)
    out = {}
    for p in range(3):
        for q in range(3):
            value = np.zeros(3, vectors.dtype)
            for node, (i, j) in enumerate(NODES):
                for k, (dx, dy) in enumerate([(0, 0), (1, 0), (0, 1), (1, 1)]):
                    value = value + in_x[p, 2 * i + dx] * in_y[q, 2 * j + dy] * vectors[node, k]
            out[p, q] = value
    return out


def forms(d):
    """First and second fundamental forms and the normal vector's length; products without conjugation."""
    n = np.cross(d[1, 0], d[0, 1])
    length = np.sqrt(n @ n)
    n0 = n / length
    a = np.array([[d[1, 0] @ d[1, 0], d[1, 0] @ d[0, 1]], [d[1, 0] @ d[0, 1], d[0, 1] @ d[0, 1]]])
    b = np.array([[d[2, 0] @ n0, d[1, 1] @ n0], [d[1, 1] @ n0, d[0, 2] @ n0]])
    return a, b, length, n0


def local_strains(e, reference, lengths, xi, eta):
    """(eps, kap) with doubled shear and twist in the local frame, and the reference area factor."""
    d, d0 = surface(e, lengths, xi, eta), surface(reference, lengths, xi, eta)
    (a, b, _, _), (a0, b0, area, normal) = forms(d), forms(d0)
    first = d0[1, 0] / np.linalg.norm(d0[1, 0])
    axes = np.stack([first, np.cross(normal, first)])
    inverse = np.linalg.inv(np.stack([d0[1, 0], d0[0, 1]]) @ axes.T)
    eps, kap = (inverse @ tensor @ inverse.T for tensor in (0.5 * (a - a0), b - b0))
    return np.array([eps[0, 0], eps[1, 1], 2 * eps[0, 1], kap[0, 0], kap[1, 1], 2 * kap[0, 1]]), area


def energy(e, reference, lengths, stiffness, n_gauss=4):
    """Strain energy of one element; complex coordinates are allowed."""
    points, weights = np.polynomial.legendre.leggauss(n_gauss)
    total = 0.0
    for xi, w_xi in zip(0.5 * (points + 1), 0.5 * weights, strict=True):
        for eta, w_eta in zip(0.5 * (points + 1), 0.5 * weights, strict=True):
            s, area = local_strains(e, reference, lengths, xi, eta)
            total = total + 0.5 * (s @ stiffness @ s) * area * w_xi * w_eta * lengths[0] * lengths[1]
    return total


def force(e, reference, lengths, stiffness, n_gauss=4, step=1e-30):
    """dW/de by complex step, exact to round-off."""
    out = np.empty(48)
    for k in range(48):
        moved = np.array(e, complex)
        moved[k] += 1j * step
        out[k] = energy(moved, reference, lengths, stiffness, n_gauss).imag / step
    return out


def directional_derivative(function, direction, size):
    """d function(h direction)/dh at 0 by central differences of order eight; ``size`` is the step h."""
    weights = {1: 4 / 5, 2: -1 / 5, 3: 4 / 105, 4: -1 / 280}
    return sum(w * (function(k * size * direction) - function(-k * size * direction)) for k, w in weights.items()) / size
