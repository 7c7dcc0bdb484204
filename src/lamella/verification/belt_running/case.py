"""The belt of the example ``corrugator``, running over three rollers."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

import lamella as lm
from lamella.examples import example
from lamella.examples.corrugator.study import LENGTH, R2, R3, H, loop_mean, tilt
from lamella.io.analysis import Motion
from lamella.io.model_file import read_model
from lamella.result import Result
from lamella.roles import Floats
from lamella.study.measures import component, time_average
from lamella.verification import Check, Curves, Evidence, Shape

slow = True

SCHEDULE = ("profiles.pull.t_end=1.1 s", "profiles.speed.t_start=1.1 s", "profiles.speed.t_end=1.6 s")
"""Sooner than in the example."""
EVEN = ("system.pull_a.force=[3000 N, 0, 0]", "system.pull_b.force=[3000 N, 0, 0]")
END, END_EVEN, AT_SPEED = 2.5, 1.7, 1.6
SPEED, ENDS, N_AROUND = 1.5, 7000.0, 40
PASSAGE = LENGTH / N_AROUND / SPEED
"""Time in which an element passes [s]: what ripples with the mesh has this period, and fractions of it."""
PASSAGES = 20
AGAIN, PASSAGES_AGAIN = 0.25, 4
"""The last time of the run that is computed again [s], and passages of which means are compared."""
FRAMES = 125


def ran(*overrides: str) -> Result:
    """The example, with a shorter schedule and overrides."""
    model = read_model(example("corrugator").model, (*SCHEDULE, *overrides))
    (motion,) = model.analyses
    assert isinstance(motion, Motion)
    return lm.simulate(model.system, motion.t_end, motion.integrator, frames=FRAMES)


def mean(run: Result, name: str, label: str, passages: int = PASSAGES) -> float:
    """Time average of a component over the last passages of elements."""
    t, values = component(run, name, label)
    window = np.linspace(t[-1] - passages * PASSAGE, t[-1], 40 * passages + 1)
    return time_average(window, np.interp(window, t, values))


def drift(run: Result, since: float) -> float:
    """Rate at which the middle line of the belt moves along z [m/s], by least squares."""
    late = run.frame_at >= since
    return float(np.polyfit(run.frame_at[late], loop_mean(run)[late], 1)[0])


def edges(run: Result) -> Floats:
    """Membrane force at the edges of end a and end b, mean over the loop and over the last frames [N/m]."""
    last = range(len(run.frame_at) - 20, len(run.frame_at), 4)
    return np.mean([run.plate("belt", k, 4).section_forces()[[0, -1], :-1, 0].mean(axis=1) for k in last], axis=0)


def run() -> Iterator[Evidence]:
    """Yield the checks and pictures of this case."""
    even, uneven = ran(*EVEN, f"analysis.run.t_end={END_EVEN} s"), ran(f"analysis.run.t_end={END} s")
    yield from equal(even)
    yield from balance(uneven)
    yield from unequal(uneven)
    yield from by_another_method(uneven)
    angles = {name: (t, 1e3 * angle) for name, (t, angle) in (("4000 and 3000 N", tilt(uneven)), ("3500 N each", tilt(even)))}
    yield Curves("Tilt of roller 2", "Time [s]", "Tilt [mrad]", angles)
    places = {"4000 and 3000 N": uneven, "3500 N each": even}
    lines = {name: (one.frame_at, 1e3 * loop_mean(one)) for name, one in places.items()}
    yield Curves("Drift of the belt towards end b", "Time [s]", "Place of its middle line [mm]", lines)
    yield Shape("The running belt", uneven, field="von_mises", view=(0.0, -0.45, 1.0))


def equal(run: Result) -> Iterator[Evidence]:
    """Nothing tells one side from the other."""
    why = "rounding, 1e-16 of 1 m in each of 1700 steps, grown by the way the belt wanders"
    angle = tilt(run)[1]
    yield Check("largest tilt, equal forces", float(np.abs(angle).max()), 0.0, 1e-9, "absolute", "symmetry", "rad", reason=why)
    place = float(np.abs(loop_mean(run)).max())
    yield Check("largest offset of the belt, equal forces", place, 0.0, 1e-9, "absolute", "symmetry", "m", reason=why)


def balance(run: Result) -> Iterator[Evidence]:
    """Forces on the rollers, speeds and energy."""
    force = {(k, axis): mean(run, f"touch{k}.force", axis) for k in (1, 2, 3) for axis in "xyz"}
    why = "roller 2 still moves by some 0.1 mm/s, with 3000 N s/m at its damper; elements pass at 24 Hz with ripples of 100 N"
    expected = (
        (2, -ENDS, "force of the belt on roller 2 along x"),
        (1, ENDS, "force of the belt on roller 1 along x"),
        (3, 0.0, "force of the belt on roller 3 along x"),
    )
    for k, reference, name in expected:
        yield Check(name, force[k, "x"], reference, 5.0, "absolute", "equilibrium of the roller and the belt", "N", reason=why)
    why = "momentum of 9.6 kg that changes by less than 1e-3 m/s in the time of the mean"
    for axis in "xyz":
        total = sum(force[k, axis] for k in (1, 2, 3))
        yield Check(f"force on all rollers along {axis}", total, 0.0, 1.0, "absolute", "equilibrium of the belt", "N", reason=why)
    surface = [abs(mean(run, f"roller{k}.angular_velocity", "z")) * (R + 0.5 * H) for k, R in ((2, R2), (3, R3))]
    why = (
        "creep: a strand's stretch is 1.1e-3, which is lost and gained where the tension changes, and bending 0.13 % by the depth"
    )
    yield Check(
        "speed of the belt by roller 2", surface[0], surface[1], 2e-3, source="omega_2 (R_2 + h/2) = omega_3 (R_3 + h/2)",
        unit="m/s", reason=why,
    )  # fmt: skip
    work = run.samples("work.loads") + run.samples("work.supports")
    left = float(run.samples("energy.balance")[-1] / work[-1])
    why = "numerical damping of steps of 1 ms, rho_inf = 0.6, of what the rollers throw into vibration"
    yield Check("energy left over, of the work", left, 0.0, 5e-3, "absolute", "conservation of energy", reason=why)


def unequal(run: Result) -> Iterator[Evidence]:
    """What is pulled less comes nearer, is slacker, and draws the belt."""
    t, angle = tilt(run)
    late = t >= t[-1] - PASSAGES * PASSAGE
    why = "the sign, well above rounding; the size depends on element, mesh, friction and stiffness of contact"
    least = "strands as beams clamped at rollers, M l / (2 E h w^3 / 12)"
    yield Check(
        "tilt of roller 2, end b nearer", time_average(t[late], angle[late]), 1.1e-3, 0.0, "at least", least, "rad", reason=why
    )
    N = edges(run)
    moment = "the strands bear a third or more of the moment of 500 N m"
    yield Check("membrane stress, edge a over edge b", float(N[0] / N[1]), 1.5, 0.0, "at least", moment, reason=why)
    source = "drift to the side with the shorter distance of centres"
    yield Check("drift towards end b", drift(run, AT_SPEED + 0.3), 1e-5, 0.0, "at least", source, "m/s", reason=why)


def by_another_method(run: Result) -> Iterator[Evidence]:
    """The last of it by backward differentiation, from a state of the run."""
    k = int(np.argmin(np.abs(run.frame_at - (run.at[-1] - AGAIN))))
    t, q, v = float(run.frame_at[k]), run.frame_q[k].reshape(-1), run.frame_v[k].reshape(-1)
    newton = lm.Newton(tolerance=1e-6, max_iterations=50, keep=0.7, line_search="residual")
    method = lm.BDF(dt=1e-3, dt_max=1e-3, newton=newton)
    start = replace(run.final, t=t, q=q, v=v)
    other = lm.simulate(run.model, float(run.at[-1]), method, t_start=t, initial=start, frames=2)
    why = "two methods of second order, of which steps of 1 ms leave 1 % of a ripple of 24 Hz"
    for name, label in (("touch2.force", "x"), ("touch3.force", "y"), ("touch3.force", "z"), ("roller2.angular_velocity", "z")):
        found, expected = (mean(one, name, label, PASSAGES_AGAIN) for one in (other, run))
        yield Check(f"{name}.{label}, by BDF", found, expected, 0.01, source="generalised-alpha", reason=why)
    angles = [
        mean(one, "end_a.position", "x", PASSAGES_AGAIN) - mean(one, "end_b.position", "x", PASSAGES_AGAIN)
        for one in (other, run)
    ]
    yield Check("tilt of roller 2, by BDF", angles[0], angles[1], 0.01, source="generalised-alpha", unit="rad", reason=why)
    aside = [component(one, "centre.position", "z")[1] for one in (other, run)]
    moved = [float(z[-1] - np.interp(t, one.at, z)) for z, one in zip(aside, (other, run), strict=True)]
    yield Check(
        "way of the belt's centre along z, by BDF", moved[0], moved[1], 0.01, source="generalised-alpha", unit="m", reason=why
    )
