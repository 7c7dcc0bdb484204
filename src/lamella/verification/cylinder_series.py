"""Small deflection of a cylinder under two opposite radial forces, by series, with and without transverse shear."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.polynomial import legendre
from scipy.linalg import null_space

from lamella.roles import Floats

DEGREE = 30
"""Of the Legendre polynomials along the cylinder; they crowd at its ends, where the deflection is steep."""
SHEAR_FACTOR = 5 / 6


@dataclass(frozen=True)
class PinchedCylinder:
    """Linear theory of a cylinder under radial forces F at phi = 0 and -F at phi = pi, on one end s of its length.

    With displacements u = U(s) cos n phi along, v = V(s) sin n phi around and w = W(s) cos n phi outwards, n = 0, 2, 4 ..., the
    energy of strains (C, nu), curvatures (D, nu; Koiter 1960) and, with shear, of gamma (kappa G h) is minimal:

        eps_s = u_s,  eps_phi = (v_phi + w)/R,  gamma = v_s + u_phi/R
        kap_s = b_s,  kap_phi = c_phi/R,  2 kap_sphi = c_s + b_phi/R + (v_s - u_phi/R)/(2 R)
        gamma_s = b + w_s,  gamma_phi = c + (w_phi - v)/R

    Without shear the rotations are those of the normal, b = -w_s and c = (v - w_phi)/R.

    Args:
        radius, length, thickness: [m]; one half of the length where it is symmetric.
        modulus: of elasticity [Pa].
        poisson: ratio [-].
        held: ``clamped``: at s = 0, loaded at the free end s = length; ``symmetric``: about s = 0, loaded there, free at the end.
    """

    radius: float
    length: float
    thickness: float
    modulus: float
    poisson: float
    held: Literal["clamped", "symmetric"]

    def deflection(self, waves: int, *, shear: bool = False) -> float:
        """Displacement of a loaded point along its force, for unit forces [m/N], from 2, 4 ... ``waves`` waves around.

        With shear it grows without limit as ln(waves): the shear force F/(2 pi r) at a distance r has infinite energy at r = 0.
        """
        share = 1.0 if self.held == "clamped" else 0.5  # of the force, on this side of the plane of symmetry
        return share * sum(self._harmonic(n, shear=shear) for n in range(0, waves + 1, 2))

    def _harmonic(self, n: int, *, shear: bool) -> float:
        R, h, nu = self.radius, self.thickness, self.poisson
        C = self.modulus * h / (1 - nu**2)
        D = C * h**2 / 12
        names = ["u", "v", "w", *(("b", "c") if shear else ())]
        basis = {name: self._polynomials(name, shear=shear) for name in names if n or name not in "vc"}
        sizes = [b.shape[1] for b in basis.values()]
        place = dict(zip(basis, np.split(np.arange(sum(sizes)), np.cumsum(sizes)[:-1]), strict=True))
        s, weights = legendre.leggauss(DEGREE + 4)
        weights = weights * self.length / 2 * R * np.pi * (1 if n else 2)
        values = [self._values(s, derivative) for derivative in range(3)]

        def of(name: str, derivative: int = 0) -> Floats:
            """Values of a function, or of its derivative along, at the Gauss points by its coefficients."""
            found = np.zeros((len(s), sum(sizes)))
            if name in basis:
                found[:, place[name]] = values[derivative] @ basis[name]
            return found

        def energy(a: Floats, b: Floats) -> Floats:
            return (a * weights[:, None]).T @ b

        def plate(xx: Floats, yy: Floats, xy: Floats) -> Floats:
            cross = energy(xx, yy)
            return energy(xx, xx) + energy(yy, yy) + nu * (cross + cross.T) + (1 - nu) / 2 * energy(xy, xy)

        K = C * plate(of("u", 1), (n * of("v") + of("w")) / R, of("v", 1) - n / R * of("u"))
        if shear:
            b, b_s, c, c_s = of("b"), of("b", 1), of("c"), of("c", 1)
            S = SHEAR_FACTOR * self.modulus / (2 * (1 + nu)) * h
            around = c - (n * of("w") + of("v")) / R
            K = K + S * (energy(b + of("w", 1), b + of("w", 1)) + energy(around, around))
        else:
            b, b_s = -of("w", 1), -of("w", 2)
            c, c_s = (of("v") + n * of("w")) / R, (of("v", 1) + n * of("w", 1)) / R
        K = K + D * plate(b_s, n / R * c, c_s - n / R * b + (of("v", 1) + n / R * of("u")) / (2 * R) * (-1 if shear else 1))
        load = np.zeros(sum(sizes))
        load[place["w"]] = 2 * self._values(np.array([1.0 if self.held == "clamped" else -1.0]), 0)[0] @ basis["w"]
        return float(load @ np.linalg.solve(K, load)) / 2

    def _polynomials(self, name: str, *, shear: bool) -> Floats:
        """Legendre coefficients of the polynomials that a displacement or rotation may be, by columns."""
        kirchhoff = () if shear else (1,)  # where the slope is the rotation
        held: dict[str, Sequence[int]] = (
            {"u": (0,), "v": (0,), "w": (0, *kirchhoff), "b": (0,), "c": (0,)}
            if self.held == "clamped"
            else {"u": (0,), "v": (), "w": kirchhoff, "b": (0,), "c": ()}
        )
        rows = [self._values(np.array([-1.0]), derivative)[0] for derivative in held[name]]
        return null_space(np.array(rows)) if rows else np.eye(DEGREE + 1)

    def _values(self, s: Floats, derivative: int) -> Floats:
        """Legendre polynomials, or derivatives by the length, at s in [-1, 1]."""
        coefficients = legendre.legder(np.eye(DEGREE + 1), derivative)
        return legendre.legvander(s, DEGREE - derivative) @ coefficients * (2 / self.length) ** derivative
