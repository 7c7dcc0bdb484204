"""A clamped strip that spins about an axis through its root: bending frequencies out of the plane of rotation and in it."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.polynomial import Polynomial
from numpy.polynomial.legendre import Legendre, leggauss
from scipy.linalg import eigh

import lamella as lm
from lamella.roles import Floats
from lamella.verification import Check, References

slow = True

E, RHO, H, LENGTH, WIDTH = 70e9, 2700.0, 1e-3, 1.0, 0.05
TIME = np.sqrt(12 * RHO / (E * H**2)) * LENGTH**2
"""Unit of time sqrt(rho A L^4 / EI) [s]."""
TERMS = 12


def run() -> Iterator[Check]:
    """Yield the checks of this case."""
    references = References.beside(__file__)
    for eta in (0.5, 3.0, 6.0, 12.0):
        exact = flap(eta)
        found = {name: strip(eta, axis) for name, axis in (("flap", (0.0, 0.0, 1.0)), ("lag", (0.0, 1.0, 0.0)))}
        for k in range(3):
            yield references.check(f"spin {eta:g}: flap frequency {k + 1} over that of the beam", found["flap"][k] / exact[k])
        for k in range(2):
            lag = np.sqrt(exact[k] ** 2 - eta**2)
            yield references.check(f"spin {eta:g}: lag frequency {k + 1} over that of the beam", found["lag"][k] / lag)


def strip(eta: float, axis: tuple[float, float, float]) -> Floats:
    """The lowest frequencies of a strip with nu = 0, times TIME; its normal is z, so it flaps about z and lags about y."""
    system = lm.System()
    section = lm.Laminate(lm.Isotropic(E=E, nu=0.0, rho=RHO), thickness=H)
    plate = system.add(lm.Plate("strip", (LENGTH, WIDTH), (16, 1), section, position=(0.0, -WIDTH / 2, 0.0)))
    system.add(lm.Clamp("root", plate.edge("x-")))
    x, y, z = axis
    system.add(lm.SteadySpin("spin", (x * eta / TIME, y * eta / TIME, z * eta / TIME)))
    spun = lm.equilibrium(system)
    return 2 * np.pi * TIME * lm.modes(spun.model, 3, state=spun.final).frequencies


def flap(eta: float) -> Floats:
    """The same of a beam: w_xxxx - eta^2 (1/2 (1 - x^2) w_x)_x = omega^2 w, by Ritz's method with x^2 P_k(2 x - 1)."""
    x, weights = leggauss(40)
    x, weights = 0.5 * (x + 1), 0.5 * weights
    square = Polynomial([0.0, 0.0, 1.0])
    shapes = [square * Legendre.basis(k, domain=(0.0, 1.0)).convert(kind=Polynomial) for k in range(TERMS)]
    w, w_x, w_xx = (np.array([shape.deriv(order)(x) for shape in shapes]) for order in (0, 1, 2))
    K = (weights * w_xx) @ w_xx.T + eta**2 * (weights * 0.5 * (1 - x**2) * w_x) @ w_x.T
    return np.sqrt(eigh(K, (weights * w) @ w.T, eigvals_only=True)[:3])
