"""Deployment by springs on a free satellite: momentum, attitude, synchronisation, and the shock of the latches."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING

import numpy as np
from scipy.integrate import quad

from lamella.examples.deployment_springs import drawing
from lamella.examples.swing import Numbers, rounded
from lamella.result import Result
from lamella.roles import Floats
from lamella.study.findings import Finding
from lamella.study.measures import component, dominant_frequency, time_average

if TYPE_CHECKING:
    from lamella.study.study import Study

PANELS = ("p1", "p2", "p3", "p4")
HINGES = ("hinge0", "hinge1", "hinge2", "hinge3")
LENGTH, WIDTH, AREA_MASS = 1.5, 2.0, 1560 * 1.5e-3
FOLD = np.radians(80.0)
SATELLITE, SIDE = 400.0, 1.5
YOKE = 0.5
Runs = Mapping[str, Result]


def study(study: Study) -> Iterator[Finding]:
    """Run flexible and rigid panels, draw the pictures, and yield the findings."""
    runs = {}
    for name, overrides in (("flexible", []), ("rigid", [f"system.{panel}.strain=rigid" for panel in PANELS])):
        result = study.run(name, overrides, pictures=name == "flexible")["deployment"]
        assert isinstance(result, Result)
        runs[name] = result
    if study.draw:
        drawing.show_all(study, runs, {name: momenta(run) for name, run in runs.items()})
    yield momentum_stays(runs)
    yield attitude(runs)
    yield in_step(runs)
    yield shock(runs)
    yield energy(runs)


def momenta(result: Result) -> tuple[Floats, Floats]:
    """Linear [kg m/s] and angular momentum about the origin [kg m^2/s] in every frame, shapes (n, 3)."""
    model = result.model
    linear, angular = [], []
    for q, v in zip(result.frame_q, result.frame_v, strict=True):
        p = (model.mass @ v).reshape(-1, 3)
        linear.append(p[model.is_position].sum(axis=0))
        angular.append(np.cross(q.reshape(-1, 3), p).sum(axis=0))
    return np.array(linear), np.array(angular)


def latched(result: Result) -> float:
    """Time at which the last latch locks [s]; the end of the run when one does not."""
    times = [event.t for event in result.outcome.events]
    return max(times) if len(times) == len(HINGES) else float(result.at[-1])


def closed_form() -> float:
    """Angle by which the satellite of a rigid array has turned about y when it is straight [rad].

    Without outer forces momentum and angular momentum stay zero. With the array's angle phi as the only internal coordinate,
    psi' I(phi) + L(phi) phi' = 0 about the common centre of mass, so that psi = -int L / I dphi.
    """
    masses = np.array([SATELLITE, AREA_MASS * YOKE * WIDTH, *4 * [AREA_MASS * LENGTH * WIDTH]])
    inertias = np.array([SATELLITE * SIDE**2 / 6, masses[1] * YOKE**2 / 12, *4 * [masses[2] * LENGTH**2 / 12]])
    signs = np.array([1.0, -1.0, 1.0, -1.0])

    def places(phi: float) -> Floats:
        """Centres (x, z) of satellite, yoke and panels in the satellite's axes."""
        steps = LENGTH * np.stack([np.full(4, np.cos(phi)), signs * np.sin(phi)], axis=1)
        panels = np.cumsum(steps, axis=0) - 0.5 * steps
        return np.concatenate([[[-YOKE - 0.5 * SIDE, 0.0], [-0.5 * YOKE, 0.0]], panels])

    def ratio(phi: float) -> float:
        r, rate = places(phi), (places(phi + 1e-5) - places(phi - 1e-5)) / 2e-5
        shares = masses / masses.sum()
        r, rate = r - shares @ r, rate - shares @ rate
        own = np.concatenate([[0.0, 0.0], -signs])  # a panel that rises turns negatively about y
        relative = np.sum(masses * (r[:, 1] * rate[:, 0] - r[:, 0] * rate[:, 1]) + inertias * own)
        return relative / np.sum(masses * np.sum(r**2, axis=1) + inertias)

    return -quad(ratio, FOLD, 0.0)[0]


def momentum_stays(runs: Runs) -> Finding:
    """No outer force acts: momenta stay zero."""
    numbers: Numbers = {}
    worst = 0.0
    for name, run in runs.items():
        linear, angular = (np.linalg.norm(part, axis=1) for part in momenta(run))
        moving = np.abs(run.frame_v.reshape(len(run.frame_v), -1, 3)[:, run.model.is_position]).max()
        scale = moving * float(run.model.mass.diagonal().sum()) / 3.0
        worst = max(worst, float(linear.max()) / scale, float(angular.max()) / scale)
        numbers[f"largest linear momentum, {name} [kg m/s]"] = float(linear.max())
        numbers[f"largest angular momentum, {name} [kg m^2/s]"] = float(angular.max())
        numbers[f"total mass times largest speed, {name} [kg m/s]"] = scale
    return Finding(
        "Linear and angular momentum of satellite and array stay zero through deployment and latching.",
        worst < 1e-5,
        rounded(numbers),
        "Springs, dampers, loops and latches act inside the system; the integrator keeps linear momentum to rounding and angular "
        "momentum to its order.",
    )


