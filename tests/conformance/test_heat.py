"""Everything that heats or cools a plate keeps the same rules: tangents of all four blocks, energy, and rotation of the whole."""

from __future__ import annotations

import importlib
import pkgutil

import numpy as np
import pytest

import lamella as lm
import lamella.thermal
from lamella.assembly.equations import Equations
from lamella.assembly.point import Point, Weights
from lamella.math.rotation import matrix_from_vector
from lamella.roles import Declaration

DATA = {"alpha1": -5e-7, "alpha2": 2.25e-5, "k1": 5.0, "k2": 0.7, "k3": 0.5, "c": 900.0}
PLY = lm.Lamina(E1=181e9, E2=10.3e9, G12=7.17e9, nu12=0.28, rho=1600.0, **DATA)
UNSYMMETRIC = lm.Laminate(PLY, angles=(10.0, 90.0, -40.0), thickness=(1e-3, 2e-3, 1e-3), offset=5e-4)
RIDGE = lm.Harmonic(amplitude=0.5, frequency=0.2, mean=1.0)
SUN = (0.5, -0.4, -0.8)
T = 0.7

ITEMS = {
    "nothing": lambda plate: (),
    "flux": lambda plate: (lm.HeatFlux("item", plate, "bottom", 800.0, RIDGE),),
    "source": lambda plate: (lm.HeatSource("item", plate, 2e5, RIDGE),),
    "film": lambda plate: (lm.Film("item", plate, 12.0, 330.0, sides="top"),),
    "radiation": lambda plate: (lm.Radiation("item", plate, 0.8, space=3.0),),
    "radiation of one side": lambda plate: (lm.Radiation("item", plate, 0.8, space=200.0, sides="bottom"),),
    "sun": lambda plate: (lm.SolarFlux("item", plate, SUN, (0.8, 0.3), profile=RIDGE),),
    "sun that turns": lambda plate: (lm.SolarFlux("item", plate, SUN, 0.8, turning=(0.2, 0.3, -0.1)),),
    "sun from below": lambda plate: (lm.SolarFlux("item", plate, tuple(-x for x in SUN), (0.8, 0.3)),),
    "uncoupled sun": lambda plate: (lm.SolarFlux("item", plate, SUN, (0.8, 0.3), model="uncoupled"),),
    "held edge": lambda plate: (lm.PrescribedTemperature("item", plate.edge("y+"), 310.0, 20.0, RIDGE),),
}


def system_of(name, joint=False, **options):
    """A damped plate with a temperature; with ``joint``, mounted on a rigid body so that there are multipliers."""
    system = lm.System()
    given = {"position": (0.3, -0.2, 0.1), "rotation": (0.2, -0.5, 0.9), "damping": 0.02}
    plate = lm.Plate("plate", (1.5, 0.8), (3, 3), UNSYMMETRIC, **(given | options))
    system.add(plate)
    system.add(lm.TemperatureField("field", plate, reference=290.0))
    for item in ITEMS[name](plate):
        system.add(item)
    if joint:
        hub = lm.RigidBody("hub", mass=3.0, inertia=(0.1, 0.2, 0.3), position=given["position"])
        system.add(hub)
        system.add(lm.FixedJoint("mount", hub.origin, plate.edge("x-"), kind="sliding"))
    return system


class Case:
    """Equations at a deformed, moving and unevenly warm state."""

    def __init__(self, system, seed=1, size=0.03):
        self.model = system.compile()
        self.equations = Equations(self.model, symmetric=False)
        self.n, self.magnitude = self.equations.n_motion, self.equations.magnitude
        rng = np.random.default_rng(seed)
        start = self.equations.start(T)
        scatter = np.where(np.arange(len(start.u)) < self.n, size, 0.3)  # 30 K
        u = start.u + scatter * self.magnitude * rng.uniform(-1, 1, len(start.u))
        ud = 0.1 * self.magnitude * rng.uniform(-1, 1, len(start.u))
        self.point = Point(T, u, ud, np.zeros_like(u), 50.0 * rng.uniform(-1, 1, self.equations.n_lam))

    def residual(self, du, weights):
        """Residual after a change of the unknown."""
        dv = np.where(np.arange(len(du)) < self.n, weights.alpha_v, weights.rate) * du
        p = self.point
        return self.equations.residual(Point(p.t, p.u + weights.alpha_q * du, p.ud + dv, p.udd, p.lam))[0]

    def tangents(self, weights, step):
        """The matrix and its central differences of fourth order, in units of each coordinate's magnitude."""
        _, _, k, _ = self.equations.linearise(self.point, weights)
        exact = np.asarray(self.equations.matrix.pattern.matrix(k).todense())
        numeric = np.zeros_like(exact)
        for i in range(len(exact)):
            d = np.zeros(len(exact))
            d[i] = step * self.magnitude[i]
            near = self.residual(d, weights) - self.residual(-d, weights)
            far = self.residual(2 * d, weights) - self.residual(-2 * d, weights)
            numeric[:, i] = (8 * near - far) / (12 * d[i])
        scale = np.outer(self.magnitude, self.magnitude)
        return exact * scale, numeric * scale

    def blocks(self, matrix):
        n = self.n
        return {"qq": matrix[:n, :n], "qT": matrix[:n, n:], "Tq": matrix[n:, :n], "TT": matrix[n:, n:]}


def test_every_item_of_heat_has_a_case():
    kinds = set()
    for module in pkgutil.iter_modules(lamella.thermal.__path__, "lamella.thermal."):
        for item in vars(importlib.import_module(module.name)).values():
            if isinstance(item, type) and issubclass(item, Declaration) and item.__module__ == module.name:
                kinds.add(item.__name__)
    plate = lm.Plate("plate", (1.0, 1.0), (1, 1), UNSYMMETRIC)
    assert kinds == {type(item).__name__ for make in ITEMS.values() for item in make(plate)} | {"TemperatureField"}


