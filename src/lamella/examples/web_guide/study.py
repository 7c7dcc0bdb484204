"""A belt whose edge is held by a steering roller: linear model from a step, PI controller, disturbance and tracking."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from lamella.errors import DeclarationError
from lamella.examples.swing import Numbers, rounded
from lamella.examples.web_guide import drawing
from lamella.examples.web_guide.curves import PERIOD, angle, apart, at, difference, drift, edge, even
from lamella.examples.web_guide.theory import Design, Web, answer, closed_loop, designed, fitted, with_share
from lamella.io.analysis import Motion
from lamella.load.control_law import PID
from lamella.load.controller import Controller
from lamella.math.profile import SmoothStep
from lamella.motion import simulate
from lamella.result import Result
from lamella.roles import Floats
from lamella.study.findings import Finding
from lamella.study.measures import component, time_average
from lamella.study.study import Study

RADIUS = 0.1
"""Of the belt's middle on the rollers [m]."""
SERVO = 0.025
"""Damping over stiffness of the servo [s]."""
MARGIN, CORNER = np.radians(50.0), 5.0
"""Phase margin, and crossover over the frequency at which the integral takes over."""
LIMIT = 0.05
"""Largest command [rad]."""
STEP, SHIFT, SKEW = 0.01, 3e-3, 5e-3
"""Step of the steering angle [rad], of the set-point [m], and misalignment of roller 1 [rad]."""
ALONE = 0.9
"""How long the runs without the controller are [s], two turns."""
AFTER = 0.1
"""What happens to a steadily running belt begins so long after the start of a run [s], and takes as long."""


@dataclass(frozen=True)
class Runs:
    """What was simulated; all begin with the belt at full speed.

    Args:
        rest: the edge of the undisturbed belt [m].
        step: a step of the steering angle.
        open: misalignment of roller 1, without the controller.
        held: misalignment, with it.
        tracked: a set-point that moves, with it.
    """

    rest: float
    step: Result
    open: Result
    held: Result
    tracked: Result


@dataclass(frozen=True)
class Models:
    """What the linear model says beside the runs.

    Args:
        ideal: the web without any fit.
        web: the one on which the controller is designed.
        design: the controller's numbers.
        step: edge after the step by ``ideal`` and by ``web`` [m], at the times of the run.
        open: edge with the misalignment [m].
        held, tracked: edge [m] and command [rad].
    """

    ideal: Web
    web: Web
    design: Design
    step: tuple[Floats, Floats]
    open: Floats
    held: tuple[Floats, Floats]
    tracked: tuple[Floats, Floats]


def study(study: Study) -> Iterator[Finding]:
    """Run the belt up to speed, take its linear model, design the controller, try it, and yield the findings."""
    file = study.read()
    motion = next(item for item in file.analyses if isinstance(item, Motion) and item.name == "run")
    begin, end = motion.t_start, motion.t_end
    if not end > begin + 2.0 * AFTER + 0.1:
        raise DeclarationError(
            "study web-guide", f"run.t_end = {end:g} s", f"accepted is more than {begin + 2 * AFTER + 0.1:g} s"
        )
    soon = min(end, begin + ALONE)
    first = study.run("step", (f"profiles.steer.end={STEP}", f"analysis.run.t_end={soon} s"))
    start, step = first["start"], first["run"]
    assert isinstance(start, Result)
    assert isinstance(step, Result)
    t, z = edge(start)
    late = t >= begin - AFTER
    rest = time_average(t[late], z[late])
    ideal = machine(start)
    grid = even(step)
    moved = at(grid, *edge(step)) - rest
    web = fitted(ideal, grid - begin, np.where(grid > begin, STEP, 0.0), moved)
    design = designed(web.state_space(), PERIOD, MARGIN, CORNER)

    def simulated(name: str, law: PID | None, skew: float, until: float) -> Result:
        study.say(f"variant {name}: from the belt at full speed on")
        system = study.read((f"profiles.misalign.end={skew}", *(("system.command.profile=1",) if law else ()))).system
        if law is not None:  # its output takes the place of the profile
            system.add(Controller("guide", ("eye.position.z",), ("command",), law, PERIOD))
        result = simulate(
            system,
            until,
            motion.integrator,
            t_start=begin,
            initial=start.final,
            frames=file.output.frames,
            stride=motion.stride,
        )
        folder = study.folder / name
        folder.mkdir(exist_ok=True)
        study.files.append(result.save(folder / "run.h5"))
        return result

    hold, follow = laws(design, rest, begin)
    runs = Runs(
        rest,
        step,
        simulated("open", None, SKEW, soon),
        simulated("held", hold, SKEW, end),
        simulated("tracked", follow, 0.0, end),
    )
    grid = even(runs.open)
    skewed = misaligned(grid, begin)
    web = with_share(web, grid - begin, skewed, at(grid, *edge(runs.open)) - rest)
    models = predicted(runs, ideal, web, design, (hold, follow), begin)
    if study.draw:
        drawing.show_all(study, runs, models)
    yield steering(runs, models)
    yield structure(runs, models)
    yield disturbance(runs, models)
    yield tracking(runs, models)
    yield balance(runs)


