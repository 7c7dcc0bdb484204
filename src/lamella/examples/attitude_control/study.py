"""A controller that knows of the panel's thermal bending, and one that does not."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TypeVar

import numpy as np
from scipy.linalg import expm

from lamella.examples.attitude_control import drawing
from lamella.examples.attitude_control.control import PERIOD, SLEW, SUNRISE, TURN, Knowledge, Law, known, light, reference
from lamella.examples.swing import Numbers, rounded
from lamella.io.analysis import Motion
from lamella.io.linear_analysis import Linear
from lamella.io.model_file import ModelFile
from lamella.linear.model import linearise
from lamella.linear.state_space import StateSpace
from lamella.load.control_law import FunctionLaw
from lamella.load.controller import Controller
from lamella.motion import simulate
from lamella.result import Result
from lamella.roles import Floats
from lamella.stepping.run import Stepping
from lamella.study.findings import Finding
from lamella.study.study import Study

MEASURED = ("bearing.angle", "bearing.rate")
SHADE, LOOP = ("system.sun.profile=0",), ("system.wheel.profile=1",)
HOLD = 0.1
"""Time for which the linear model holds the light [s]."""
OUTSIDE = 20.0
"""Time for which the loop is also closed from outside [s]."""
Runs = Mapping[str, Result]
A = TypeVar("A")


def study(study: Study) -> Iterator[Finding]:
    """Design from the linear model, fly with both controllers and in the shade, draw, and yield the findings."""
    dark = study.read(SHADE)
    motion, wanted = _analysis(dark, Motion), _analysis(dark, Linear)
    study.say("linear model of the satellite in the shade")
    plant = linearise(dark.system, wanted.inputs, wanted.outputs).state_space()
    knowledge = known(plant)
    laws = {
        "bending unknown": Law(knowledge, motion.t_end, thermal=False),
        "bending known": Law(knowledge, motion.t_end, thermal=True),
        "no sun": Law(knowledge, motion.t_end, thermal=False),
    }
    runs: dict[str, Result] = {}
    for name, law in laws.items():
        study.say(f"flight: {name}")
        runs[name] = fly(study.read((*LOOP, *SHADE) if name == "no sun" else LOOP), motion, law)
        folder = study.folder / name.replace(" ", "-")
        folder.mkdir(exist_ok=True)
        study.files.append(runs[name].save(folder / "run.h5"))
    if study.draw:
        drawing.show_all(study, runs)
    yield sunrise(runs)
    if motion.t_end > SLEW[1]:
        yield slew(runs)
    yield foretold(runs, plant, laws["bending unknown"])
    yield momentum(knowledge)
    yield from_outside(runs["bending known"], study.read(), motion, laws["bending known"])


def _analysis(file: ModelFile, kind: type[A]) -> A:
    return next(item for item in file.analyses if isinstance(item, kind))


def fly(file: ModelFile, motion: Motion, law: Law) -> Result:
    """The motion of a model with a controller in the loop."""
    file.system.add(Controller("pilot", MEASURED, ("wheel",), FunctionLaw(law), PERIOD))
    return simulate(file.system, motion.t_end, motion.integrator, frames=240)


def error(run: Result) -> Floats:
    """Attitude less what is wanted [mrad]."""
    return 1e3 * (run.samples("bearing.angle") - reference(run.at))


def largest(run: Result, first: float, last: float) -> float:
    """Largest pointing error between two times [mrad]."""
    chosen = (run.at >= first) & (run.at <= last)
    return float(np.abs(error(run)[chosen]).max(initial=0.0))


def sunrise(runs: Runs) -> Finding:
    """The hub is pushed by the panel that bends in the rising sun."""
    numbers: Numbers = {f"largest pointing error before the slew, {n} [mrad]": largest(r, 0.0, SLEW[0]) for n, r in runs.items()}
    unknown, ahead = (largest(runs[name], 0.0, SLEW[0]) for name in ("bending unknown", "bending known"))
    numbers["known over unknown"] = ahead / unknown
    return Finding(
        "At sunrise the bending panel turns the hub; torque ahead from the linear model takes most of that away.",
        ahead < 0.25 * unknown and largest(runs["no sun"], 0.0, SLEW[0]) < 1e-3 * unknown,
        rounded(numbers),
        f"The sun rises from {SUNRISE[0]:g} to {SUNRISE[1]:g} s.",
    )


def slew(runs: Runs) -> Finding:
    """The slew moves the panel through the light."""
    numbers: Numbers = {f"largest pointing error, {n} [mrad]": largest(r, SLEW[0], runs[n].at[-1]) for n, r in runs.items()}
    numbers |= {f"pointing error at the end, {name} [mrad]": float(error(run)[-1]) for name, run in runs.items()}
    unknown, ahead = (largest(runs[name], SLEW[0], np.inf) for name in ("bending unknown", "bending known"))
    numbers["known over unknown"] = ahead / unknown
    end = float(runs["bending known"].samples("bearing.angle")[-1])
    numbers["angle at the end, bending known [rad]"] = end
    return Finding(
        "During the slew the controller that knows how heat bends and lengthens the panel points better.",
        ahead < 0.5 * unknown and abs(end - TURN) < 1e-3,
        rounded(numbers),
    )


def foretold(runs: Runs, plant: StateSpace, law: Law) -> Finding:
    """The linear model with the sampled feedback, against the nonlinear motion before the slew."""
    run = runs["bending unknown"]
    last = min(SLEW[0], float(run.at[-1]))
    t = np.arange(0.0, last - 0.5 * HOLD, HOLD)
    n, m = plant.B.shape
    step = expm(np.block([[plant.A, plant.B], [np.zeros((m, n + m))]]) * HOLD)
    F, G = step[:n, :n], step[:n, n:]
    x, angle, u = np.zeros(n), [], np.zeros(m)
    for k, now in enumerate(t):
        y = plant.C[:2] @ x
        angle.append(y[0])
        if k % round(PERIOD / HOLD) == 0:
            u[0] = -law.k_p * y[0] - law.k_d * y[1]
        u[1] = light(np.array([now + 0.5 * HOLD]))[0]
        x = F @ x + G @ u
    measured = np.interp(t, run.at, 1e-3 * error(run))
    apart = float(np.abs(measured - angle).max())
    numbers: Numbers = {
        "largest pointing error, linear model with sampled feedback [mrad]": 1e3 * float(np.abs(angle).max()),
        "largest pointing error, nonlinear motion [mrad]": 1e3 * float(np.abs(measured).max()),
        "largest difference of the two [mrad]": 1e3 * apart,
    }
    return Finding(
        "The linear model foretells the pointing error at sunrise.",
        apart < 0.1 * float(np.abs(measured).max()),
        rounded(numbers),
        "Linear about the cold satellite in the shade, light held for 0.1 s. It leaves out that the panel turns away "
        "as it bends, and becomes longer.",
    )


def momentum(knowledge: Knowledge) -> Finding:
    """The coefficients of the torque ahead against beam theory."""
    length, mass = 7.5, 36.8 * 7.5 * 0.5 * 0.0103
    hub = 200.0 + mass * length**2 / 3.0
    curvature = 2.3e-5 * 0.79 * 1350.0 * np.cos(np.radians(65.0)) / (2.0 * 1.5)
    bent = mass / length * curvature * length**4 / 8.0
    lag = 36.8 * 921.0 * 0.0103**2 / (12.0 * 1.5)
    numbers: Numbers = {
        "inertia, linear model [kg m^2]": knowledge.inertia,
        "inertia of hub and rigid panel [kg m^2]": hub,
        "momentum by bending for a rate of the light of 1/s, linear model [N m s^2]": knowledge.thermal,
        "the same of a beam, rho A alpha T_M L^4 / 8 [N m s^2]": bent,
        "lag, linear model [s]": knowledge.lag,
        "lag of the gradient, rho c h^2 / (12 k) [s]": lag,
    }
    agrees = abs(knowledge.inertia / hub - 1.0) < 1e-3 and abs(knowledge.thermal / bent - 1.0) < 0.1
    return Finding(
        "Check of our own: inertia, momentum and lag from the linear model are those of a beam.",
        agrees and abs(knowledge.lag / lag - 1.0) < 0.1,
        rounded(numbers),
        "A plate bends both ways, and its root holds it back across: the beam leaves a few per cent open.",
    )


def from_outside(run: Result, file: ModelFile, motion: Motion, law: Law) -> Finding:
    """The same loop closed by a program that advances the motion sample by sample."""
    steps = Stepping(file.system, motion.integrator, inputs=("wheel",), outputs=MEASURED)
    end = min(OUTSIDE, motion.t_end)
    for k in range(round(end / PERIOD)):
        steps.set("wheel", law(steps.t, np.array(list(steps.outputs.values()))))
        steps.advance_to((k + 1) * PERIOD)
    inside = float(np.interp(steps.t, run.at, run.samples("bearing.angle")))
    apart = abs(float(steps.get("bearing.angle")) - inside)
    return Finding(
        "Check of our own: the loop closed from outside, sample by sample, is the loop closed inside.",
        apart < 1e-6 * max(abs(inside), 1e-3),
        rounded({"attitude, inside [rad]": inside, "difference [rad]": apart, "time [s]": steps.t}),
    )
