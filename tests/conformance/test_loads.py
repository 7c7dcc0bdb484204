"""Every load of the package keeps the same rules: tangent, resultants, power, recorded factor, messages."""

from __future__ import annotations

import importlib
import pkgutil

import numpy as np
import pytest

import lamella.load
from lamella.body.ground import Ground
from lamella.body.plate import Plate
from lamella.dofs import Build
from lamella.errors import DeclarationError
from lamella.joint.support import EdgeSupport
from lamella.load.force import EdgeForce, PointForce, SurfaceForce
from lamella.load.gravity import Gravity
from lamella.load.moment import EdgeMoment, PointMoment
from lamella.load.pressure import Pressure
from lamella.material.isotropic import Isotropic
from lamella.material.laminate import Laminate
from lamella.math.profile import Constant, Ramp
from lamella.roles import Declaration
from lamella.state import State

RHO, H, SIZE, MESH = 700.0, 0.01, (1.5, 0.8), (2, 2)
VECTOR = (3.0, -2.0, 5.0)
PROFILE = Ramp(t_end=2.0)
T = 1.0  # where the profile is one half


def make_plate(**changes):
    section = Laminate(Isotropic(E=70e9, nu=0.3, rho=RHO), angles=(0.0,), thickness=H)
    given = {"size": SIZE, "mesh": MESH, "laminate": section, "position": (0.3, -0.2, 0.1), "rotation": (0.2, -0.5, 0.9)}
    return Plate("plate", **(given | changes))


LOADS = {
    "gravity": lambda plate: Gravity("load", VECTOR, PROFILE),
    "point force": lambda plate: PointForce("load", plate.marker("p", 1.1, 0.3), VECTOR, PROFILE),
    "following point force": lambda plate: PointForce("load", plate.marker("p", 1.1, 0.3), VECTOR, PROFILE, follower=True),
    "edge force": lambda plate: EdgeForce("load", plate.edge("y+"), VECTOR, PROFILE),
    "surface force": lambda plate: SurfaceForce("load", plate, VECTOR, PROFILE),
    "pressure": lambda plate: Pressure("load", plate, 4.0, PROFILE),
    "point moment": lambda plate: PointMoment("load", plate.marker("p", 1.1, 0.3), VECTOR, PROFILE),
    "point moment at a corner": lambda plate: PointMoment("load", plate.corner("x+y-"), VECTOR, PROFILE),
    "following point moment": lambda plate: PointMoment("load", plate.marker("p", 1.1, 0.3), VECTOR, PROFILE, follower=True),
    "edge moment": lambda plate: EdgeMoment("load", plate.edge("x+"), VECTOR, PROFILE),
    "following edge moment": lambda plate: EdgeMoment("load", plate.edge("y-"), VECTOR, PROFILE, follower=True),
    "edge bending x": lambda plate: EdgeMoment("load", plate.edge("x+"), bending=4.0, profile=PROFILE),
    "edge bending y": lambda plate: EdgeMoment("load", plate.edge("y+"), bending=4.0, profile=PROFILE),
}

# springs, stops and latches in test_springs.py, events in test_events.py, forces written in Python in test_user_force.py
TESTED_APART = {"SpringDamper", "TorsionSpring", "SlideSpring", "EndStop", "Latch", "Event", "SteadySpin", "UserForce"}
TESTED_APART.add("Controller")


