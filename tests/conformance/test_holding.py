"""Reactions from what acts on held coordinates alone, of one state and of several side by side."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

import lamella as lm
from lamella.assembly.equations import Equations
from lamella.assembly.point import Point
from lamella.assembly.point_state import PointStack, reaction_at
from lamella.differentiation import signals
from lamella.differentiation.reactions import Reactions
from lamella.differentiation.signal_stack import stack_of
from lamella.roles import Floats
from lamella.signals import system_signals

STATES = 5
SHEET = lm.Laminate(lm.Isotropic(E=7e10, nu=0.3, rho=2700.0), thickness=2e-3)


def plate(kind: str = "clamped", **options: object) -> lm.System:
    """A plate of 5 x 3 elements whose edge is held."""
    system = lm.System()
    body = system.add(lm.Plate("plate", (0.5, 0.3), (5, 3), SHEET, rotation=(0.0, 0.2, 0.3), **options))
    if kind == "sliding":
        system.add(lm.EdgeSupport("root", body.edge("x-")))
    else:
        system.add(lm.Clamp("root", body.edge("x-")))
    system.add(lm.PointForce("load", body.marker("tip", 0.45, 0.1), (1.0, 2.0, -3.0)))
    return system


def plate_of(system: lm.System) -> lm.Plate:
    found = system.bodies[0]
    assert isinstance(found, lm.Plate)
    return found


def graded() -> lm.System:
    return plate(thickness_factors=((1.0, 1.1, 1.2, 1.3, 1.4),) * 3)


def heavy() -> lm.System:
    system = plate()
    system.add(lm.Gravity("weight", (0.0, 0.0, -9.81)))
    return system


def shaken_load() -> lm.System:
    """A load beside the support that changes with time."""
    system = plate()
    body = plate_of(system)
    system.add(
        lm.PointForce(
            "near", body.marker("beside", 0.02, 0.1), (1.0, 2.0, -3.0), lm.Harmonic(amplitude=1.0, frequency=2.0, mean=1.0)
        )
    )
    return system


def blown() -> lm.System:
    system = plate()
    system.add(lm.Pressure("wind", plate_of(system), 50.0))
    return system


def hinged() -> lm.System:
    """A hub turns about the corner that is held, in a joint with multipliers."""
    system = plate()
    one = plate_of(system)
    hub = system.add(lm.RigidBody("hub", mass=0.5, inertia=(0.1, 0.1, 0.1)))
    system.add(lm.RevoluteJoint("pin", one.corner("x-y-"), hub.origin, axis=(0.0, 0.0, 1.0)))
    return system


def heated() -> lm.System:
    system = lm.System()
    warm = lm.Laminate(lm.Isotropic(E=7e10, nu=0.3, rho=2700.0, alpha=2e-5, k=5.0, c=900.0), thickness=2e-3)
    body = system.add(lm.Plate("plate", (0.5, 0.3), (5, 3), warm, damping=1e-3))
    system.add(lm.Clamp("root", body.edge("x-")))
    system.add(lm.TemperatureField("heat", body))
    return system


APART = {
    "clamped": plate,
    "damped": lambda: plate(damping=1e-3),
    "sliding": lambda: plate("sliding"),
    "graded": graded,
    "in-plane forces at fewer points": lambda: plate(membrane_gauss=3),
    "damped, in-plane forces at fewer points": lambda: plate(membrane_gauss=3, damping=1e-3),
    "heavy": heavy,
}
"""Systems in which what acts at the support can be told apart."""
TOGETHER: dict[str, Callable[[], lm.System]] = {
    "linear": lambda: plate(strain="linear"),
    "damped by mass": lambda: plate(mass_damping=2.0),
    "thin elements": lambda: plate(element="plate36"),
    "a load that changes": shaken_load,
    "blown": blown,
    "hinged": hinged,
    "heated": heated,
}
"""Systems in which something acts there as a whole, depends on time, or couples it with what is far."""


def points_of(equations: Equations) -> list[Point]:
    """Points with coordinates, velocities, accelerations and multipliers by chance."""
    rng, found = np.random.default_rng(3), []
    for _ in range(STATES):
        point = equations.start()
        u, ud, udd = 1e-3 * rng.standard_normal((3, equations.n_u)) * equations.magnitude
        lam = rng.standard_normal(equations.n_lam)
        found.append(Point(0.1, point.u + u, point.ud + 10.0 * ud, point.udd + 1e3 * udd, lam))
    return found


def whole_reaction(equations: Equations, point: Point) -> Floats:
    """M a + f + Phi_q^T lam of everything, where supports hold coordinates."""
    q, v, a = equations.coordinates(point), equations.velocities(point), equations.accelerations(point)
    total = equations.loads(point.t, q, v) + equations.forces(point.t, q, v) + equations.mass.in_all(a)
    equations.constraints.add_force(point.t, q, point.lam, total)
    held = np.zeros(len(q))
    held[equations.elimination.held_coordinates] = 1.0
    return total * held


@pytest.mark.parametrize("made", [*APART.values(), *TOGETHER.values()], ids=[*APART, *TOGETHER])
def test_reactions_are_those_of_all_that_there_is(made: Callable[[], lm.System]) -> None:
    equations = Equations(made().compile())
    for point in points_of(equations):
        expected = whole_reaction(equations, point)
        found = equations.state(point).reaction
        np.testing.assert_allclose(found, expected, atol=1e-13 * np.abs(expected).max())
        assert np.abs(expected).max() > 1.0


@pytest.mark.parametrize("name", APART)
def test_states_side_by_side_have_the_reactions_of_each(name: str) -> None:
    equations = Equations(APART[name]().compile())
    points = points_of(equations)
    assert equations.holding.acting.forces.buffer.size < equations.forces.buffer.size
    stack = PointStack(equations, equations.holding.vectors, STATES, held=True)
    for _ in range(2):  # the second time in place of what was there
        for k, point in enumerate(points):
            stack.put(k, point)
        state = stack.state(0.1, 1.0, {"reaction": lambda state: reaction_at(equations, points[0], state, STATES)})
        singles = [equations.state(point) for point in points]
        near = (3 * equations.holding.vectors[:, None] + np.arange(3)).reshape(-1)
        for part in ("q", "v", "a"):
            np.testing.assert_array_equal(getattr(state, part)[:, near], [getattr(one, part)[near] for one in singles])
        expected = np.array([one.reaction for one in singles])
        np.testing.assert_allclose(state.reaction, expected, atol=1e-13 * np.abs(expected).max())
        stack.clear()


@pytest.mark.parametrize("name", TOGETHER)
def test_what_cannot_be_told_apart_has_no_states_side_by_side(name: str) -> None:
    holding = Equations(TOGETHER[name]().compile()).holding
    assert holding.stack(STATES) is None
    assert holding.stack(1) is holding


def swung(
    force: float = -3.0, length: float = 0.5, width: float = 0.3, thickness: float = 2e-3, damping: float = 0.0
) -> lm.System:
    """A plate that swings in a clamp, and its mean place."""
    system = lm.System()
    sheet = lm.Laminate(lm.Isotropic(E=7e10, nu=0.3, rho=2700.0), thickness=thickness)
    body = system.add(lm.Plate("plate", (length, width), (5, 3), sheet, damping=damping))
    system.add(lm.Clamp("root", body.edge("x-")))
    system.add(lm.PointForce("load", body.marker("tip", 0.9 * length, 0.3 * width), (1.0, 2.0, force)))
    system.add(lm.Gravity("weight", (0.0, 0.0, -9.81)))
    system.add(lm.MeanPosition("mean", body))
    return system


OUTPUTS = {
    "place": lm.SignalOutput("tip.position", component="z", statistic="rms"),
    "speed": lm.SignalOutput("tip.velocity", component="z", statistic="mean"),
    "mean place": lm.SignalOutput("mean.position", component="x", statistic="rms"),
    "mean speed": lm.SignalOutput("mean.velocity", component="z", statistic="rms"),
    "force": lm.SignalOutput("root.force", component="x", statistic="rms"),
    "torque": lm.SignalOutput("root.torque", component="y", statistic="std"),
}


@pytest.mark.parametrize("steps", [5, 32, 40])
@pytest.mark.parametrize("damping", [0.0, 1e-3])
def test_samples_evaluated_together_are_those_evaluated_one_by_one(
    damping: float, steps: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Beside signals that are evaluated one by one in any case; of few, of many, and of a last few that are left."""
    asked = {**OUTPUTS, "energy": lm.SignalOutput("energy.strain", statistic="mean")}
    at = {"force": -3.0, "length": 0.5, "width": 0.3, "thickness": 2e-3}
    swing = (lm.Motion("swing", t_end=steps * 1e-3, integrator=lm.GeneralizedAlpha(dt=1e-3, rho_inf=0.8)),)
    found, stacks, real = list[lm.Gradient](), list[object](), signals.stack_of

    def noted(*arguments: object) -> object:
        stacks.append(real(*arguments))  # type: ignore[arg-type]
        return stacks[-1]

    def system(force: float, length: float, width: float, thickness: float) -> lm.System:
        return swung(force, length, width, thickness, damping)

    for way in (noted, lambda *_: None):
        monkeypatch.setattr(signals, "stack_of", way)
        found.append(lm.gradient(system, at, asked, analyses=swing))
    assert next(stack for stack in stacks if stack).signals.keys() == {each.signal for each in OUTPUTS.values()}  # type: ignore[attr-defined]
    np.testing.assert_allclose([*found[0].values.values()], [*found[1].values.values()], rtol=1e-12)
    size = np.abs(found[1].matrix).max(axis=1, keepdims=True)
    np.testing.assert_allclose(found[0].matrix / size, found[1].matrix / size, atol=1e-11)


