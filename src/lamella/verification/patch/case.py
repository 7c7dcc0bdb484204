"""Constant strain and curvature on elongated elements, and rigid motion."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Literal

import numpy as np

import lamella as lm
from lamella.assembly.forces import ForceSum
from lamella.math.rotation import matrix_from_vector
from lamella.model import Model
from lamella.roles import Floats
from lamella.verification import Check, Evidence, References, Shape

slow = False

SIZE, MESH = (2.0, 0.3), (3, 4)
PLY = lm.Lamina(E1=181e9, E2=10.3e9, G12=7.17e9, nu12=0.28, rho=1600)
LAMINATE = lm.Laminate(PLY, angles=(0, 30, -70), thickness=(1e-3, 2e-3, 1.5e-3))
STRETCH = np.array([[1.1, 0.15], [0.0, 0.95], [0.0, 0.0]])
CURVATURE = np.array([0.02, -0.03, 0.05])


def run() -> Iterator[Evidence]:
    """Yield the checks and pictures of this case."""
    references = References.beside(__file__)
    yield from stretched(references)
    yield from curved(references)
    yield from moved(references)


def stretched(references: References) -> Iterator[Evidence]:
    """A plate in equilibrium with the edge forces of a uniform large stretch."""
    system = lm.System()
    section = lm.Laminate(PLY, angles=(0, 30, -70, 30, 0), thickness=5e-3)
    plate = system.add(lm.Plate("plate", SIZE, MESH, section))
    system.add(lm.PointSupport("pin", plate.corner("x-y-")))
    system.add(lm.PointSupport("line", plate.corner("x+y-"), axes="yz"))
    system.add(lm.PointSupport("height", plate.corner("x-y+"), axes="z"))
    green = 0.5 * (STRETCH.T @ STRETCH - np.eye(2))
    N = section.A @ [green[0, 0], green[1, 1], 2 * green[0, 1]]
    traction = STRETCH @ [[N[0], N[2]], [N[2], N[1]]]  # columns: force per reference length on x+ and y+
    for edges, force in ((("x-", "x+"), traction[:, 0]), (("y-", "y+"), traction[:, 1])):
        for side, sign in zip(edges, (-1.0, 1.0), strict=True):
            system.add(lm.EdgeForce(f"pull {side}", lm.Edge(plate, side), tuple(sign * force)))
    result = lm.equilibrium(system, newton=lm.Newton(keep=0.0, line_search=True))
    yield Shape("Uniform stretch by edge forces", result, field="membrane_strain.xx")
    sample = result.model.plates[0].sample(result.final.q)
    points = np.stack(np.meshgrid(sample.x, sample.y), axis=-1)
    yield references.check("uniform stretch by edge forces: positions", np.abs(sample.r - points @ STRETCH.T).max())
    expected = np.array([green[0, 0], green[1, 1], 2 * green[0, 1], 0.0, 0.0, 0.0])
    strain_error = np.abs(sample.strains - expected) * [1.0, 1.0, 1.0, *[section.h] * 3]
    yield references.check("uniform stretch by edge forces: strains", strain_error.max())


def curved(references: References) -> Iterator[Check]:
    """Linear model on a quadratic surface: no force on inner nodes, energy of the constant curvature."""
    model = one_plate("linear")
    q = model.q0.reshape(-1, 4, 3).copy()
    x, y = q[:, 0, 0], q[:, 0, 1]
    kx, ky, kxy = CURVATURE
    w = np.stack([(kx * x**2 + ky * y**2 + kxy * x * y) / 2, kx * x + kxy * y / 2, ky * y + kxy * x / 2, 0 * x + kxy / 2], axis=1)
    q[:, :, 2] = w
    kap = np.array([kx, ky, kxy])
    f, energy = internal(model, q.reshape(-1))
    exact = float(0.5 * kap @ LAMINATE.D @ kap) * SIZE[0] * SIZE[1]
    source, why = "exact: kap.D kap area / 2", "rounding: the state lies in the element"
    yield Check("constant curvature: energy", energy, exact, 1e-9, source=source, unit="J", reason=why)
    forces, inner = np.abs(f.reshape(-1, 4, 3)), np.arange(len(q)).reshape(MESH[1] + 1, MESH[0] + 1)[1:-1, 1:-1].reshape(-1)
    relative = [forces[inner, k].max() / forces[:, k].max() for k in range(4)]
    yield references.check("constant curvature: force on inner nodes, relative to the edge", max(relative))


def moved(references: References) -> Iterator[Check]:
    """Energy and force after a large rigid motion, against those of a strain of 1e-3."""
    model = one_plate("exact")
    turn, shift = matrix_from_vector(np.array([0.7, -1.9, 1.1])), np.array([3.0, -5.0, 2.0])
    q = model.q0.reshape(-1, 3) @ turn.T + np.outer(model.is_position, shift)
    strained = model.q0.reshape(-1, 3) * (1.0 + 1e-3)
    (f, energy), (f_scale, energy_scale) = internal(model, q.reshape(-1)), internal(model, strained.reshape(-1))
    yield references.check("rigid motion: energy, relative to a strain of 1e-3", energy / energy_scale)
    yield references.check("rigid motion: force, relative to a strain of 1e-3", np.abs(f).max() / np.abs(f_scale).max())


def one_plate(strain: Literal["exact", "linear"]) -> Model:
    """A free plate of an unsymmetric angle-ply laminate."""
    system = lm.System()
    system.add(lm.Plate("plate", SIZE, MESH, LAMINATE, strain=strain))
    return system.compile()


def internal(model: Model, q: Floats) -> tuple[Floats, float]:
    """Internal force (n_q,) and energy [J] of the model in the configuration ``q``."""
    force = ForceSum(model.forces, model.n_q)(0.0, q, np.zeros_like(q)).copy()
    return force, sum(block.energy(0.0, q) for block in model.forces)