class Case:
    """A compiled load with a randomly deformed state."""

    def __init__(self, name, seed=1):
        self.plate, self.build = make_plate(), Build()
        self.load = LOADS[name](self.plate)
        self.plate.contribute(self.build)
        self.load.contribute(self.build)
        (self.block,) = self.build.loads
        self.mesh = self.plate.compiled(self.build)
        self.is_position = np.concatenate(self.build.is_position)
        self.size = np.repeat(np.concatenate(self.build.magnitude), 3)
        self.rng = np.random.default_rng(seed)
        self.q = np.concatenate(self.build.q).reshape(-1) + 0.2 * self.size * self.rng.uniform(-1, 1, self.size.size)
        self.zero = np.zeros_like(self.q)

    def f(self, q):
        """The block's force in all coordinates."""
        buffer = np.full(len(self.block.f_coords), np.nan)
        self.block.force(T, q, self.zero, buffer)
        return self.scatter(buffer)

    def scatter(self, buffer):
        return np.bincount(self.block.f_coords, buffer * self.block.f_scale, minlength=self.q.size)

    def f_q(self, q, alpha_q=1.0):
        buffer, k = np.full(len(self.block.f_coords), np.nan), np.full(len(self.block.k_rows), np.nan)
        self.block.force_tangent(T, q, self.zero, alpha_q, 0.3, q, buffer, k)
        K = np.zeros((q.size, q.size))
        np.add.at(K, (self.block.k_rows, self.block.k_cols), k * self.block.k_scale)
        return self.scatter(buffer), K

    def points(self, where, n):
        """Points, weights and (r, r_x, r_y) at them: of the surface, an edge or a marker, n Gauss points per element."""
        places, weights = (0.5 * (1 + np.polynomial.legendre.leggauss(n)[0]), 0.5 * np.polynomial.legendre.leggauss(n)[1])
        cuts = [((np.arange(m)[:, None] + places) * length / m).reshape(-1) for length, m in zip(SIZE, MESH, strict=True)]
        shares = [np.tile(weights, m) * length / m for length, m in zip(SIZE, MESH, strict=True)]
        x, y = cuts
        if where == "surface":
            at = [(i, j, a * b) for i, a in zip(x, shares[0], strict=True) for j, b in zip(y, shares[1], strict=True)]
        elif where[0] == "x":
            at = [(SIZE[0] * (where[1] == "+"), j, b) for j, b in zip(y, shares[1], strict=True)]
        else:
            at = [(i, SIZE[1] * (where[1] == "+"), a) for i, a in zip(x, shares[0], strict=True)]
        vectors = self.q.reshape(-1, 3)
        rows = [self.mesh.locate((i, j)) for i, j, _ in at]
        r = np.array([row.at(vectors) for row in rows])
        tangents = np.array([[row.slope_x @ vectors[row.vectors], row.slope_y @ vectors[row.vectors]] for row in rows])
        return np.array([w for *_, w in at]), r, tangents


def frame(a):
    """Axes t1, t2, n0 as columns, from the angles of the tangents in the plane; also for complex tangents (2, 3)."""
    e_1 = a[0] / np.sqrt(a[0] @ a[0])
    n = np.cross(a[0], a[1])
    n0 = n / np.sqrt(n @ n)
    e_2 = np.cross(n0, e_1)
    half = 0.5 * (np.arctan((a[1] @ e_2) / (a[1] @ e_1)) - np.pi / 2)  # mean angle of the turned tangents from e_1
    if np.real((a[1] @ e_2) / (a[1] @ e_1)) < 0:
        half = half + np.pi / 2
    t_1 = np.cos(half) * e_1 + np.sin(half) * e_2
    return np.stack([t_1, np.cross(n0, t_1), n0], axis=1)


def expected_resultants(name, case):
    """Force and torque about the origin that the load must have, by independent quadrature."""
    load = case.load
    nothing = np.zeros(3)
    if isinstance(load, PointForce | PointMoment):
        row, vectors = load.on.rows(case.build), case.q.reshape(-1, 3)
        if isinstance(load, PointForce):
            axes = load.on.frame(case.build, np.eye(3)).rotation(vectors) if load.follower else np.eye(3)
            return axes @ VECTOR, np.cross(row.at(vectors), axes @ VECTOR)
        a = np.array([row.slope_x @ vectors[row.vectors], row.slope_y @ vectors[row.vectors]])
        return nothing, frame(a) @ VECTOR if load.follower else np.array(VECTOR)
    if isinstance(load, EdgeMoment):
        w, _, a = case.points(load.on.side, 4)  # the load's own points: axes that turn along the edge have no exact rule
        if load.bending is not None:
            t = a[:, 1 if load.on.side[0] == "x" else 0]
            return nothing, load.bending * (w @ (t / np.linalg.norm(t, axis=1)[:, None]))
        return nothing, sum(
            w_i * (frame(a_i) @ VECTOR if load.follower else np.array(VECTOR)) for w_i, a_i in zip(w, a, strict=True)
        )
    w, r, a = case.points(load.on.side if isinstance(load, EdgeForce) else "surface", 6)
    density = np.array(VECTOR) * (RHO * H if isinstance(load, Gravity) else 1.0)
    forces = -4.0 * np.cross(a[:, 0], a[:, 1]) if isinstance(load, Pressure) else np.tile(density, (len(w), 1))
    return w @ forces, w @ np.cross(r, forces)


def test_every_load_of_the_package_has_a_case():
    kinds = set()
    for module in pkgutil.iter_modules(lamella.load.__path__, "lamella.load."):
        for item in vars(importlib.import_module(module.name)).values():
            if isinstance(item, type) and issubclass(item, Declaration) and item.__module__ == module.name:
                kinds.add(item.__name__)
    plate = make_plate()
    assert kinds == {type(make(plate)).__name__ for make in LOADS.values()} | TESTED_APART