def dragged() -> lm.System:
    """A plate whose corner is moved."""
    system = plate()
    corner = plate_of(system).corner("x+y+")
    system.add(lm.PrescribedMotion("drag", corner, "z", lm.Ramp(t_end=0.1, end=1e-3)))
    return system


@pytest.mark.parametrize("made", [hinged, heated, blown, dragged, shaken_load])
def test_samples_wait_for_none_where_each_must_be_seen_by_itself(made: Callable[[], lm.System]) -> None:
    equations = Equations(made().compile())
    known = {signal.name: signal for signal in system_signals(equations)}
    stack = stack_of(equations, [], {"root.force": known["root.force"]}, Reactions(equations))
    assert stack is None


@pytest.mark.parametrize("analysis", ["still", "swing"])
def test_a_load_may_come_to_act_at_the_support(analysis: str) -> None:
    """At the end of the elements that are held one of the models beside has it there, and the other has not."""
    method = lm.GeneralizedAlpha(dt=1e-3, rho_inf=0.8)
    analyses = {"still": lm.Statics("still"), "swing": lm.Motion("swing", t_end=0.02, integrator=method)}
    statistic = "rms" if analysis == "swing" else "last"
    asked = {name: lm.SignalOutput(f"root.{name}", component="y", statistic=statistic) for name in ("force", "torque")}

    def found(place: float) -> Floats:
        def system(at: float) -> lm.System:
            made = lm.System()
            body = made.add(lm.Plate("plate", (0.5, 0.3), (5, 3), SHEET))
            made.add(lm.Clamp("root", body.edge("x-")))
            made.add(lm.PointForce("load", body.marker("tip", at, 0.1), (1.0, 2.0, -3.0)))
            return made

        return lm.gradient(system, {"at": place}, asked, analyses=(analyses[analysis],)).matrix[:, 0]

    beside = 0.5 * (found(0.1 - 4e-6) + found(0.1 + 4e-6))
    np.testing.assert_allclose(found(0.1), beside, rtol=1e-3, atol=1e-3 * np.abs(beside).max())
