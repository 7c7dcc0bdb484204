"""A belt around two equal rollers as a plane elastica on soft rollers: the reference of the shell's contact."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.integrate import solve_bvp

from lamella.roles import Floats


@dataclass(frozen=True)
class BeltBeam:
    """The equilibrium of a belt without friction, by symmetry a quarter of it from the middle of its contact to that of a strand.

    With the arc length s of the stress-free belt, a circle of the length L, the section's angle theta, moment M, force F with the
    part N along the belt, and the force f of the roller,

        r' = (1 + N / EA) t,   theta' = 2 pi / L + M / EI,   M' = -(1 + N / EA) t x F,   F' = -f,
        f = w k depth^(3/2) n,   depth = R + h/2 - |r - c|,

    up to where the belt leaves the roller, s = a, and f = 0 beyond. Solved by collocation on both parts together; the place c of
    the roller and a are unknown as well.

    Args:
        centres: distance of the rollers [m].
        contact: a [m].
        s: from 0 to a [m], shape (n,).
        depth: there [m], shape (n,).
        line_force: w k depth^(3/2), on the roller [N/m], shape (n,).
        normal: sum of the normal forces on a roller [N].
        bending: change of the curvature theta' at s = 0 [1/m].
        tension: N at s = 0 [N]; less than that of a strand, which pulls at an angle where it leaves the roller.
    """

    centres: float
    contact: float
    s: Floats
    depth: Floats
    line_force: Floats
    normal: float
    bending: float
    tension: float


def belt_beam(
    tension: float, EA: float, EI: float, length: float, reach: float, stiffness: float, *, tolerance: float = 1e-4
) -> BeltBeam:
    """The equilibrium under a tension.

    Args:
        tension: of a strand [N].
        EA: stiffness to tension [N].
        EI: stiffness to bending [N m^2].
        length: L, of the belt [m].
        reach: R + h/2 [m].
        stiffness: w k [N/m^(5/2)].
        tolerance: of the collocation, relative.

    Raises:
        RuntimeError: the collocation did not converge.
    """
    quarter, round_ = 0.25 * length, 2.0 * np.pi / length
    radius = reach - (tension / (reach * stiffness)) ** (2 / 3)  # of a belt that does not bend, with which the search begins
    arc, centre = 0.5 * np.pi * radius, 0.25 * length * (1.0 + tension / EA) - 0.5 * np.pi * radius

    def guess(s: Floats) -> Floats:
        phi, beyond = np.minimum(s, arc) / radius, np.maximum(s - arc, 0.0)
        moment = EI * (np.where(s < arc, 1.0 / radius, 0.0) - round_)
        place = centre + radius * np.cos(phi) - beyond, radius * np.sin(phi)
        return np.array([*place, 0.5 * np.pi + phi, moment, -tension * np.sin(phi), tension * np.cos(phi)])

    def line_force(x: Floats, y: Floats, c: float) -> Floats:
        return stiffness * np.maximum(reach - np.hypot(x - c, y), 0.0) ** 1.5

    def part(z: Floats, span: float, c: float, *, touches: bool) -> Floats:
        x, y, theta, moment, F_x, F_y = z
        t_x, t_y = np.cos(theta), np.sin(theta)
        stretch = 1.0 + (F_x * t_x + F_y * t_y) / EA
        f = line_force(x, y, c) / np.hypot(x - c, y) if touches else np.zeros_like(x)
        bent = round_ + moment / EI
        return span * np.array([stretch * t_x, stretch * t_y, bent, stretch * (F_x * t_y - F_y * t_x), -f * (x - c), -f * y])

    def rates(_: Floats, z: Floats, p: Floats) -> Floats:
        c, a = p
        return np.concatenate([part(z[:6], a, c, touches=True), part(z[6:], quarter - a, c, touches=False)])

    def ends(first: Floats, last: Floats, p: Floats) -> Floats:
        leaves = np.hypot(last[0] - p[0], last[1]) - reach
        middle = [last[6], last[8] - np.pi, last[10] + tension, last[11]]
        return np.concatenate([[first[1], first[2] - 0.5 * np.pi, first[4]], last[:6] - first[6:], [leaves], middle])

    xi = np.linspace(0.0, 1.0, 41)
    start = np.concatenate([guess(arc * xi), guess(arc + (quarter - arc) * xi)])
    solved = solve_bvp(rates, ends, xi, start, p=[centre, 0.95 * arc], tol=tolerance, max_nodes=5000)
    if solved.status != 0:
        raise RuntimeError(f"elastica of the belt: {solved.message}")
    c, a = (float(value) for value in solved.p)
    share = np.linspace(0.0, 1.0, 1001)
    z = solved.sol(share)
    force = line_force(z[0], z[1], c)
    depth = np.maximum(reach - np.hypot(z[0] - c, z[1]), 0.0)
    normal = 2 * a * float(np.trapezoid(force, share))
    return BeltBeam(2 * c, a, a * share, depth, force, normal, float(z[3][0]) / EI, float(z[5][0]))
