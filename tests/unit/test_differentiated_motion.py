"""What a motion does and leaves out where it is run for derivatives."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest

import lamella as lm
from lamella.differentiation.family import FunctionFamily
from lamella.differentiation.gradient import differentiated
from lamella.errors import ConvergenceError, DeclarationError
from lamella.result import Outcome, Statistics
from lamella.roles import Floats
from lamella.state import State

INERTIA, T_END, STEP = 2e-3, 1.0, 0.01


def hub(torque: float) -> lm.System:
    """A hub that a torque spins up."""
    system = lm.System()
    ground = system.add(lm.Ground())
    body = system.add(lm.RigidBody("hub", mass=0.5, inertia=(INERTIA, INERTIA, INERTIA)))
    system.add(lm.RevoluteJoint("pin", ground.origin, body.origin, axis=(0, 0, 1)))
    system.add(lm.PointMoment("motor", body.origin, (0, 0, torque)))
    return system


def spin_up(stride: int = 1) -> lm.Motion:
    return lm.Motion("spin", T_END, lm.GeneralizedAlpha(STEP, newton=lm.Newton(tolerance=1e-12)), stride=stride)


@pytest.mark.parametrize("statistic", ["last", "mean"])
def test_turns_are_counted_although_nothing_is_recorded(statistic: str) -> None:
    angle = lm.SignalOutput("pin.angle", statistic=statistic)  # type: ignore[arg-type]
    found = lm.gradient(hub, {"torque": 0.04}, {"angle": angle}, analyses=(spin_up(),))
    turned = 0.5 * 0.04 / INERTIA * T_END**2 * (1.0 if statistic == "last" else 1.0 / 3.0)
    assert turned > 3.0
    assert found.values["angle"] == pytest.approx(turned, rel=1e-2)  # steps of up to 0.2 rad
    assert found["angle", "torque"] == pytest.approx(found.values["angle"] / 0.04, rel=2e-2)  # linear but for such steps


def test_statistics_are_taken_of_the_steps_that_a_result_records() -> None:
    angle = lm.SignalOutput("pin.angle", statistic="mean")
    found = lm.gradient(hub, {"torque": 0.04}, {"angle": angle}, analyses=(spin_up(stride=7),))
    run = lm.simulate(hub(0.04), T_END, spin_up().integrator, stride=7)
    assert found.values["angle"] == pytest.approx(angle.value(run), rel=1e-9)


def wound(stiffness: float) -> lm.System:
    """A wheel that spins against a spring."""
    system, ground = lm.System(), lm.Ground()
    wheel = system.add(lm.RigidBody("wheel", mass=1.0, inertia=(1.0, 1.0, 1.0), angular_velocity=(0.0, 0.0, 9.0)))
    pin = system.add(lm.RevoluteJoint("pin", ground.origin, wheel.origin))
    system.add(lm.TorsionSpring("spring", pin, stiffness=stiffness))
    return system


def test_derivatives_go_on_with_the_turns_of_the_motion_before() -> None:
    """A motion in two parts has the derivatives of the whole, but for the algorithmic acceleration, which begins anew: dt^2."""
    steps, names = lm.GeneralizedAlpha(5e-3, newton=lm.Newton(tolerance=1e-12)), ("pin.angle", "spring.torque")
    first, second = lm.Motion("first", 0.5, steps), lm.Motion("second", 1.2, steps, t_start=0.5, start="first")
    found = []
    for analyses in ((lm.Motion("second", 1.2, steps),), (first, second)):
        outputs = {name: lm.SignalOutput(name, analysis="second") for name in names}
        found.append(lm.gradient(wound, {"stiffness": 1.0}, outputs, analyses=analyses))
    whole, parts = found
    assert whole.values["pin.angle"] > 2.0 * np.pi
    for name in names:
        assert parts.values[name] == pytest.approx(whole.values[name], rel=1e-5)
        assert parts[name, "stiffness"] == pytest.approx(whole[name, "stiffness"], rel=1e-4)


def stopped(stiffness: float) -> lm.System:
    """A motor presses a wheel against a stop beyond a whole turn; two others swing faster."""
    system, ground = lm.System(), lm.Ground()
    for name in ("one", "two", "three"):
        wheel = system.add(lm.RigidBody(name, mass=1.0, inertia=(1.0, 1.0, 1.0)))
        pin = system.add(lm.RevoluteJoint(f"pin {name}", ground.origin, wheel.origin))
        if name == "one":
            system.add(lm.PointMoment("motor", wheel.origin, (0.0, 0.0, 20.0)))
            system.add(lm.EndStop("stop", pin, upper=7.0, stiffness=stiffness, damping=20.0))
        else:
            system.add(lm.TorsionSpring(f"spring {name}", pin, stiffness=500.0 if name == "two" else 900.0))
    return system


def test_modes_about_an_earlier_state_go_on_with_its_turns() -> None:
    """Where another motion has come between, whose models have not reached their stop."""
    steps, first = lm.GeneralizedAlpha(1e-2), {"first": lm.ShapeOutput(1, analysis="modes")}
    analyses = lm.Motion("press", 4.0, steps), lm.Motion("other", 0.1, steps), lm.NaturalModes("modes", 2, about="press")
    below, found, above = (lm.gradient(stopped, {"stiffness": k}, first, analyses=analyses) for k in (99.9, 100.0, 100.1))
    assert found.values["first"] > 1.5  # pressed against the stop
    expected = (above.values["first"] - below.values["first"]) / 0.2
    assert found["first", "stiffness"] == pytest.approx(expected, rel=1e-5)  # differences of frequencies to 1e-9


def test_more_modes_than_there_are_are_refused() -> None:
    with pytest.raises(DeclarationError, match="n = 3; accepted is 1 to 2"):
        lm.gradient(stopped, {"stiffness": 100.0}, {"f": lm.ShapeOutput(3)}, analyses=(lm.NaturalModes("modes", 3),))


def strip(width: float) -> lm.System:
    """A thin plate that a force at its tip bends; along a straight line of coordinates it is stretched."""
    system, layup = lm.System(), lm.Laminate(lm.Isotropic(E=70e9, nu=0.3, rho=2700.0), thickness=2e-3)
    plate = system.add(lm.Plate("plate", (1.5, width), (3, 2), layup, damping=1e-3))
    system.add(lm.Clamp("root", plate.edge("x-")))
    system.add(lm.PointForce("load", plate.marker("tip", 1.5, 0.3 * width), (0, 0, 20.0)))
    return system


def test_the_strain_energy_of_what_is_stretched_by_differences() -> None:
    """Against differences of fourth order of whole runs, which rounding and Newton's tolerance leave off by some 1e-8."""
    integrator = lm.GeneralizedAlpha(1e-3, newton=lm.Newton(tolerance=1e-12, keep=0.2))
    motion, energy, h = lm.Motion("swing", 0.05, integrator), lm.SignalOutput("energy.strain"), 1e-3
    found = lm.gradient(strip, {"width": 1.0}, {"energy": energy}, analyses=(motion,))
    ends = {k: lm.simulate(strip(1.0 + k * h), motion.t_end, integrator).samples("energy.strain")[-1] for k in (-2, -1, 1, 2)}
    expected = (8.0 * (ends[1] - ends[-1]) - (ends[2] - ends[-2])) / (12.0 * h)
    assert found["energy", "width"] == pytest.approx(expected, rel=1e-6)


class Listener:
    """A sink that interrupts after some samples."""

    def __init__(self, most: int) -> None:
        self.most, self.times, self.ended = most, [], []  # type: ignore[var-annotated]

    def sample(self, at: float, values: Sequence[Floats]) -> None:
        self.times.append(at)
        if len(self.times) > self.most:
            raise KeyboardInterrupt

    def frame(self, at: float, state: State) -> None:
        pass

    def close(self, outcome: Outcome, statistics: Statistics) -> None:
        self.ended.append(outcome.completed)


def test_sinks_hear_of_each_step_and_may_interrupt() -> None:
    outputs = {"angle": lm.SignalOutput("pin.angle")}
    family = FunctionFamily(hub, (spin_up(),), {"torque": "N m"})
    whole, cut = Listener(1000), Listener(5)
    differentiated(family, {"torque": 0.04}, outputs, {}, lambda: (whole,))
    assert whole.times == pytest.approx([k * STEP for k in range(101)])
    assert whole.ended == [True]
    with pytest.raises(ConvergenceError, match="interrupt"):
        differentiated(family, {"torque": 0.04}, outputs, {}, lambda: (cut,))
    assert len(cut.times) == 6
    assert cut.ended == [False]