def attitude(runs: Runs) -> Finding:
    """The satellite turns against the array, as angular momentum asks."""
    expected = closed_form()
    numbers: Numbers = {"angle about y of a rigid array, from angular momentum [deg]": float(np.degrees(expected))}
    found = {}
    for name, run in runs.items():
        t, pitch = component(run, "satellite.euler", "pitch")
        late = t > latched(run)
        found[name] = time_average(t[late], pitch[late]) if np.count_nonzero(late) > 2 else float(pitch[-1])
        numbers[f"angle about y after latching, mean, {name} [deg]"] = float(np.degrees(found[name]))
        swing = float(np.ptp(pitch[late]) / 2) if late.any() else 0.0
        numbers[f"angle about y after latching, half range, {name} [deg]"] = float(np.degrees(swing))
        numbers[f"largest angle about x and z, {name} [deg]"] = float(
            np.degrees(max(np.abs(component(run, "satellite.euler", axis)[1]).max() for axis in ("yaw", "roll")))
        )
    return Finding(
        "The deployment turns the satellite by the angle that conservation of angular momentum gives.",
        all(abs(value / expected - 1.0) < 0.08 for value in found.values()),
        rounded(numbers),
        "The array swings on its latches after locking, and the satellite with it; the mean is what stays.",
    )


def in_step(runs: Runs) -> Finding:
    """Cable loops keep the hinges in step, and all latches lock."""
    numbers: Numbers = {}
    agrees = True
    for name, run in runs.items():
        angles = np.array([run.samples(f"{hinge}.angle") for hinge in HINGES])
        before = run.at < latched(run)
        apart = np.abs(np.array([2.0 * angles[0] + angles[1], angles[1] + angles[2], angles[2] + angles[3]]))[:, before]
        numbers[f"largest difference of hinge angles, {name} [deg]"] = float(np.degrees(apart.max()))
        for event in run.outcome.events:
            numbers[f"{event.name} locks, {name} [s]"] = event.t
        agrees &= len(run.outcome.events) == len(HINGES) and float(np.degrees(apart.max())) < 6.0
    return Finding("Cable loops keep the four hinges in step, and all latches lock.", agrees, rounded(numbers))


def shock(runs: Runs) -> Finding:
    """What flexibility changes: the shock of the latches, and the vibration after it."""
    numbers: Numbers = {}
    for name, run in runs.items():
        t, torque = run.at, run.samples("latch0.torque")
        late = t >= latched(run)
        numbers[f"largest torque of the latch at the root, {name} [N m]"] = float(np.abs(torque).max())
        if np.count_nonzero(late) > 50:
            even = np.linspace(t[late][0], t[-1], np.count_nonzero(late))
            frequency = dominant_frequency(even, np.interp(even, t, torque))
            numbers[f"frequency of the vibration after latching, {name} [Hz]"] = frequency
    flexible, rigid = (float(numbers[f"largest torque of the latch at the root, {name} [N m]"]) for name in ("flexible", "rigid"))
    numbers["latch torque, flexible over rigid"] = flexible / rigid
    return Finding(
        "Flexible panels soften the shock of the latches.",
        flexible < rigid,
        rounded(numbers),
        "Rigid panels stop against the latches alone; flexible ones bend on. Both arrays then swing on their latches, whose "
        "stiffness sets the frequency.",
    )


def energy(runs: Runs) -> Finding:
    """The springs' energy goes into motion, heat, and the vibration that is left."""
    numbers: Numbers = {}
    worst = 0.0
    for name, run in runs.items():
        strain = run.samples("energy.strain")
        balance = run.samples("energy.balance")
        numbers[f"energy stored in the springs, {name} [J]"] = float(strain[0])
        numbers[f"turned into heat, {name} [J]"] = float(run.samples("work.dissipated")[-1])
        numbers[f"left in motion and springs, {name} [J]"] = float(strain[-1] + run.samples("energy.kinetic")[-1])
        numbers[f"energy balance at the end, {name} [J]"] = float(balance[-1])
        worst = max(worst, float(np.abs(balance).max()) / float(strain[0]))
    numbers["largest part of the springs' energy that the balance leaves over [%]"] = 100.0 * worst
    return Finding(
        "Check of our own: the springs' energy is found again as heat and vibration.",
        worst < 0.05,
        rounded(numbers),
        "The rest is numerical damping of what vibrates faster than the step, and the heat of the first instants of the latches, "
        "which is summed step by step.",
    )