def machine(run: Result) -> Web:
    """The ideal web of the machine at the end of a run."""
    speed = abs(float(component(run, "roller1.angular_velocity", "z")[1][-1])) * RADIUS
    apart = float(component(run, "roller2.position", "x")[1][-1] - component(run, "roller1.position", "x")[1][-1])
    return Web(RADIUS, apart, speed, SERVO)


def laws(design: Design, rest: float, begin: float) -> tuple[PID, PID]:
    """The controller with the set-point at rest, and with one that moves."""
    still = SmoothStep(begin, t_end=begin + AFTER, start=rest, end=rest)
    hold = PID(design.proportional, design.integral, reference=still, limit=LIMIT)
    moves = SmoothStep(begin + AFTER, t_end=begin + 2.0 * AFTER, start=rest, end=rest + SHIFT)
    return hold, replace(hold, reference=moves)


def predicted(runs: Runs, ideal: Web, web: Web, design: Design, law: tuple[PID, PID], begin: float) -> Models:
    """The linear model's answers, at the times of the runs."""
    grid = even(runs.step)
    command = np.where(grid > begin, STEP, 0.0)
    steps = [runs.rest + answer(each, grid - begin, command, 0.0 * grid) for each in (ideal, web)]
    grid = even(runs.open)
    alone = runs.rest + answer(web, grid - begin, 0.0 * grid, misaligned(grid, begin))
    grid = even(runs.held)
    held = closed_loop(web, law[0], PERIOD, grid, misaligned(grid, begin), runs.rest)
    tracked = closed_loop(web, law[1], PERIOD, grid, 0.0 * grid, runs.rest)
    return Models(ideal, web, design, (steps[0], steps[1]), alone, held, tracked)


def misaligned(t: Floats, begin: float) -> Floats:
    """Misalignment of roller 1 as the model file has it [rad]."""
    course = SmoothStep(begin + AFTER, t_end=begin + 2.0 * AFTER, end=SKEW)
    return np.array([course.value(float(now)) for now in t])


def steering(runs: Runs, models: Models) -> Finding:
    """What a turned roller does to the belt."""
    run, web = runs.step, models.ideal
    turn = web.length / web.speed
    since = max(run.at[0] + turn, run.at[-1] - turn) if run.at[-1] > run.at[0] + turn else run.at[0] + 0.5 * turn
    rate, theory = drift(run, since), web.rate * STEP
    numbers: Numbers = {
        "speed of the belt [m/s]": web.speed,
        "time of a turn [s]": turn,
        "steering angle [mrad]": 1e3 * STEP,
        "sideways speed [mm/s]": 1e3 * rate,
        "by theory, the angle times twice the radius in each turn [mm/s]": 1e3 * theory,
        "first motion of the edge, the other way [mm]": 1e3 * float(np.max(edge(run)[1]) - runs.rest),
        "difference of the tensions of both edges [% of their mean]": 100.0 * difference(run, since),
        "the same with roller 1 misaligned [%]": 100.0 * difference(runs.open, run.at[0] + 2.0 * AFTER),
    }
    return Finding(
        "A roller that is turned about the direction of the strands moves the belt sideways by its diameter times the angle in "
        "each turn, and leaves the tensions of both edges alike.",
        abs(rate / theory - 1.0) < 0.1 and abs(difference(run, since)) < 0.05,
        rounded(numbers),
        "At first the edge goes the other way: what lies on the roller turns with it.",
    )


def structure(runs: Runs, models: Models) -> Finding:
    """How well a linear model describes the step response."""
    moved = float(np.ptp(edge(runs.step)[1]))
    ideal, fit = (apart(runs.step, model) for model in models.step)
    numbers: Numbers = {
        "range of the response [mm]": 1e3 * moved,
        "error of the ideal web, without any fit, rms [mm]": 1e3 * ideal,
        "of the range [%]": 100.0 * ideal / moved,
        "error with two fitted factors, rms [mm]": 1e3 * fit,
        "of the range, fitted [%]": 100.0 * fit / moved,
        "fitted lag over span / speed": models.web.lag,
        "fitted lever over radius": models.web.lever,
        "ripple of the edge before the step, rms [mm]": 1e3 * float(np.std(_before(runs))),
    }
    return Finding(
        "A straight web that meets each roller at right angles to its axle (Shelton and Reid, 1971) answers to the step as the "
        "shell does.",
        ideal < 0.05 * moved and fit <= ideal and abs(models.web.lag - 1.0) < 0.2 and abs(models.web.lever - 1.0) < 0.1,
        rounded(numbers),
        "Elements that pass under the sensor make the edge ripple; no linear model follows that.",
    )


def _before(runs: Runs) -> Floats:
    """The edge of the tracked belt until its set-point moves."""
    t, z = edge(runs.tracked)
    return z[t <= t[0] + AFTER]