@pytest.mark.parametrize("name", ITEMS)
@pytest.mark.parametrize("weights", [Weights(), Weights(1.0, 30.0, 0.0, 0.4)], ids=["static", "moving"])
def test_all_blocks_of_the_tangent_are_derivatives_of_the_residual(name, weights):
    case = Case(system_of(name))
    exact, numeric = case.tangents(weights, 1e-4)
    for block, found in case.blocks(exact).items():
        expected = case.blocks(numeric)[block]
        if block == "Tq" and ("sun" not in name or name == "uncoupled sun"):
            assert not found.any()
            assert not expected.any()
            continue
        # rounding of a force by its step, 1e-16 / 1e-4, where elastic forces of 1e5 cancel, and (1e-4)^4 of the difference
        assert np.abs(found).max() > 0
        assert np.abs(found - expected).max() <= 1e-7 * np.abs(expected).max(), block


def test_tangent_with_multipliers():
    case = Case(system_of("sun", joint=True))
    assert case.equations.n_lam > 0
    exact, numeric = case.tangents(Weights(1.0, 30.0, 0.0, 0.4), 1e-4)
    for block, found in case.blocks(exact).items():
        assert np.abs(found - case.blocks(numeric)[block]).max() <= 1e-7 * np.abs(found).max(), block


def test_tangent_where_light_comes_edge_on():
    """The switch between the sides turns within a thousandth: the difference must be taken within that."""
    system = system_of("nothing", rotation=(0.0, 0.0, 0.0))
    plate = system.bodies[0]
    system.add(lm.SolarFlux("item", plate, (1.0, 0.2, 0.0), (0.8, 0.3)))
    case = Case(system, size=1e-5)
    exact, numeric = case.tangents(Weights(), 3e-6)
    found, expected = case.blocks(exact)["Tq"], case.blocks(numeric)["Tq"]
    # slopes of one element turn its normal by some ten steps: (3e-5 / 1e-3)^4
    assert np.abs(found - expected).max() <= 1e-5 * np.abs(expected).max()


def test_force_of_a_heated_shell_is_the_derivative_of_its_energy():
    case = Case(system_of("nothing", damping=0.0))
    model, q = case.model, case.equations.coordinates(case.point)
    n = model.n_motion

    def energy(x):
        return sum(block.energy(T, x) for block in model.forces)

    force = case.equations.forces(T, q, np.zeros_like(q))[:n] * model.magnitude[:n]
    numeric = np.zeros(n)
    for i in range(n):
        d = np.zeros_like(q)
        d[i] = 1e-4 * model.magnitude[i]
        near, far = energy(q + d) - energy(q - d), energy(q + 2 * d) - energy(q - 2 * d)
        numeric[i] = (8 * near - far) / 12e-4
    # rounding of the energy by the step, 1e-16 / 1e-4, in states whose energy is that of the largest force times 0.03
    assert np.abs(force - numeric).max() <= 1e-9 * np.abs(force).max()


@pytest.mark.parametrize("name", [name for name in ITEMS if name not in ("sun that turns", "uncoupled sun", "held edge")])
def test_rotation_of_plate_and_light_changes_nothing(name):
    R, shift = matrix_from_vector(np.array([0.7, 2.1, -1.3])), np.array([0.4, -3.0, 0.2])
    system = system_of(name)
    turned = lm.System()
    for item in system.declarations:
        if isinstance(item, lm.SolarFlux):
            item = lm.SolarFlux(item.name, item.on, tuple(R @ item.direction), item.absorptivity, profile=item.profile)
        turned.add(item)
    case, other = Case(system), Case(turned)
    n = case.n
    q, v = case.point.u, case.point.ud
    moved = case.model.vectors(q) @ R.T + np.where(case.model.is_position[:, None], shift, 0.0)
    q2 = np.concatenate([moved.reshape(-1), q[n:]])
    v2 = np.concatenate([(case.model.vectors(v) @ R.T).reshape(-1), v[n:]])
    point, no = case.point, np.zeros(0)
    r = case.equations.residual(point)[0]
    r2 = other.equations.residual(Point(T, q2, v2, np.zeros_like(q2), no))[0]
    weighed = r[:n] * case.magnitude[:n]
    back = (r2[:n].reshape(-1, 3) @ R).reshape(-1) * case.magnitude[:n]
    assert np.abs(back - weighed).max() <= 1e-10 * np.abs(weighed).max()  # membrane forces lose digits by the shift
    np.testing.assert_allclose(r2[n:], r[n:], atol=1e-11 * np.abs(r[n:]).max())
    states = case.equations.state(point), other.equations.state(Point(T, q2, v2, np.zeros_like(q2), no))
    for one, two in zip(case.model.signals, other.model.signals, strict=True):
        if one.unit in ("W", "K", "K/m", "J", "1"):
            assert two.evaluate(states[1]) == pytest.approx(one.evaluate(states[0]), rel=1e-11), one.name


@pytest.mark.parametrize("name", [name for name in ITEMS if name not in ("nothing", "held edge")])
def test_recorded_heat_is_what_the_plate_receives(name):
    """The heat of an item is minus the sum of its rows for T_N."""
    case, plain = Case(system_of(name)), Case(system_of("nothing"))
    given = (case.equations.residual(case.point)[0] - plain.equations.residual(plain.point)[0])[case.n :]
    (signal,) = [signal for signal in case.model.signals if signal.name == "item.heat"]
    heat = signal.evaluate(case.equations.state(case.point))
    assert heat == pytest.approx(-given[::2].sum(), rel=1e-9)  # less the capacity's heat, which is of another size
    assert abs(heat) > 1.0
