"""Plain strain energy of a Plate48 element, written apart from the package: physical coordinates, tensors, complex numbers.

Forces come from the energy by complex step, which has no cancellation; second derivatives by differences of these. Coordinates
may carry axes in front, (..., 48), for many states at once.
"""

from __future__ import annotations

from functools import cache

import numpy as np

NODES = ((0, 0), (1, 0), (1, 1), (0, 1))


def hermite(s, length):
    """Cubics with unit value and slope (by s * length) at 0 and 1: rows value, d, d2 by the physical coordinate."""
    conditions = np.array([[1, 0, 0, 0], [0, 1, 0, 0], [1, 1, 1, 1], [0, 1, 2, 3]], float)
    coefficients = np.linalg.inv(conditions) @ np.diag([1, length, 1, length])
    powers = np.array([[1, s, s**2, s**3], [0, 1, 2 * s, 3 * s**2], [0, 0, 2, 6 * s]], float)
    return (powers @ coefficients) / np.array([1, length, length**2])[:, None]


@cache
def shape(lengths, xi, eta):
    """Weights of the 16 unscaled vectors {(p, q): (16,)} in the derivatives by physical x (p times) and y (q times)."""
    in_x, in_y = hermite(xi, lengths[0]), hermite(eta, lengths[1])
    places = [(2 * i + dx, 2 * j + dy) for i, j in NODES for dx, dy in [(0, 0), (1, 0), (0, 1), (1, 1)]]
    return {(p, q): np.array([in_x[p, a] * in_y[q, b] for a, b in places]) for p in range(3) for q in range(3)}


def surface(e, lengths, xi, eta):
    """Derivatives {(p, q): vector} by physical x, y of the surface with the unscaled coordinates e (..., 48)."""
    vectors = np.asarray(e).reshape(*np.shape(e)[:-1], 16, 3)
    return {key: np.einsum("s,...sc->...c", weights, vectors) for key, weights in shape(lengths, xi, eta).items()}


def product(u, v):
    """Scalar product without conjugation."""
    return (u * v).sum(axis=-1)


def matrix(xx, xy, yy):
    """Symmetric 2 x 2 matrices."""
    return np.stack([np.stack([xx, xy], -1), np.stack([xy, yy], -1)], -2)


def forms(d):
    """First and second fundamental forms, the normal vector's length and the unit normal."""
    n = np.cross(d[1, 0], d[0, 1])
    length = np.sqrt(product(n, n))
    n0 = n / length[..., None]
    a = matrix(product(d[1, 0], d[1, 0]), product(d[1, 0], d[0, 1]), product(d[0, 1], d[0, 1]))
    b = matrix(product(d[2, 0], n0), product(d[1, 1], n0), product(d[0, 2], n0))
    return a, b, length, n0


def local_strains(e, reference, lengths, xi, eta, *, cubed=False):
    """(eps, kap) with doubled shear and twist in the local frame, shape (..., 6), and the reference area factor.

    With ``cubed`` the present curvature is divided by the square of the stretch of area.
    """
    d, d0 = surface(e, lengths, xi, eta), surface(reference, lengths, xi, eta)
    (a, b, now, _), (a0, b0, area, normal) = forms(d), forms(d0)
    if cubed:
        b = b * ((area / now) ** 2)[..., None, None]
    first = d0[1, 0] / np.linalg.norm(d0[1, 0])
    axes = np.stack([first, np.cross(normal, first)])
    inverse = np.linalg.inv(np.stack([d0[1, 0], d0[0, 1]]) @ axes.T)
    eps, kap = (inverse @ tensor @ inverse.T for tensor in (0.5 * (a - a0), b - b0))
    parts = [value for x in (eps, kap) for value in (x[..., 0, 0], x[..., 1, 1], 2 * x[..., 0, 1])]
    return np.stack(parts, axis=-1), area


def gauss_grid(n):
    """(xi, eta, weight) of the n x n rule on the unit square."""
    points, weights = (0.5 * values for values in np.polynomial.legendre.leggauss(n))
    places = list(zip(points + 0.5, weights, strict=True))
    return [(xi, eta, u * w) for xi, u in places for eta, w in places]


def energy(e, reference, lengths, stiffness, n_gauss=4, *, membrane_gauss=None, cubed=False):
    """Strain energy of one element; complex coordinates are allowed.

    With ``membrane_gauss`` the energy 1/2 N.A^-1 N of the in-plane forces is integrated by another rule than the rest.
    """

    def integral(density, n):
        total = 0.0
        for xi, eta, weight in gauss_grid(n):
            s, area = local_strains(e, reference, lengths, xi, eta, cubed=cubed)
            total = total + density(s) * area * weight * lengths[0] * lengths[1]
        return total

    def whole(s):
        return 0.5 * product(s @ stiffness, s)

    def in_plane(s):
        N = s @ stiffness[:, :3]
        return 0.5 * product(N @ np.linalg.inv(stiffness[:3, :3]), N)

    if membrane_gauss is None:
        return integral(whole, n_gauss)
    return integral(in_plane, membrane_gauss) + integral(lambda s: whole(s) - in_plane(s), n_gauss)


def complex_gradient(function, e, step=1e-30):
    """Gradient of a scalar function of e (48,) by complex step, exact to rounding."""
    return function(e + 1j * step * np.eye(48)).imag / step


def force(e, reference, lengths, stiffness, n_gauss=4, **options):
    """dW/de; the options are those of :func:`energy`."""
    return complex_gradient(lambda x: energy(x, reference, lengths, stiffness, n_gauss, **options), e)


def directional_derivative(function, direction, size):
    """d function(h direction)/dh at 0 by central differences of order eight; ``size`` is the step h."""
    weights = {1: 4 / 5, 2: -1 / 5, 3: 4 / 105, 4: -1 / 280}
    return sum(w * (function(k * size * direction) - function(-k * size * direction)) for k, w in weights.items()) / size
