"""Clamped composite plate under a force at the middle of its free edge."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Literal

import lamella as lm
from lamella.result import Result
from lamella.verification import Check, Curves, Evidence, References, Shape

slow = False

PLY = lm.Lamina(E1=181e9, E2=103e9, G12=7.7e9, nu12=0.28, rho=1560)
LAMINATE = lm.Laminate(PLY, angles=(0, 90, 0), thickness=1.5e-3)


def run() -> Iterator[Evidence]:
    """Yield the checks and pictures of this case."""
    references = References.beside(__file__)
    yield from stiffness(references)
    results = {n: loaded(n) for n in (6, 12, 24)}
    for n, result in results.items():
        for force, factor in ((-10, 0.5), (-20, 1.0)):
            position = result.history("C.position").sel(load_factor=factor, method="nearest").values
            energy = float(result.history("energy.strain").sel(load_factor=factor, method="nearest"))
            yield references.check(f"z_C at {force} N, mesh {n} x {n}", position[2])
            yield references.check(f"x_C at {force} N, mesh {n} x {n}", position[0])
            if force == -10:
                yield references.check(f"strain energy at -10 N, mesh {n} x {n}", energy)
            if n == 24:
                yield references.check(f"z_C at {force} N, converged", position[2])
    flat = {n: loaded(n, strain="linear") for n in (12, 24)}
    linear = [float(result["C.position"][2]) / 2 for result in flat.values()]
    yield references.check("z_C at -10 N, linear theory, mesh 24 x 24", linear[1])
    yield references.check("z_C at -10 N, linear theory, extrapolated", linear[1] + (linear[1] - linear[0]) / 3)
    computed = {
        label: ([0.0, *20 * result.history("C.position").load_factor.values], [0.0, *result.samples("C.position")[:, 2]])
        for label, result in (("exact strains", results[24]), ("linear theory", flat[24]))
    }
    found = [references.value(f"z_C at {force} N, converged") for force in (-10, -20)]
    points = {
        "three tools": ([10.0, 20.0], found),
        "linear theory": ([10.0], [references.value("z_C at -10 N, linear theory, extrapolated")]),
    }
    yield Curves("Deflection under the force", "Force [N]", "z_C [m]", computed, points)
    yield Shape("Under -20 N, mesh 12 x 12", results[12])


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
