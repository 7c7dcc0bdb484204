"""Joints between two bodies hold what they must and leave free what they must; their derivatives are exact."""

from __future__ import annotations

import numpy as np
import pytest
from joint_pairs import PAIRS

import lamella as lm
from lamella.assembly.equations import Equations
from lamella.errors import DeclarationError

MOVED = [(name, moved) for name in PAIRS for moved in "ab" if moved == "b" or "ground" not in name]
pairs = pytest.mark.parametrize("name", PAIRS)
with_multipliers = pytest.mark.parametrize("name", [name for name in PAIRS if PAIRS[name].system().compile().n_lam])


def mobility(*declarations):
    system = lm.System()
    for declaration in declarations:
        system.add(declaration)
    return Equations(system.compile()).mobility


@pairs
def test_degrees_of_freedom_are_those_of_the_textbook(name):
    a, b, joint = PAIRS[name].make()
    alone = sum(mobility(body) for body in (a, b) if not isinstance(body, lm.Ground))
    assert mobility(a, b, joint) == alone - PAIRS[name].held


def rates_of_rows(model, v):
    """Rates of all equations of the joint in the reference configuration for the coordinate velocities v (n_q,)."""
    (support,) = model.supports
    rates = [model.rows[row].coefs @ v[model.rows[row].coords] for row in support.rows]
    x, v = model.q0.reshape(-1, 3), v.reshape(-1, 3)
    terms = [model.dots[row].terms for row in support.dots]
    return np.array(rates + [sum(c * (u.rate(v) @ w.at(x) + u.at(x) @ w.rate(v)) for c, u, w in row) for row in terms])


@pytest.mark.parametrize(("name", "moved"), MOVED)
def test_rigid_motion_of_one_body_is_free_along_the_free_directions_only(name, moved):
    pair = PAIRS[name]
    model = pair.system(None).compile()
    x = model.q0.reshape(-1, 3)
    own = np.array([owner == moved for owner in model.owners])
    rates = {}
    for kind in ("t", "r"):
        for letter, axis in zip("xyz", pair.axes.T, strict=True):
            turned = np.cross(axis, x - np.outer(model.is_position, pair.centre))
            velocity = np.outer(model.is_position, axis) if kind == "t" else turned
            rates[kind + letter] = rates_of_rows(model, np.where(own[:, None], velocity, 0.0).reshape(-1))
    free = pair.free.split()
    for direction in free:
        np.testing.assert_allclose(rates[direction], 0.0, atol=1e-13)  # rounding of sums of terms of size 1
    held = np.array([rate for direction, rate in rates.items() if direction not in free])
    # no combination of the held directions is free: a held direction changes some row by an arm of a decimetre or more
    assert len(held) == 0 or np.linalg.svd(held, compute_uv=False)[: len(held)].min() > 0.05


class Along:
    """One block of a model along a smooth curve q(t) with its derivatives."""

    def __init__(self, model, block, seed=4):
        self.block, self.size, self.n = block, model.magnitude, model.n_q
        self.rng = np.random.default_rng(seed)
        self.q, self.v = model.q0 + 0.1 * self.random(), self.random()

    def random(self):
        return self.size * self.rng.uniform(-1, 1, self.n)

    def phi(self, q, t=0.3):
        out = np.full(self.block.n_lam, np.nan)
        self.block.phi(t, q, out)
        return out

    def jacobian(self, q):
        out, J = np.full(len(self.block.j_rows), np.nan), np.zeros((self.block.n_lam, self.n))
        self.block.jacobian(0.3, q, out)
        np.add.at(J, (self.block.j_rows, self.block.j_cols), out)
        return J

    def curvature(self, lam):
        out, K = np.full(len(self.block.k_rows), np.nan), np.zeros((self.n, self.n))
        self.block.curvature(0.3, self.q, lam, out)
        assert np.all(self.block.k_rows <= self.block.k_cols)
        np.add.at(K, (self.block.k_rows, self.block.k_cols), out)
        return K + np.triu(K, 1).T

    def check(self):
        """All derivatives by central differences, which are exact for the quadratic rows of joints."""
        h, lam, d = 0.1, self.rng.uniform(1, 2, self.block.n_lam), self.random()
        near = {"rtol": 1e-11, "atol": 1e-11 * self.size.max()}  # rounding of values of size 1 over steps of 0.1
        ahead, behind = (self.phi(self.q + s * d) for s in (h, -h))
        np.testing.assert_allclose(self.jacobian(self.q) @ d, (ahead - behind) / (2 * h), **near)
        force = [self.jacobian(self.q + s * d).T @ lam for s in (h, -h)]
        np.testing.assert_allclose(self.curvature(lam) @ d, (force[0] - force[1]) / (2 * h), **near)
        a, rate, gamma = self.random(), np.full_like(lam, np.nan), np.full_like(lam, np.nan)
        self.block.phi_t(0.3, self.q, rate)
        self.block.gamma(0.3, self.q, self.v, gamma)
        h = 1e-3
        phi = {s: self.phi(self.q + s * h * self.v + 0.5 * (s * h) ** 2 * a, 0.3 + s * h) for s in (-2, -1, 0, 1, 2)}
        first = (-phi[2] + 8 * phi[1] - 8 * phi[-1] + phi[-2]) / (12 * h)
        second = (-phi[2] + 16 * phi[1] - 30 * phi[0] + 16 * phi[-1] - phi[-2]) / (12 * h**2)
        # differences of fourth order over 1 ms: rounding of 1e-16 / h and 1e-16 / h^2
        J = self.jacobian(self.q)
        np.testing.assert_allclose(J @ self.v + rate, first, rtol=1e-8, atol=1e-10)
        np.testing.assert_allclose(J @ a + gamma, second, rtol=1e-6, atol=1e-7)


@with_multipliers
def test_derivatives_are_exact(name):
    model = PAIRS[name].system().compile()
    for block in model.constraints:
        Along(model, block).check()


def test_points_off_the_axis_are_refused():
    system, ground = lm.System(), lm.Ground()
    body = lm.RigidBody("body", mass=1.0, inertia=(1.0, 1.0, 1.0), position=(0.0, 0.2, 0.0))
    for item in (ground, body, lm.PointOnLineJoint("rail", ground.marker("o", 0, 0, 0), body.origin, axis=(1, 0, 0))):
        system.add(item)
    with pytest.raises(DeclarationError, match=r"PointOnLineJoint 'rail': .* 0\.2 m"):
        system.compile()
