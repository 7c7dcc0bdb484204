"""Derivatives by parameters against differences of whole solutions."""

from __future__ import annotations

import functools
from collections import Counter
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
import pytest

import lamella as lm
from lamella import dofs
from lamella.assembly import product
from lamella.assembly.equations import Equations
from lamella.assembly.point import STATIC, Weights
from lamella.assembly.product import TangentProduct
from lamella.differentiation import chain, exact_matrix, motion
from lamella.differentiation.exact_matrix import ExactMatrix
from lamella.differentiation.motion import DifferentiatedAlpha, DifferentiatedStepper, Guess
from lamella.differentiation.neighbours import neighbours_of
from lamella.differentiation.solution import PointDerivative
from lamella.errors import DeclarationError
from lamella.roles import Floats
from lamella.signals import system_signals
from lamella.solve.linear import linear_solver
from lamella.solve.turned import TurnedSolver, Vectors
from lamella.solve.turned_nodes import turned_solver
from lamella.state import State
from lamella.sweep.outputs import StudyOutput

TIGHT = lm.Newton(tolerance=1e-12, keep=0.0, line_search=True)
SPAN = 1e-3
"""Of differences of fourth order, as a share of the parameter: it leaves 1e-12 of the fifth derivative, and of what Newton's
tolerance leaves of the value 1e-9."""
CLOSE = 1e-6
"""Residuals are differenced to 1e-10, and the stiffness of the membrane over that of bending magnifies this by some 1e3."""


def panel(
    thickness: float = 2e-3, angle: float = 30.0, force: float = -20.0, E: float = 7e10, length: float = 0.5, tilt: float = 0.0
) -> lm.System:
    """A cantilever that bends far."""
    ply = lm.Lamina(E1=2 * E, E2=0.1 * E, G12=0.05 * E, nu12=0.3, rho=1600)
    system = lm.System()
    layup = lm.Laminate(ply, angles=(angle, 0.0, 90.0, -angle), thickness=thickness)
    plate = system.add(lm.Plate("plate", (length, 0.2), (3, 2), layup, rotation=(0.0, tilt, 0.0)))
    tip = plate.marker("tip", length, 0.1)
    system.add(lm.Clamp("root", plate.edge("x-")))
    system.add(lm.PointForce("load", tip, (0.0, 0.0, force)))
    return system


def mechanism(torque: float = 2.0, thickness: float = 2e-3, length: float = 0.4, stiffness: float = 3.0) -> lm.System:
    """A rigid hub on a bearing with a spring and a flexible blade; a torque begins at 20 ms. The bearing has multipliers."""
    layup = lm.Laminate(lm.Isotropic(E=7e10, nu=0.3, rho=2700.0), thickness=thickness)
    system = lm.System()
    ground = system.add(lm.Ground())
    hub = system.add(lm.RigidBody("hub", mass=0.5, inertia=(2e-3, 2e-3, 2e-3)))
    place, turn = (0.05, 0.0, -0.025), (0.5 * np.pi, 0.0, 0.0)
    blade = system.add(lm.Plate("blade", (length, 0.05), (2, 1), layup, position=place, rotation=turn, damping=2e-4))
    tip = blade.marker("tip", length, 0.025)
    pin = system.add(lm.RevoluteJoint("pin", ground.origin, hub.origin, axis=(0, 0, 1)))
    system.add(lm.TorsionSpring("spring", pin, stiffness=stiffness, damping=0.01))
    system.add(lm.FixedJoint("root", hub.marker("rim", 0.05, 0, 0), blade.edge("x-")))
    system.add(lm.PointMoment("motor", hub.origin, (0, 0, torque), profile=lm.Step(at=0.02)))
    system.add(lm.PointForce("push", tip, (0.0, torque, 0.3)))
    return system


def differences(values: Callable[..., Floats], at: Mapping[str, float], size: float = 1.0) -> Floats:
    """Differences of fourth order, outputs by parameters."""
    columns = []
    for name, value in at.items():
        h = SPAN * (abs(value) or size)
        f = {k: values(**{**at, name: value + k * h}) for k in (-2, -1, 1, 2)}
        columns.append((8.0 * (f[1] - f[-1]) - (f[2] - f[-2])) / (12.0 * h))
    return np.array(columns).T


