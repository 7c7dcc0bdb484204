"""Clamped composite plate under a force at the middle of its free edge."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Literal

import lamella as lm
from lamella.result import Result
from lamella.verification import Check, References

slow = False

PLY = lm.Lamina(E1=181e9, E2=103e9, G12=7.7e9, nu12=0.28, rho=1560)
LAMINATE = lm.Laminate(PLY, angles=(0, 90, 0), thickness=1.5e-3)


def run() -> Iterator[Check]:
    """Yield the checks of this case."""
    references = References.beside(__file__)
    yield from stiffness(references)
    for n in (6, 12, 24):
        result = loaded(n)
        for force, factor in ((-10, 0.5), (-20, 1.0)):
            position = result.history("C.position").sel(load_factor=factor, method="nearest").values
            energy = float(result.history("energy.strain").sel(load_factor=factor, method="nearest"))
            yield references.check(f"z_C at {force} N, mesh {n} x {n}", position[2])
            yield references.check(f"x_C at {force} N, mesh {n} x {n}", position[0])
            if force == -10:
                yield references.check(f"strain energy at -10 N, mesh {n} x {n}", energy)
            if n == 24:
                yield references.check(f"z_C at {force} N, converged", position[2])
    linear = [float(loaded(n, strain="linear")["C.position"][2]) / 2 for n in (12, 24)]
    yield references.check("z_C at -10 N, linear theory, mesh 24 x 24", linear[1])
    yield references.check("z_C at -10 N, linear theory, extrapolated", linear[1] + (linear[1] - linear[0]) / 3)


def loaded(n: int, strain: Literal["exact", "linear"] = "exact") -> Result:
    """Equilibria under -10 N and -20 N."""
    system = lm.System()
    plate = system.add(lm.Plate("plate", (1.5, 2.0), (n, n), LAMINATE, strain=strain))
    system.add(lm.Clamp("root", plate.edge("x-")))
    system.add(lm.PointForce("force", plate.marker("C", 1.5, 1.0), (0.0, 0.0, -20.0)))
    return lm.equilibrium(system, steps=2)


def stiffness(references: References) -> Iterator[Check]:
    """The laminate's matrices."""
    A, D = LAMINATE.A, LAMINATE.D
    for name, value in (
        ("A11", A[0, 0]),
        ("A22", A[1, 1]),
        ("A12", A[0, 1]),
        ("A66", A[2, 2]),
        ("D11", D[0, 0]),
        ("D22", D[1, 1]),
        ("D12", D[0, 1]),
        ("D66", D[2, 2]),
    ):
        yield references.check(name, value)
    yield references.check("largest entry of B", abs(LAMINATE.B).max())
