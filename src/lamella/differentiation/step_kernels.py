"""Vectors of a step of generalised-alpha that is differentiated."""

from __future__ import annotations

from lamella._jit import kernel
from lamella.roles import Floats


@kernel
def sum_with_energy(base: Floats, start: Floats, more: Floats, masses: Floats, du: Floats) -> float:
    """base + more, and the sum of masses times (base - start)^2."""
    energy = 0.0
    for i in range(len(base)):
        du[i] = base[i] + more[i]
        energy += masses[i] * (base[i] - start[i]) ** 2
    return energy


@kernel
def carried(
    u: Floats, ud: Floats, udd: Floats, a: Floats,
    dt: float, of_q: float, of_v: float, of_a: float, of_old: float, alpha_v: float, alpha_a: float,
    base: Floats, ud0: Floats, udd0: Floats,
) -> None:  # fmt: skip
    """Coordinates q + dt v + of_q a, and what velocities and accelerations would be if the new coordinates were zero."""
    for i in range(len(u)):
        base[i] = u[i] + dt * ud[i] + of_q * a[i]
        ud0[i] = ud[i] + of_v * a[i] - alpha_v * base[i]
        udd0[i] = of_a * a[i] + of_old * udd[i] - alpha_a * base[i]


@kernel
def renewed(
    u: Floats, udd_old: Floats, a: Floats, n: int, alpha_v: float, rate: float, alpha_a: float,
    of_new: float, of_old: float, of_a: float, ud: Floats, udd: Floats, a_new: Floats,
) -> None:  # fmt: skip
    """Add to velocities and accelerations what the coordinates, of which ``n`` are of motion, give; the algorithmic ones."""
    for i in range(len(u)):
        ud[i] += (alpha_v if i < n else rate) * u[i]
        udd[i] = udd[i] + alpha_a * u[i] if i < n else 0.0
        a_new[i] = of_new * udd[i] + of_old * udd_old[i] + of_a * a[i]