def test_static_and_modal_outputs() -> None:
    signal = lm.SignalOutput
    outputs = {
        "z": signal("tip.position", component="z", analysis="still"),
        "away": signal("tip.position", component="norm", analysis="still"),
        "torque": signal("root.torque", component="y", analysis="still"),
        "energy": signal("energy.strain", analysis="still"),
        "mass": lm.MassOutput(),
        "first": lm.ShapeOutput(1, analysis="free"),
        "loaded": lm.ShapeOutput(2, analysis="bent"),
    }
    analyses = (
        lm.Statics("still", newton=TIGHT),
        lm.NaturalModes("free", count=1),
        lm.NaturalModes("bent", count=2, about="still"),
    )
    at = {"thickness": 2e-3, "angle": 30.0, "force": -20.0, "E": 7e10, "length": 0.5, "tilt": 0.0}
    found = lm.gradient(panel, at, outputs, analyses=analyses)

    def values(**parameters: float) -> Floats:
        system = panel(**parameters)
        still = lm.equilibrium(system, newton=TIGHT)
        first, loaded = lm.modes(system, 1), lm.modes(system, 2, state=still.final)
        z = still["tip.position"].values
        mass = 1600 * parameters["length"] * 0.2 * parameters["thickness"]
        torque, energy = still["root.torque"].values[1], float(still["energy.strain"])
        return np.array([z[2], np.linalg.norm(z), torque, energy, mass, first.frequencies[0], loaded.frequencies[1]])

    expected, base = differences(values, at), values(**at)
    np.testing.assert_allclose(list(found.values.values()), base, rtol=1e-9)
    scale = np.abs(base)[:, None] / np.array([abs(value) or 1.0 for value in at.values()])  # of a change by the whole value
    np.testing.assert_array_less(np.abs(found.matrix - expected) / scale, CLOSE)
    assert np.abs(expected[0] / scale[0]).min() > 1e-2  # the deflection depends on all of them


def guided(force: float = 6.0, length: float = 0.5, width: float = 0.2) -> lm.System:
    """A cantilever with loads whose stiffness is not symmetric, at a point that moves with its sizes."""
    system = lm.System()
    sheet = lm.Laminate(lm.Isotropic(E=7e10, nu=0.3, rho=2700.0), thickness=2e-3)
    plate = system.add(lm.Plate("plate", (length, width), (3, 2), sheet))
    tip = plate.marker("tip", 0.9 * length, 0.3 * width)
    system.add(lm.Clamp("root", plate.edge("x-")))
    system.add(lm.PointForce("load", tip, (0.0, 0.0, force), follower=True))
    system.add(lm.PointMoment("turn", tip, (0.5, -0.2 * force, 0.7), follower=True))
    return system


def test_frequencies_under_loads_without_a_potential() -> None:
    outputs = {"z": lm.SignalOutput("tip.position", component="z"), "first": lm.ShapeOutput(1), "third": lm.ShapeOutput(3)}
    at = {"force": 6.0, "length": 0.5, "width": 0.2}
    analyses = (lm.Statics("still", newton=TIGHT), lm.NaturalModes("bent", count=3, about="still"))
    found = lm.gradient(guided, at, outputs, analyses=analyses)

    def values(**parameters: float) -> Floats:
        system = guided(**parameters)
        still = lm.equilibrium(system, newton=TIGHT)
        frequencies = lm.modes(system, 3, state=still.final).frequencies
        return np.array([still["tip.position"].values[2], frequencies[0], frequencies[2]])

    expected, base = differences(values, at), values(**at)
    scale = np.abs(base)[:, None] / np.array(list(at.values()))
    np.testing.assert_array_less(np.abs(found.matrix - expected) / scale, CLOSE)


def test_motion_of_a_mechanism() -> None:
    method = lm.GeneralizedAlpha(dt=2e-3, rho_inf=0.8, newton=lm.Newton(tolerance=1e-12, keep=0.0, max_iterations=50))
    outputs = {
        "y": lm.SignalOutput("tip.position", component="y"),
        "z": lm.SignalOutput("tip.position", component="z", statistic="rms"),
        "angle": lm.SignalOutput("pin.angle", statistic="max"),
        "root": lm.SignalOutput("root.torque", component="z", statistic="mean", start=0.01, end=0.04),
        "spin": lm.SignalOutput("hub.angular_velocity", component="z", statistic="std"),
    }
    at = {"torque": 2.0, "thickness": 2e-3, "length": 0.4, "stiffness": 3.0}
    found = lm.gradient(mechanism, at, outputs, analyses=(lm.Motion("swing", t_end=0.05, integrator=method),))

    def values(**parameters: float) -> Floats:
        run = lm.simulate(mechanism(**parameters), 0.05, method)
        return np.array([output.value(run) for output in outputs.values()])

    expected, base = differences(values, at), values(**at)
    np.testing.assert_allclose(list(found.values.values()), base, rtol=1e-9)
    scale = np.abs(base)[:, None] / np.array(list(at.values()))
    np.testing.assert_array_less(np.abs(found.matrix - expected) / scale, CLOSE)
    assert np.abs(expected[0] / scale[0]).min() > 1e-3


def heated(k: float = 5.0, damping: float = 2e-3) -> lm.System:
    """A panel that the sun bends: temperatures are coordinates, and the matrix is unsymmetric."""
    sheet = lm.Isotropic(E=7e10, nu=0.3, rho=2700.0, alpha=2.3e-5, k=k, c=900.0)
    system = lm.System()
    plate = system.add(lm.Plate("plate", (1.0, 0.2), (2, 1), lm.Laminate(sheet, thickness=2e-3), damping=damping))
    plate.marker("tip", 1.0, 0.1)
    system.add(lm.Clamp("root", plate.edge("x-"), kind="restrained"))
    system.add(lm.TemperatureField("heat", plate))
    system.add(lm.SolarFlux("sun", plate, direction=(0.6, 0.0, -0.8), absorptivity=0.8, constant=1361.0))
    return system


