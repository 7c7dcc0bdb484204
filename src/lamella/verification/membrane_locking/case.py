"""Membrane locking of strips that bend far in few elements, its cure by fewer points, and the strip of the cubed normal."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Literal

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.linalg import spsolve

import lamella as lm
from lamella.element import ELEMENTS
from lamella.element.plate48.block import ShellBlock
from lamella.element.plate48.section import Curvature, Section
from lamella.result import Result
from lamella.verification import Check, References

slow = True

LENGTH, MODULUS = 12.0, 1.2e6
THIN, THICK = 0.01, 0.1
RADIUS, RING = 1.0, 1e-3

Points = Literal[3, 4, 5]
Fewer = Literal[3, 4] | None


def run() -> Iterator[Check]:
    """Yield the checks of this case."""
    references = References.beside(__file__)
    locked, free = rolled_up_error(4, 4), rolled_up_error(4, 4, 3)
    yield references.check("thin strip rolled up by 4 elements: error of the tip, 4/3 points", free)
    yield references.check("thin strip rolled up by 4 elements: error with 4/4 points over that with 4/3", locked / free)
    yield references.check("thin strip rolled up by 8 elements: error of the tip, 4/3 points", rolled_up_error(8, 4, 3))
    locked, free = ring_deflection(2, 4), ring_deflection(2, 4, 3)
    yield references.check("quarter ring of 2 elements: deflection over the exact one, 4/3 points", free)
    yield references.check("quarter ring of 2 elements: deflection over the exact one, 4/4 points", locked)
    yield references.check("quarter ring of 8 elements: deflection over the exact one, 4/3 points", ring_deflection(8, 4, 3))
    cubed = rolled(64, THICK, curvature="cubed_normal", kind="sliding")  # the strip widens, and so must its root
    yield references.check("cubed normal: tip of the rolled-up strip against its own circle", cubed_tip_error(cubed))
    strains = cubed.model.plates[0].sample(cubed.final.q, 9).strains
    yield references.check("cubed normal: strain along the strip", float(strains[:, 1:-1, 0].mean()))
    yield references.check("cubed normal: strain across the strip", float(strains[:, 1:-1, 1].mean()))


def full_circle(thickness: float) -> float:
    """Moment per width that rolls the inextensible strip up to a full circle [N]."""
    return 2 * np.pi * MODULUS * thickness**3 / 12 / LENGTH


def rolled(
    n: int,
    thickness: float,
    n_gauss: Points = 4,
    membrane_gauss: Fewer = None,
    curvature: Curvature = "unit_normal",
    kind: Literal["full", "sliding"] = "full",
) -> Result:
    """A flat strip 12 m x 1 m rolled up by the moment at its end in twenty load steps."""
    system = lm.System()
    section = lm.Laminate(lm.Isotropic(E=MODULUS, nu=0.0, rho=1.0), thickness=thickness)
    rules = {"n_gauss": n_gauss, "membrane_gauss": membrane_gauss}
    plate = system.add(lm.Plate("strip", (LENGTH, 1.0), (n, 1), section, **rules, curvature=curvature))
    plate.marker("tip", LENGTH, 0.5)
    system.add(lm.Clamp("root", plate.edge("x-"), kind=kind))
    system.add(lm.EdgeMoment("moment", plate.edge("x+"), bending=-full_circle(thickness)))
    return lm.equilibrium(system, steps=20)


def rolled_up_error(n: int, n_gauss: Points, membrane_gauss: Fewer = None, kind: Literal["full", "sliding"] = "full") -> float:
    """Distance of the thin strip's tip from its root, where the full circle ends, over the length."""
    result = rolled(n, THIN, n_gauss, membrane_gauss, kind=kind)
    return float(np.linalg.norm(result["tip.position"].values[[0, 2]])) / LENGTH


def cubed_tip_error(result: Result) -> float:
    """Distance [m] of the tip from the uniform state of the cubed normal.

    With stretches g, k along and across and the rotation theta' per reference length, kap = theta' / (g k^2), and the energy
    A (eps_x^2 + eps_y^2) / 2 + D kap^2 / 2 - M theta' is stationary for D kap = M g k^2, A eps_x g^2 = D kap^2 and
    A eps_y k^2 = 2 D kap^2.
    """
    A, D, M = MODULUS * THICK, MODULUS * THICK**3 / 12, full_circle(THICK)
    g2 = k2 = 1.0  # squares of the stretches; the iteration contracts by about M^2 / (A D), 2e-4
    for _ in range(20):
        g2, k2 = 1 + 2 * M**2 / (A * D) * k2**2, 1 + 4 * M**2 / (A * D) * g2 * k2
    rate = M / D * g2 * k2**2
    radius, angle = np.sqrt(g2) / rate, rate * LENGTH
    exact = np.array([radius * np.sin(angle), radius * (1 - np.cos(angle))])
    return float(np.linalg.norm(result["tip.position"].values[[0, 2]] - exact))


def ring_deflection(n: int, n_gauss: int, membrane_gauss: int | None = None) -> float:
    """Radial deflection of a quarter ring's end under a radial force, over pi P R^3 / (4 E I), on n x 1 elements."""
    element = ELEMENTS["plate48"]
    arc = np.linspace(0.0, np.pi / 2, n + 1)
    s, c, zero = np.sin(arc), np.cos(arc), np.zeros(n + 1)
    rest = np.zeros((2, n + 1, 4, 3))  # side of the strip, node along it, vector
    rest[:, :, 0] = np.stack([RADIUS * s, zero, RADIUS * (1 - c)], axis=-1)
    rest[1, :, 0, 1] = 1.0
    rest[:, :, 1] = np.stack([c, zero, s], axis=-1)
    rest[:, :, 2, 1] = 1.0
    numbers = np.arange(rest.size).reshape(rest.shape)
    coords = np.array([[numbers[j, i + di] for di, j in element.nodes] for i in range(n)]).reshape(n, -1)
    scale = np.tile(np.repeat(element.scales(RADIUS * np.pi / 2 / n, 1.0), 3), (n, 1))
    stiffness = lm.Laminate(lm.Isotropic(E=MODULUS, nu=0.0, rho=1.0), thickness=RING).stiffness
    section = Section(stiffness, membrane_gauss=membrane_gauss)
    block = ShellBlock("ring", coords, scale, rest.reshape(-1)[coords], section, n_gauss)
    q, f, k = rest.reshape(-1), np.empty(len(block.f_coords)), np.empty(len(block.k_rows))
    block.force_tangent(0.0, q, q, 1.0, 0.0, q, f, k)
    used = block.k_rows >= 0
    upper = coo_array(((k * block.k_scale)[used], (block.k_rows[used], block.k_cols[used])), shape=(q.size, q.size)).tocsr()
    K = upper + upper.T
    K.setdiag(upper.diagonal())
    load = np.zeros(rest.shape)  # a unit force, even along the edge
    load[:, -1, 0, 0], load[0, -1, 2, 0], load[1, -1, 2, 0] = 0.5, 1 / 12, -1 / 12
    held = np.zeros(rest.shape, bool)
    held[:, 0] = True
    held[:, 0, 1, 0] = False  # the slope along may stretch
    moving = np.flatnonzero(~held)
    deflection = load.reshape(-1)[moving] @ spsolve(K[moving][:, moving].tocsc(), load.reshape(-1)[moving])
    return float(deflection / (np.pi * RADIUS**3 / (4 * MODULUS * RING**3 / 12)))