def disturbance(runs: Runs, models: Models) -> Finding:
    """Roller 1 gets out of parallel, without and with the controller."""
    t, z = edge(runs.held)
    rate = drift(runs.open, runs.open.at[0] + 2.0 * AFTER)
    last = t >= t[-1] - 0.2
    free = rate * float(t[-1] - t[0] - 1.5 * AFTER)
    numbers: Numbers = {
        "misalignment of roller 1 [mrad]": 1e3 * SKEW,
        "sideways speed without the controller [mm/s]": 1e3 * rate,
        "share of what an ideal web would do": models.web.share,
        "error of the linear model without the controller, rms [mm]": 1e3 * apart(runs.open, models.open),
        "proportional gain [rad/m]": models.design.proportional,
        "integral gain [rad/m/s]": models.design.integral,
        "crossover [rad/s]": models.design.crossover,
        "phase margin [deg]": float(np.degrees(models.design.margin)),
        "largest deviation with the controller [mm]": 1e3 * float(np.abs(z - runs.rest).max()),
        "by the linear model [mm]": 1e3 * float(np.abs(models.held[0] - runs.rest).max()),
        "deviation at the end, mean of 0.2 s [mm]": 1e3 * (time_average(t[last], z[last]) - runs.rest),
        "by the linear model at the end [mm]": 1e3 * float(models.held[0][-1] - runs.rest),
        "without the controller it would be, at the rate above [mm]": 1e3 * free,
        "steering angle at the end [mrad]": 1e3 * float(angle(runs.held)[-1]),
        "angle that carries back as much as drifts [mrad]": -1e3 * rate / models.web.rate,
        "error of the linear model with the controller, rms [mm]": 1e3 * apart(runs.held, models.held[0]),
    }
    largest = float(numbers["largest deviation with the controller [mm]"])
    return Finding(
        "The controller stops the belt and turns it back when roller 1 gets out of parallel; without it the belt runs off.",
        abs(float(numbers["deviation at the end, mean of 0.2 s [mm]"])) < min(largest, 1e3 * abs(free) / 3.0)
        and apart(runs.held, models.held[0]) < 0.15e-3 * largest
        and abs(rate) > 1e-3,
        rounded(numbers),
        "Uneven tension makes the belt follow a misaligned roller by a part of what an ideal web would; that share is taken from "
        "the run without the controller.",
    )


def tracking(runs: Runs, models: Models) -> Finding:
    """The set-point moves."""
    t, z = edge(runs.tracked)
    way = (z - runs.rest) / SHIFT
    reached = np.flatnonzero(way >= 0.9)
    numbers: Numbers = {
        "step of the set-point [mm]": 1e3 * SHIFT,
        "90 % are reached after [s]": float(t[reached[0]] - t[0] - AFTER) if len(reached) else "not within the run",
        "overshoot [%]": 100.0 * max(float(way.max()) - 1.0, 0.0),
        "overshoot by the linear model [%]": 100.0 * max(float((models.tracked[0] - runs.rest).max()) / SHIFT - 1.0, 0.0),
        "first motion the other way [mm]": 1e3 * float(z.min() - runs.rest),
        "by the linear model [mm]": 1e3 * float(models.tracked[0].min() - runs.rest),
        "largest steering angle [mrad]": 1e3 * float(np.abs(angle(runs.tracked)).max()),
        "error of the linear model, rms [mm]": 1e3 * apart(runs.tracked, models.tracked[0]),
        "of the step [%]": 100.0 * apart(runs.tracked, models.tracked[0]) / SHIFT,
        "motion of the belt without the controller [mm]": 1e3 * float(np.abs(_before(runs) - runs.rest).max()),
    }
    return Finding(
        "The edge follows a set-point that moves, as the linear model says.",
        bool(len(reached)) and apart(runs.tracked, models.tracked[0]) < 0.05 * SHIFT,
        rounded(numbers),
        "Steering begins with the wrong direction (a zero in the right half plane), which limits how fast the loop can be.",
    )


def balance(runs: Runs) -> Finding:
    """Energy of the tracked run."""
    run = runs.tracked
    work = float(run.samples("work.loads")[-1] + run.samples("work.supports")[-1])
    heat, left = (float(run.samples(name)[-1]) for name in ("work.dissipated", "energy.balance"))
    kinetic = time_average(run.at, np.asarray(run.samples("energy.kinetic"), float))
    lost = abs(left) / kinetic * machine(run).length / machine(run).speed / float(run.at[-1] - run.at[0])
    numbers: Numbers = {
        "work of drive and loads [J]": work,
        "turned into heat [J]": heat,
        "left by the balance of energy [J]": left,
        "left, of work [%]": 100.0 * left / work,
        "kinetic energy [J]": kinetic,
        "left in a turn, of the kinetic energy [%]": 100.0 * lost,
    }
    return Finding(
        "Check of our own: the balance of energy leaves less than a per cent of the kinetic energy in a turn.",
        lost < 0.01,
        rounded(numbers),
        "The machine idles, so that the work of its drive is small; numerical damping takes a part of it, as rows of points meet "
        "the rollers.",
    )