def test_motion_with_heat() -> None:
    method = lm.GeneralizedAlpha(dt=2e-2, rho_inf=0.8, newton=lm.Newton(tolerance=1e-12, keep=0.0, max_iterations=50))
    outputs = {"z": lm.SignalOutput("tip.position", component="z"), "T_M": lm.SignalOutput("tip.T_M", statistic="mean")}
    at = {"k": 5.0, "damping": 2e-3}
    found = lm.gradient(heated, at, outputs, analyses=(lm.Motion("swing", t_end=0.6, integrator=method),))

    def values(**parameters: float) -> Floats:
        run = lm.simulate(heated(**parameters), 0.6, method)
        return np.array([output.value(run) for output in outputs.values()])

    expected, base = differences(values, at), values(**at)
    np.testing.assert_array_less(np.abs(found.matrix - expected) * np.array(list(at.values())) / np.abs(base)[:, None], CLOSE)
    assert np.abs(expected[:, 0] * 5.0 / base).min() > 1e-2


def damped(
    thickness: float = 2e-3,
    damping: float = 1e-3,
    force: float = -20.0,
    E: float = 7e10,
    length: float = 0.5,
    mesh: tuple[int, int] = (3, 2),
) -> lm.System:
    """A damped cantilever that swings far: the matrix is nearly symmetric."""
    system = lm.System()
    layup = lm.Laminate(lm.Isotropic(E=E, nu=0.3, rho=2700.0), thickness=thickness)
    plate = system.add(lm.Plate("plate", (length, 0.2), mesh, layup, damping=damping))
    tip = plate.marker("tip", 0.4, 0.1)
    system.add(lm.Clamp("root", plate.edge("x-")))
    system.add(lm.PointForce("load", tip, (0.0, 0.0, force)))
    return system


@pytest.mark.parametrize("damping", [1e-3, 1e-1])
def test_motion_of_a_damped_plate(damping: float, monkeypatch: pytest.MonkeyPatch) -> None:
    method = lm.GeneralizedAlpha(dt=1e-3, rho_inf=0.8, newton=lm.Newton(tolerance=1e-12, keep=0.0, max_iterations=50))
    swing = (lm.Motion("swing", t_end=0.04, integrator=method),)
    outputs = {
        "z": lm.SignalOutput("tip.position", component="z"),
        "x": lm.SignalOutput("tip.position", component="x", statistic="mean"),
        "root": lm.SignalOutput("root.torque", component="y", statistic="rms"),
        "sinking": lm.SignalOutput("tip.position", component="z", statistic="slope", end=0.02),
        "fastest": lm.SignalOutput("tip.velocity", component="norm", statistic="max"),
        "speed": lm.SignalOutput("tip.velocity", component="norm", statistic="rms"),  # which begins at rest
    }
    at = {"E": 7e10, "damping": damping, "length": 0.5}
    found = lm.gradient(damped, at, outputs, analyses=swing)

    def values(**parameters: float) -> Floats:
        run = lm.simulate(damped(**parameters), 0.04, method)
        return np.array([output.value(run) for output in outputs.values()])

    expected, base = differences(values, at), values(**at)
    scale = np.abs(base)[:, None] / np.array(list(at.values()))
    np.testing.assert_array_less(np.abs(found.matrix - expected) / scale, CLOSE)
    assert np.abs(expected[0] / scale[0]).min() > 1e-3
    for few in (9, 3):  # by products, and by a factorisation L U
        monkeypatch.setattr(chain, "FEW", few)
        several = lm.gradient(damped, {**at, "force": -20.0, "thickness": 2e-3}, outputs, analyses=swing)
        np.testing.assert_array_less(np.abs(found.matrix - several.matrix[:, :3]) / scale, CLOSE)


def test_run_with_derivatives_goes_on_with_their_matrices() -> None:
    method = lm.GeneralizedAlpha(dt=1e-3, rho_inf=0.8)
    equations = Equations(damped(damping=0.0).compile())
    force = neighbours_of("force", equations, -20.0, 20.0, lambda force: damped(damping=0.0, force=force))
    alone = lm.simulate(equations, 0.1, method)
    along = lm.simulate(equations, 0.1, DifferentiatedAlpha(method, [force], None, lambda *_: None))
    assert along.statistics.factorisations <= 0.2 * alone.statistics.factorisations
    assert along.statistics.newton_iterations <= alone.statistics.newton_iterations
    np.testing.assert_allclose(along["tip.position"].values, alone["tip.position"].values, atol=1e-5)  # 0.5 m long


def renewals(monkeypatch: pytest.MonkeyPatch) -> list[Any]:
    """Where derivatives factorise matrices of their own."""
    found, factorise = [], ExactMatrix.factorise

    def counted(self: ExactMatrix, *where: Any) -> None:
        found.append(where)
        factorise(self, *where)

    monkeypatch.setattr(ExactMatrix, "factorise", counted)
    return found