@pytest.mark.parametrize("name", LOADS)
def test_a_load_whose_profile_is_zero_clears_its_buffers(name):
    case = Case(name)
    f, k = np.full(len(case.block.f_coords), np.nan), np.full(len(case.block.k_rows), np.nan)
    case.block.force_tangent(0.0, case.q, case.zero, 1.0, 0.3, case.q, f, k)
    assert not f.any()
    assert not k.any()
    f[:] = np.nan
    case.block.force(0.0, case.q, case.zero, f)
    assert not f.any()


@pytest.mark.parametrize("name", LOADS)
def test_tangent_is_the_derivative_of_the_force(name):
    case = Case(name)
    f, K = case.f_q(case.q, alpha_q=0.7)
    np.testing.assert_array_equal(f, case.f(case.q))
    numeric = np.zeros_like(K)
    for i in range(case.q.size):
        step = case.zero.copy()
        step[i] = 5e-4 * case.size[i]
        # fourth order: error (step)^4 d5f/dq5 / 30, some 1e-10 of the tangent in these wrinkled states
        near, far = case.f(case.q + step) - case.f(case.q - step), case.f(case.q + 2 * step) - case.f(case.q - 2 * step)
        numeric[:, i] = 0.7 * (8 * near - far) / (12 * step[i])
    scale = np.outer(case.size, case.size)  # work per relative change, the same for all kinds of coordinates
    assert np.abs((K - numeric) * scale).max() <= 1e-9 * max(np.abs(K * scale).max(), np.abs(f * case.size).max())


@pytest.mark.parametrize("name", LOADS)
@pytest.mark.parametrize("seed", [1, 2])
def test_virtual_translation_and_rotation_give_the_resultants(name, seed):
    case = Case(name, seed)
    Q = -case.f(case.q).reshape(-1, 3)
    force, torque = (0.5 * part for part in expected_resultants(name, case))  # the profile is 0.5 at T
    scale = np.abs(Q).max()
    np.testing.assert_allclose(Q[case.is_position].sum(axis=0), force, atol=1e-12 * scale)  # rounding of 144 terms
    np.testing.assert_allclose(np.cross(case.q.reshape(-1, 3), Q).sum(axis=0), torque, atol=1e-12 * scale)


@pytest.mark.parametrize("name", [name for name in LOADS if "moment" in name and "edge" not in name])
def test_power_of_a_moment_is_moment_times_angular_velocity_of_the_frame(name):
    case = Case(name)
    v = case.rng.normal(size=case.q.size)  # any velocity, not a rigid one
    row = case.load.on.rows(case.build)
    weights = np.array([row.slope_x, row.slope_y])
    a, rate = weights @ case.q.reshape(-1, 3)[row.vectors], weights @ v.reshape(-1, 3)[row.vectors]
    R, turn = frame(a), np.imag(frame(a + 1e-30j * rate)) / 1e-30 @ frame(a).T
    omega = np.array([turn[2, 1], turn[0, 2], turn[1, 0]])
    moment = 0.5 * (R @ VECTOR if case.load.follower else np.array(VECTOR))
    assert -case.f(case.q) @ v == pytest.approx(moment @ omega, rel=1e-12)


@pytest.mark.parametrize("name", ["point moment", "edge moment", "edge bending x"])
def test_power_on_a_spinning_plate(name):
    case = Case(name)
    q = np.concatenate(case.build.q)
    omega = np.array([0.4, -1.1, 0.7])
    power = -case.f(q.reshape(-1)) @ np.cross(omega, q).reshape(-1)
    edge = case.mesh.locate((SIZE[0], 0.0))
    moment = {"point moment": VECTOR, "edge moment": np.multiply(VECTOR, SIZE[1])}.get(
        name, 4.0 * SIZE[1] * (edge.slope_y @ q[edge.vectors])
    )
    assert power == pytest.approx(0.5 * omega @ moment, rel=1e-12)


def test_pressure_on_the_flat_plate_pushes_against_the_normal():
    case = Case("pressure")
    q = np.concatenate(case.build.q)
    normal = case.mesh.locate((0.1, 0.1)).normal(q)
    force = -case.f(q.reshape(-1)).reshape(-1, 3)[case.is_position].sum(axis=0)
    np.testing.assert_allclose(force, -0.5 * 4.0 * SIZE[0] * SIZE[1] * normal, rtol=1e-13)