def test_few_matrices_serve_a_run_with_derivatives(monkeypatch: pytest.MonkeyPatch) -> None:
    """Where a step with an earlier matrix takes fewer products than one with its own costs: one in five steps or fewer."""
    method, renewed = lm.GeneralizedAlpha(dt=1e-3, rho_inf=0.8), renewals(monkeypatch)
    plate = functools.partial(damped, thickness=4e-3, damping=0.0, mesh=(6, 4))
    equations = Equations(plate().compile())
    force = neighbours_of("force", equations, -20.0, 20.0, lambda force: plate(force=force))
    alone = lm.simulate(equations, 0.1, method)
    along = lm.simulate(equations, 0.1, DifferentiatedAlpha(method, [force], None, lambda *_: None))
    assert along.statistics.factorisations + len(renewed) <= 0.25 * along.statistics.steps
    assert along.statistics.newton_iterations <= alone.statistics.newton_iterations


def test_few_matrices_serve_a_heated_plate(monkeypatch: pytest.MonkeyPatch) -> None:
    """Although its matrix is unsymmetric, and what temperatures add to it is listed entry by entry."""
    renewed = renewals(monkeypatch)
    equations = Equations(heated().compile())
    assert equations.multiplies
    assert not equations.symmetric
    k = neighbours_of("k", equations, 5.0, 5.0, lambda k: heated(k=k))
    run = lm.simulate(equations, 1.0, DifferentiatedAlpha(lm.GeneralizedAlpha(dt=1e-2), [k], None, lambda *_: None))
    assert len(renewed) <= 0.2 * run.statistics.steps


def counted_work(monkeypatch: pytest.MonkeyPatch) -> Counter[str]:
    """Matrices of their own and products that derivatives take."""
    counts = Counter[str]()
    for name in ("factorise", "_rest"):
        call = getattr(ExactMatrix, name)

        def counted(self: ExactMatrix, *given: Any, name: str = name, call: Callable[..., Any] = call) -> Any:
            counts[name] += 1
            return call(self, *given)

        monkeypatch.setattr(ExactMatrix, name, counted)
    return counts


@pytest.mark.parametrize("thickness", [1e-3, 2e-3, 5e-3])
def test_matrices_of_derivatives_pay(monkeypatch: pytest.MonkeyPatch, thickness: float) -> None:
    """Counted in products, derivatives cost no more than with a matrix in each step, or with none but the first.

    But for a tenth: steps without one are tried now and then, which take twice to four times as many here.
    """
    method, plate = lm.GeneralizedAlpha(dt=1e-3, rho_inf=0.8), functools.partial(damped, damping=0.0, thickness=thickness)
    equations, counts = Equations(plate().compile()), counted_work(monkeypatch)
    force = neighbours_of("force", equations, -20.0, 20.0, lambda force: plate(force=force))

    def cost() -> float:
        counts.clear()
        lm.simulate(equations, 0.1, DifferentiatedAlpha(method, [force], None, lambda *_: None))
        return counts["_rest"] + per_matrix * counts["factorise"]

    per_matrix = exact_matrix._products_for(linear_solver(equations.matrix.pattern))
    own = cost()
    monkeypatch.setattr(exact_matrix, "_products_for", lambda _: 1e6)
    seldom = cost()
    monkeypatch.setattr(ExactMatrix, "follow", lambda self, point, weights, _: self.factorise(point, weights))
    always = cost()
    assert counts["factorise"] >= 100
    assert own <= 1.1 * min(seldom, always), (own, seldom, always)


def test_derivatives_by_a_length_are_measured_beside_the_stretch_of_the_membrane(monkeypatch: pytest.MonkeyPatch) -> None:
    """As it is at the start, turned with the nodes: with the same matrices this saves a product in ten and more."""
    plate = functools.partial(damped, thickness=4e-3, damping=0.0, mesh=(6, 4))
    equations, counts, found = Equations(plate().compile()), counted_work(monkeypatch), []
    length = neighbours_of("length", equations, 0.5, 0.5, lambda length: plate(length=length))
    alpha = lm.GeneralizedAlpha(dt=1e-3, newton=lm.Newton(tolerance=1e-8, max_iterations=50, keep=0.6))
    monkeypatch.setattr(exact_matrix, "_products_for", lambda _: 1e6)
    for guess in (DifferentiatedStepper._from_first, lambda *_: None):
        monkeypatch.setattr(DifferentiatedStepper, "_from_first", guess)
        counts.clear()
        last: list[PointDerivative] = []
        method = DifferentiatedAlpha(alpha, [length], None, lambda _, known, last=last: last.extend(known))
        lm.simulate(equations, 0.05, method)
        found.append((counts["_rest"], last[-1].u / equations.magnitude))
    (products, u), (from_zero, u_from_zero) = found
    assert products <= 0.9 * from_zero
    np.testing.assert_allclose(u, u_from_zero, atol=1e-6 * np.abs(u).max())