def on_boundary(case):
    sides = [case.mesh.edge_nodes(side) for side in ("x-", "x+", "y-", "y+")]
    nodes = np.unique(np.concatenate(sides))
    return np.isin(np.arange(case.q.size) // 12, nodes)


def test_pressure_resultant_depends_on_the_boundary_alone():
    """The area vector of a surface is that of its boundary curve: what is inside cancels, if the integration is exact."""
    case = Case("pressure")
    flat = np.concatenate(case.build.q).reshape(-1)
    q = np.where(on_boundary(case), flat, case.q)
    total = [-case.f(state).reshape(-1, 3)[case.is_position].sum(axis=0) for state in (flat, q)]
    assert np.abs(q - flat).max() > 0.1
    np.testing.assert_allclose(total[1], total[0], atol=1e-13 * np.abs(total[0]).max() * 10)  # rounding


def test_pressure_tangent_is_symmetric_inside_a_held_boundary():
    case = Case("pressure")
    inside = ~on_boundary(case)
    K = case.f_q(case.q)[1]
    held = K[np.ix_(inside, inside)]
    assert np.abs(held).max() > 0
    assert np.abs(held - held.T).max() <= 1e-13 * np.abs(held).max()
    assert np.abs(K - K.T).max() > 1e-3 * np.abs(K).max()


@pytest.mark.parametrize(("sides", "symmetry"), [(("x-", "x+", "y-", "y+"), "nearly"), (("x-", "x+", "y-"), "none")])
def test_pressure_asks_for_an_unsymmetric_solver_only_with_a_free_edge(sides, symmetry):
    plate, build = make_plate(), Build()
    items = [plate, Pressure("load", plate, 4.0), *(EdgeSupport(side, plate.edge(side)) for side in sides)]
    for item in sorted(items, key=lambda item: item.order):
        item.contribute(build)
    assert build.loads[0].symmetry == symmetry


@pytest.mark.parametrize("name", LOADS)
def test_factor_is_recorded_with_the_load_factor_of_statics(name):
    case = Case(name)
    (signal,) = [signal for signal in case.build.signals if signal.name == "load.factor"]
    none = np.zeros(0)
    assert signal.evaluate(State(T, case.q, case.zero, case.zero, none, case.zero, factor=0.25)) == pytest.approx(0.125)


@pytest.mark.parametrize("name", LOADS)
def test_forces_are_finite_or_nan_never_an_exception_on_a_collapsed_plate(name):
    case = Case(name)
    with np.errstate(all="raise"):
        f, _ = case.f_q(case.zero)
    assert np.isnan(f).any() == ("moment" in name or "bending" in name)


MESSAGES = {
    "nan": (lambda plate: Pressure("push", plate, float("nan")), "Pressure 'push': pressure"),
    "unit": (lambda plate: Pressure("push", plate, "3 N"), "does not convert to Pa"),
    "not a plate": (lambda plate: Pressure("push", plate.edge("x-"), 3.0), "Pressure 'push': on"),
    "two components": (lambda plate: PointMoment("twist", plate.corner("x-y-"), (1.0, 2.0)), "PointMoment 'twist'"),
    "moment on an edge": (lambda plate: PointMoment("twist", plate.edge("x-"), VECTOR), "PointMoment 'twist': on"),
    "nothing": (lambda plate: EdgeMoment("roll", plate.edge("x-")), "EdgeMoment 'roll': neither 'moment' nor 'bending' is given"),
    "both": (lambda plate: EdgeMoment("roll", plate.edge("x-"), VECTOR, bending=1.0), "both 'moment' and 'bending' are given"),
    "unknown": (lambda plate: EdgeMoment("roll", plate.edge("x-"), VECTOR, follow=True), "unknown argument 'follow'"),
}


@pytest.mark.parametrize("name", MESSAGES)
def test_impossible_values_are_named(name):
    make, message = MESSAGES[name]
    with pytest.raises(DeclarationError) as error:
        make(make_plate())
    assert message in str(error.value)


def test_a_moment_needs_a_marker_with_tangents():
    load = PointMoment("twist", Ground().marker("post", 0.0, 0.0, 0.0), VECTOR)
    with pytest.raises(DeclarationError, match=r"PointMoment 'twist': ground\.post has no tangents to turn"):
        load.contribute(Build())


def test_units_are_converted():
    assert Pressure("push", make_plate(), "2 kPa").pressure == 2000.0
    assert EdgeMoment("roll", make_plate().edge("x+"), bending="3 N*m/m").bending == 3.0
    assert PointMoment("twist", make_plate().corner("x+y+"), (0, 0, "2 N*mm")).moment[2] == pytest.approx(2e-3)
    assert Pressure("push", make_plate(), 1.0).profile == Constant(1.0)