def test_derivatives_without_damping_begin_with_the_estimate(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of which a step leaves a thousandth: with the same matrices this saves a fourth of the substitutions."""
    plate = functools.partial(damped, thickness=4e-3, damping=0.0, mesh=(6, 4))
    equations, counts, found = Equations(plate().compile()), counted_work(monkeypatch), []
    force = neighbours_of("force", equations, -20.0, 20.0, lambda force: plate(force=force))
    alpha = lm.GeneralizedAlpha(dt=1e-3)
    monkeypatch.setattr(exact_matrix, "_products_for", lambda _: 1e6)

    def substituted(self: TurnedSolver, *given: Floats, call: Callable[..., Any] = TurnedSolver.solve) -> Any:
        counts["solve"] += 1
        return call(self, *given)

    monkeypatch.setattr(TurnedSolver, "solve", substituted)
    lm.simulate(equations, 0.05, alpha)
    alone = counts["solve"]
    for guess in (DifferentiatedStepper._near, lambda *_: Guess(None)):
        monkeypatch.setattr(DifferentiatedStepper, "_near", guess)
        counts.clear()
        last: list[PointDerivative] = []
        lm.simulate(equations, 0.05, DifferentiatedAlpha(alpha, [force], None, lambda _, known, last=last: last.extend(known)))
        found.append((counts["_rest"], counts["solve"] - alone, last[-1].u / equations.magnitude))
    (products, substitutions, u), (from_zero, after_zero, u_from_zero) = found
    assert products <= from_zero
    assert substitutions <= 0.75 * after_zero
    np.testing.assert_allclose(u, u_from_zero, atol=1e-3 * np.abs(u).max())


@pytest.mark.parametrize("damping", [0.0, 1e-3])
def test_derivatives_are_the_same_where_products_are_never_enough(damping: float, monkeypatch: pytest.MonkeyPatch) -> None:
    """Each step is then solved by the exact matrix, which a damped plate lays out beside a symmetric one."""
    alpha = lm.GeneralizedAlpha(dt=1e-3, newton=lm.Newton(tolerance=1e-11, max_iterations=50, keep=0.6))
    swing, tip = (lm.Motion("swing", 0.03, alpha),), {"tip": lm.SignalOutput("tip.position", component="z")}
    at, found = {"force": -20.0, "E": 7e10, "length": 0.5}, []
    for most in (exact_matrix.MOST, 0):
        monkeypatch.setattr(exact_matrix, "MOST", most)
        found.append(lm.gradient(functools.partial(damped, damping=damping), at, tip, analyses=swing).matrix)
    np.testing.assert_allclose(*found, rtol=1e-7)


def test_a_heated_panel_is_differentiated_at_the_tolerance_by_default() -> None:
    """Newton's tolerance leaves 1e-5; measured by energies of motion and heat together, what a step lacked left 0.03."""

    def found(**newton: float) -> float:
        settings = [f"analysis.flight.integrator.newton.{name}={value}" for name, value in newton.items()]
        tip = {"tip": lm.SignalOutput("tip.position", component="z", statistic="rms")}
        at = {"laminates.panel.thickness": "1.4 mm"}
        return float(lm.gradient("layup-optimisation", at, tip, settings=settings)["tip", "laminates.panel.thickness"])

    assert found() == pytest.approx(found(tolerance=1e-10, max_iterations=50, keep=0.6), rel=2e-4)


@pytest.mark.parametrize("heated", [False, True])
def test_energies_of_heat_are_not_added_to_those_of_motion(heated: bool) -> None:
    """A plate with temperatures that motion does not change has a symmetric matrix, whose parts have different units."""
    ply = lm.Lamina(E1=181e9, E2=10.3e9, G12=7.7e9, nu12=0.28, rho=1560.0, alpha1=0.0, alpha2=3e-5, k1=5.0, k2=0.7, c=900.0)
    system = lm.System()
    plate = system.add(lm.Plate("plate", (1.0, 0.5), (3, 2), lm.Laminate(ply, angles=(0.0, 90.0, 0.0), thickness=4e-3)))
    system.add(lm.Clamp("root", plate.edge("x-")))
    if heated:
        system.add(lm.TemperatureField("heat", plate))
    equations = Equations(system.compile())
    assert ExactMatrix(equations).measure_by_energy(True) == (not heated)


def test_run_is_the_same_to_the_last_digit_where_derivatives_need_no_matrix_of_their_own(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(exact_matrix, "_products_for", lambda _: 1e6)
    method = lm.GeneralizedAlpha(dt=1e-3, rho_inf=0.8)
    equations = Equations(damped().compile())
    force = neighbours_of("force", equations, -20.0, 20.0, lambda force: damped(force=force))
    alone = lm.simulate(equations, 0.03, method)
    along = lm.simulate(equations, 0.03, DifferentiatedAlpha(method, [force], None, lambda *_: None))
    np.testing.assert_array_equal(along.history("tip.position").values, alone.history("tip.position").values)


@pytest.mark.parametrize("component", ["x", "z"])
def test_signals_that_tell_their_derivatives_have_those_of_any_other(component: str, monkeypatch: pytest.MonkeyPatch) -> None:
    outputs = {
        "place": lm.SignalOutput("tip.position", component=component, statistic="mean"),
        "speed": lm.SignalOutput("tip.velocity", component=component, statistic="rms"),
        "force": lm.SignalOutput("root.force", component=component, statistic="mean"),
        "torque": lm.SignalOutput("root.torque", component="y", statistic="rms"),
        "energy": lm.SignalOutput("energy.kinetic", statistic="mean"),
    }
    swing = (lm.Motion("swing", t_end=0.02, integrator=lm.GeneralizedAlpha(dt=1e-3, rho_inf=0.8)),)
    at = {"force": -20.0, "length": 0.5}
    told = lm.gradient(damped, at, outputs, analyses=swing)
    signals = {signal.name: signal for signal in system_signals(Equations(damped().compile()))}
    assert all(signals[output.signal].derivative for output in outputs.values())
    monkeypatch.setattr(dofs.Signal, "derivative", property(lambda self: None, lambda self, value: None))
    monkeypatch.setattr(dofs.Signal, "by_tables", True)  # the same models beside
    np.testing.assert_allclose(told.matrix, lm.gradient(damped, at, outputs, analyses=swing).matrix, rtol=1e-6)


def sensed() -> lm.System:
    """A plate that a rigid hub carries in a bearing on the ground, and one that is clamped, with all that tells of them."""
    system = mechanism()
    plate = system.add(lm.Plate("plate", (0.5, 0.2), (2, 1), lm.Laminate(lm.Isotropic(7e10, 0.3, 2700.0), thickness=2e-3)))
    system.add(lm.Clamp("clamp", plate.edge("x-")))
    system.add(lm.MeanPosition("mean", plate))
    return system


def test_derivatives_that_signals_tell_are_those_of_their_values() -> None:
    """They are at most quadratic in the state, so that a central difference is exact but for rounding."""
    equations, rng = Equations(sensed().compile()), np.random.default_rng(5)
    sizes = [equations.model.n_q] * 3 + [equations.constraints.n_all, equations.model.n_q]
    parts, change = ([rng.standard_normal(n) for n in sizes] for _ in range(2))
    ends = [State(0.0, *(x + h * dx for x, dx in zip(parts, change, strict=True))) for h in (1.0, -1.0)]
    told = [signal for signal in system_signals(equations) if signal.derivative]
    for signal in told:
        found = signal.derivative(State(0.0, *parts), State(0.0, *change))
        above, below = (np.asarray(signal.evaluate(end)) for end in ends)
        np.testing.assert_allclose(found, 0.5 * (above - below), rtol=1e-11, atol=1e-11, err_msg=signal.name)
        assert np.any(found)
    kinds = {signal.name for signal in told}
    assert kinds >= {
        "hub.position",
        "hub.velocity",
        "mean.position",
        "mean.velocity",
        "clamp.force",
        "clamp.torque",
        "energy.kinetic",
    }


def square(thickness: float) -> lm.System:
    """A square plate whose second and third frequency are equal."""
    system = lm.System()
    plate = system.add(lm.Plate("plate", (1.0, 1.0), (2, 2), lm.Laminate(lm.Isotropic(7e10, 0.3, 2700.0), thickness=thickness)))
    for edge in ("x-", "x+", "y-", "y+"):
        system.add(lm.EdgeSupport(f"support {edge}", plate.edge(edge)))
    return system


@pytest.mark.parametrize(
    ("output", "said"),
    [
        (lm.ShapeOutput(2), "is repeated"),
        (lm.ShapeOutput(4), "computes 3"),
        (lm.SignalOutput("tip.position", component="z"), "analyses with signals are none"),
    ],
)
def test_outputs_without_a_derivative_are_refused(output: lm.ShapeOutput | lm.SignalOutput, said: str) -> None:
    with pytest.raises(DeclarationError, match=said):
        lm.gradient(square, {"thickness": 1e-2}, {"f": output}, analyses=(lm.NaturalModes("free", count=3),))


def test_what_is_not_differentiated_is_refused() -> None:
    tip = {"z": lm.SignalOutput("tip.position", component="z")}
    still = (lm.Statics("still"),)
    for output, said in (
        (lm.SignalOutput("work.loads"), "sums over the steps"),
        (lm.SignalOutput("tip.position", component="z", statistic="max"), "over load steps"),
        (lm.SignalOutput("top.position", component="z"), "did you mean"),
    ):
        with pytest.raises(DeclarationError, match=said):
            lm.gradient(panel, {"force": -20.0}, {"x": output}, analyses=still)
    swing = (lm.Motion("swing", 0.01, lm.GeneralizedAlpha(1e-3)),)
    for output, said in (
        (lm.SignalOutput("load.factor", statistic="std"), "std of a signal that does not vary"),
        (lm.SignalOutput("corner.position", component="y", statistic="std"), "std of a signal that does not vary"),
        (lm.SignalOutput("tip.velocity", component="norm", statistic="mean"), "length of a vector that vanishes"),
        (lm.SignalOutput("tip.velocity", component="norm", statistic="min"), "length of a vector that vanishes"),
    ):
        with pytest.raises(DeclarationError, match=said):
            lm.gradient(_held, {"force": -20.0}, {"x": output}, analyses=swing)
    with pytest.raises(DeclarationError, match="generalized_alpha"):
        lm.gradient(panel, {"force": -20.0}, tip, analyses=(lm.Motion("swing", 0.1, lm.BDF(1e-3)),))
    with pytest.raises(DeclarationError, match="moves a time at which a load"):
        lm.gradient(_late, {"late": 0.02}, tip, analyses=(lm.Motion("swing", 0.1, lm.GeneralizedAlpha(1e-3)),))
    with pytest.raises(DeclarationError, match="number of unknowns"):
        lm.gradient(_meshed, {"elements": 2.0}, tip, analyses=still, sizes={"elements": 1e5})


def _held(force: float) -> lm.System:
    system = panel(force=force)
    system.declarations[0].marker("corner", 0.0, 0.2)  # type: ignore[attr-defined]
    return system


def _late(late: float) -> lm.System:
    system = panel()
    plate = system.declarations[0]
    system.add(lm.PointForce("kick", plate.marker("middle", 0.2, 0.1), (0, 0, 1.0), profile=lm.Step(at=late)))  # type: ignore[attr-defined]
    return system


def _meshed(elements: float) -> lm.System:
    system = lm.System()
    layup = lm.Laminate(lm.Isotropic(7e10, 0.3, 2700.0), thickness=2e-3)
    plate = system.add(lm.Plate("plate", (0.5, 0.2), (round(elements), 1), layup))
    plate.marker("tip", 0.5, 0.1)
    system.add(lm.Clamp("root", plate.edge("x-")))
    return system


def test_models_beside_take_over_the_operators_of_supports() -> None:
    base = Equations(panel().compile())
    thicker = Equations(panel(thickness=3e-3).compile(), like=base)
    tilted = Equations(panel(tilt=0.1).compile(), like=base)
    alone = Equations(panel(thickness=3e-3).compile())
    assert thicker.elimination.T is base.elimination.T
    np.testing.assert_array_equal(thicker.elimination.constant, alone.elimination.constant)
    assert thicker.same_coordinates(base)
    assert not tilted.same_coordinates(base)  # the clamp holds the slopes at other values
    point = alone.start(at_rest=True)
    point.u += 1e-3 * np.sin(np.arange(len(point.u)))
    np.testing.assert_allclose(thicker.residual(point)[0], alone.residual(point)[0], rtol=1e-12)


@pytest.mark.parametrize(
    ("name", "output", "beside"),
    [
        ("thickness", lm.SignalOutput("power.dissipated"), 2),
        ("force", lm.SignalOutput("power.dissipated"), 2),
        ("length", lm.SignalOutput("power.dissipated"), 4),
        ("length", lm.MassOutput(), 2),
    ],
)
def test_a_parameter_asks_for_two_models_beside_and_one_that_moves_places_for_four_unless_tables_tell(
    name: str, output: StudyOutput, beside: int
) -> None:
    made = []

    def counted(**values: float) -> lm.System:
        made.append(values[name])
        return panel(**values)

    at = {"thickness": 2e-3, "force": -20.0, "length": 0.5}[name]
    lm.gradient(counted, {name: at}, {"output": output}, analyses=(lm.Statics("still"),))
    assert len(made) == len(set(made)) == 1 + beside


@pytest.mark.parametrize("made", [mechanism, heated])
def test_product_of_tangents_is_that_with_the_matrix(made: Callable[[], lm.System]) -> None:
    system = made()
    run = lm.simulate(system, 0.03, lm.GeneralizedAlpha(dt=2e-3))
    of = Equations(run.model, symmetric=False)
    state = run.final
    point = of.point_of(state, state.t)
    x = np.cos(np.arange(of.n_u))
    tangents = TangentProduct(of.forces, of.loads, of.constraints)
    tangents.look(of.start(), state.q, state.v, STATIC)  # what was seen before is forgotten
    tangents.look(point, state.q, state.v, STATIC)
    expected = of.matrix.pattern.matrix(of.linearise(point, STATIC)[2].copy()) @ x
    found = of.elimination.T.T @ tangents(of.expand(x))
    np.testing.assert_allclose(found, expected, atol=1e-12 * np.abs(expected).max())  # sums in another order


def test_runs_of_equations_are_those_of_their_model() -> None:
    model = panel().compile()
    equations = Equations(model)
    for _ in range(2):  # what they remember of one run does not reach the next
        still = lm.equilibrium(equations)
        np.testing.assert_array_equal(still["tip.position"].values, lm.equilibrium(model)["tip.position"].values)
    method = lm.GeneralizedAlpha(dt=2e-3)
    moved, fresh = (lm.simulate(what, 0.01, method).history("tip.position").values for what in (equations, model))
    np.testing.assert_array_equal(moved, fresh)


def test_product_is_that_with_the_exact_matrix() -> None:
    run = lm.simulate(mechanism(), 0.03, lm.GeneralizedAlpha(dt=2e-3))
    weights = Weights(1.0, 1e3, 1e6)
    near, exact = (Equations(run.model, symmetric=symmetric) for symmetric in (True, False))
    point = near.point_of(run.final, run.final.t)
    x = np.cos(np.arange(near.n_u))
    whole, part = (e.matrix.pattern.matrix(e.exact_matrix(point, weights)[0].copy()) @ x for e in (exact, near))
    assert np.abs(part - whole).max() > 1e-6 * np.abs(whole).max()  # dampers that move
    for equations in (near, exact):
        np.testing.assert_allclose(
            ExactMatrix(equations).product(point, weights)(x), whole, atol=1e-12 * np.abs(whole).max()
        )  # sums in another order


def no_lists(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let no tangent be multiplied entry by entry, so that no block takes another form."""
    monkeypatch.setattr(product, "LISTED", 0)
    monkeypatch.setattr(product, "FOR_EACH", 0)


def test_skew_part_is_what_the_symmetric_part_leaves_out(monkeypatch: pytest.MonkeyPatch) -> None:
    no_lists(monkeypatch)
    run = lm.simulate(mechanism(), 0.03, lm.GeneralizedAlpha(dt=2e-3))
    weights = Weights(1.0, 1e3, 1e6)
    near, exact = (Equations(run.model, symmetric=symmetric) for symmetric in (True, False))
    assert not near.multiplies
    point = near.point_of(run.final, run.final.t)
    x = np.cos(np.arange(near.n_u))
    whole, part = (e.matrix.pattern.matrix(e.exact_matrix(point, weights)[0].copy()) @ x for e in (exact, near))
    left_out = near.skew_part()(x)
    assert np.abs(left_out).max() > 1e-6 * np.abs(whole).max()  # dampers that move
    np.testing.assert_allclose(part + left_out, whole, atol=1e-12 * np.abs(whole).max())  # sums in another order


@pytest.mark.parametrize("listed", [False, True])
@pytest.mark.parametrize(("moving", "most"), [(False, 24), (True, 24), (True, 2)])
def test_matrix_of_dampers_is_solved_exactly(moving: bool, most: int, listed: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(exact_matrix, "MOST", most)  # two products are not enough, so that it is factorised after all
    if not listed:
        no_lists(monkeypatch)  # by the skew part instead of products of blocks
    run = lm.simulate(mechanism(), 0.03, lm.GeneralizedAlpha(dt=2e-3))
    near, exact = (Equations(run.model, symmetric=symmetric) for symmetric in (True, False))
    point = near.point_of(run.final, run.final.t)
    point.ud = point.ud if moving else np.zeros_like(point.ud)
    weights, r, s = Weights(1.0, 1e3, 1e6), np.sin(np.arange(near.n_u)), np.cos(np.arange(near.n_lam))
    found = []
    for equations in (near, exact):
        matrix = ExactMatrix(equations)
        matrix.factorise(point, weights)
        matrix.solve(np.cos(r), s)  # what it tells of the matrix serves the next one
        x, y = matrix.solve(r, s)
        found.append(np.concatenate([x / equations.magnitude, y]))
    size = np.abs(found[1][: near.n_u]).max()
    np.testing.assert_allclose(found[0][: near.n_u], found[1][: near.n_u], atol=1e-9 * size)  # rounding times the condition


@pytest.mark.parametrize("made", [functools.partial(damped, damping=0.0), damped, heated])
def test_factorisation_of_an_earlier_point_serves_a_later_one(
    made: Callable[[], lm.System], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(exact_matrix, "_products_for", lambda _: 0.0)
    method, weights = lm.GeneralizedAlpha(dt=1e-3, rho_inf=0.8), Weights(1.0, 2e3, 2e6)
    model = made().compile()
    near, exact = Equations(model), Equations(model, symmetric=False)
    early, late = (near.point_of(lm.simulate(model, t, method).final, t) for t in (0.03, 0.034))
    solver = turned_solver(linear_solver(near.matrix.pattern), Vectors(near))
    assert solver is not None
    held = ExactMatrix(near, solver)
    held.factorise(early, weights)
    solver.made_at(early.u)
    r, none = np.sin(np.arange(near.n_u)), np.zeros(0)
    held.solve(r, none)
    solver.turn(late.u)
    held.follow(late, weights, iterations=3)
    assert held.renewed is None
    found = held.solve(r, none)[0] / near.magnitude
    matrix = ExactMatrix(exact)
    matrix.factorise(late, weights)
    expected = matrix.solve(r, none)[0] / near.magnitude
    np.testing.assert_allclose(found, expected, atol=1e-9 * np.abs(expected).max())
    held.follow(early, weights, iterations=3)
    assert held.renewed is not None  # as the last point took too many products


def test_what_a_step_lacks_is_owed_to_the_next(monkeypatch: pytest.MonkeyPatch) -> None:
    """Derivatives without damping that lack a thousandth of their energy in each step: a push, which slow vibrations go on with,
    unless the next step pushes back. Of 200 steps it leaves a fifth.
    """
    plate = functools.partial(damped, thickness=4e-3, damping=0.0, mesh=(6, 4))
    alpha = lm.GeneralizedAlpha(dt=1e-3, newton=lm.Newton(tolerance=1e-9, max_iterations=50, keep=0.6))
    swing, tip = (lm.Motion("swing", 0.2, alpha),), {"tip": lm.SignalOutput("tip.position", component="z")}

    def derivative(share: float) -> float:
        monkeypatch.setattr(motion, "OF_ENERGY", share / alpha.newton.tolerance)
        return float(lm.gradient(plate, {"force": -20.0}, tip, analyses=swing)["tip", "force"])

    exact, errors = derivative(1e-12), []
    for paid in (DifferentiatedStepper._paid, lambda *_: [None]):
        monkeypatch.setattr(DifferentiatedStepper, "_paid", paid)
        errors.append(abs(derivative(1e-3) - exact))
    assert 0.0 < errors[0] < 0.5 * errors[1], errors
