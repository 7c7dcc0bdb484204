"""Linear models against small steps of the nonlinear systems, natural frequencies and statics."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

import lamella as lm
from lamella.roles import Floats
from lamella.state import State
from lamella.verification import Curves, Evidence, References

slow = True

ALUMINIUM = lm.Laminate(lm.Isotropic(E=70e9, nu=0.3, rho=2700.0), thickness=2e-3)
LENGTH, WIDTH, PLATE_STEP, TIP_LOAD = 0.5, 0.2, 2e-2, 20.0  # m, m, N, N
CRANK, ROD, SIDE, SPRING = 0.15, 0.30, 0.008, 40.0  # m, m, m, N m
ANGLE, CRANK_STEP = np.pi / 3, 1e-2  # rad, N m
OMEGA, HUB_STEP = 20.0, 1e-4  # rad/s, N m


def built(*items: object) -> lm.System:
    """A system of some declarations."""
    system = lm.System()
    for item in items:
        system.add(item)  # type: ignore[type-var]
    return system


def plate(load: float) -> lm.System:
    """A cantilever plate with damping and a force at its tip [N]."""
    sheet = lm.Plate("plate", (LENGTH, WIDTH), (4, 2), ALUMINIUM, damping=1e-4)
    tip = sheet.marker("tip", LENGTH, 0.5 * WIDTH)
    force = lm.PointForce("load", tip, (0.0, 0.0, 1.0), profile=lm.Constant(load))
    return built(sheet, lm.Clamp("root", sheet.edge("x-")), force)


def crank(torque: float) -> lm.System:
    """A slider-crank at 60 degrees with a flexible rod: all of its joints take multipliers. A spring holds the crank."""
    steel = lm.Laminate(lm.Isotropic(E=2e11, nu=0.0, rho=7870.0), thickness=SIDE)
    c, s = np.cos(ANGLE), np.sin(ANGLE)
    down = np.arcsin(CRANK * s / ROD)
    end = CRANK * c + ROD * np.cos(down)
    ground = lm.Ground()
    arm = lm.RigidBody(
        "crank", mass=0.36, inertia=(1e-4, 1e-3, 1e-3), position=(0.5 * CRANK * c, 0, 0.5 * CRANK * s), rotation=(0, -ANGLE, 0)
    )
    corner = (CRANK * c, -0.5 * SIDE, CRANK * s)
    rod = lm.Plate("rod", (ROD, SIDE), (3, 1), steel, strain="floating", position=corner, rotation=(0, down, 0))
    slider = lm.RigidBody("slider", mass=0.076, inertia=(1e-4, 1e-4, 1e-4), position=(end, 0, 0))
    big, small = rod.marker("big", 0.0, 0.5 * SIDE), rod.marker("small", ROD, 0.5 * SIDE)
    rod.marker("middle", 0.5 * ROD, 0.5 * SIDE)  # recorded
    pin = lm.RevoluteJoint("pin", ground.origin, arm.marker("hub", -0.5 * CRANK, 0, 0), axis=(0, -1, 0))
    return built(
        *(ground, arm, rod, slider, pin),
        lm.RevoluteJoint("elbow", arm.marker("tip", 0.5 * CRANK, 0, 0), big, axis=(0, -1, 0)),
        lm.RevoluteJoint("wrist", slider.origin, small, axis=(0, -1, 0)),
        lm.PrismaticJoint("rail", ground.origin, slider.origin, axis=(1, 0, 0)),
        lm.TorsionSpring("spring", pin, stiffness=SPRING, damping=0.02),
        lm.PointMoment("motor", arm.origin, (0.0, -1.0, 0.0), profile=lm.Constant(torque)),
    )


def hub(torque: float, *, spin: bool, hold: bool = False) -> lm.System:
    """A hub that turns about z with a blade that bends in the plane of rotation; described in its frame with ``spin``."""
    ground = lm.Ground()
    body = lm.RigidBody("hub", mass=1.0, inertia=(2e-3, 2e-3, 2e-3), angular_velocity=(0, 0, OMEGA))
    blade = lm.Plate("blade", (0.4, 0.05), (4, 1), ALUMINIUM, position=(0.05, 0, -0.025), rotation=(0.5 * np.pi, 0, 0))
    blade.marker("tip", 0.4, 0.025)
    pin = lm.RevoluteJoint("pin", ground.origin, body.origin, axis=(0, 0, 1))
    return built(
        *(ground, body, blade, pin),
        lm.FixedJoint("root", body.marker("rim", 0.05, 0, 0), blade.edge("x-")),
        lm.PointMoment("motor", body.origin, (0.0, 0.0, 1.0), profile=lm.Constant(torque)),
        *([lm.SteadySpin("spin", (0.0, 0.0, OMEGA))] if spin else []),
        *([lm.AngleDrive("drive", pin, angle=lm.Constant(0.0))] if hold else []),
    )


def difference(found: Floats, expected: Floats) -> float:
    """Largest difference over the time, as a share of the largest value."""
    return float(np.abs(found - expected).max() / np.abs(expected).max())


def bent_plate(references: References) -> Iterator[Evidence]:
    """A step of the force on a plate that is bent already, with its gain and its poles."""
    still = lm.equilibrium(plate(TIP_LOAD), steps=4)
    linear = lm.linearise(plate(TIP_LOAD), ("load",), ("tip.position.z", "root.torque.y"), state=still.final)
    model = linear.state_space()
    run = lm.simulate(plate(TIP_LOAD + PLATE_STEP), 0.3, lm.GeneralizedAlpha(dt=5e-4, rho_inf=0.95), initial=still.final)
    z = (run["tip.position"].values[:, 2] - model.output_values[0]) / PLATE_STEP
    y = model.step_response(run.at, "load")
    yield references.check("plate, step of the force", difference(z, y[:, 0]))
    reduced = linear.state_space(6).step_response(run.at, "load")
    yield references.check("plate, step of the force, six modes", difference(z, reduced[:, 0]))
    ends = [lm.equilibrium(plate(TIP_LOAD + sign * PLATE_STEP), steps=4) for sign in (1.0, -1.0)]
    for k, (name, component) in enumerate((("tip.position", 2), ("root.torque", 1))):
        static = (ends[0][name].values[component] - ends[1][name].values[component]) / (2.0 * PLATE_STEP)
        yield references.check(f"plate, gain at rest of {name}", model.dc_gain()[k, 0] / static - 1.0)
    undamped = _without_damping()
    poles = lm.linearise(undamped, ("load",), ("tip.position.z",), state=still.final).state_space(6).poles()
    natural = lm.modes(undamped, 6, state=still.final).frequencies
    found = np.sort(poles.imag[poles.imag > 0.0])[:6] / (2.0 * np.pi)
    yield references.check("plate, poles against natural frequencies", float(np.abs(found / natural - 1.0).max()))
    chosen = slice(None, None, 20)
    yield Curves(
        "Tip of a bent plate after a small step of the force",
        "Time [s]",
        "Displacement for each newton [m]",
        {"linear model": (run.at, y[:, 0])},
        {"nonlinear motion": (run.at[chosen], z[chosen])},
    )


def _without_damping() -> lm.System:
    system = plate(TIP_LOAD)
    sheet = replace(system.declarations[0], damping=0.0)  # type: ignore[type-var]
    tip = sheet.marker("tip", LENGTH, 0.5 * WIDTH)
    force = lm.PointForce("load", tip, (0.0, 0.0, 1.0), profile=lm.Constant(TIP_LOAD))
    return built(sheet, lm.Clamp("root", sheet.edge("x-")), force)


def slider_crank(references: References) -> Iterator[Evidence]:
    """A step of the torque on a mechanism whose joints take multipliers, held aside by a torque."""
    names = ("pin.angle", "middle.position.z", "slider.position.x")
    linear = lm.linearise(crank(0.0), ("motor",), names)
    model = linear.state_space()
    run = lm.simulate(crank(CRANK_STEP), 0.2, lm.GeneralizedAlpha(dt=2.5e-4, rho_inf=0.95))
    y = model.step_response(run.at, "motor")
    values = (run["pin.angle"].values, run["middle.position"].values[:, 2], run["slider.position"].values[:, 0])
    for k, (name, found) in enumerate(zip(names, values, strict=True)):
        change = (found - model.output_values[k]) / CRANK_STEP
        yield references.check(f"slider-crank, step of the torque, {name}", difference(change, y[:, k]))
    yield references.check("slider-crank, gain at rest of the angle", model.dc_gain()[0, 0] * SPRING)


def spinning_hub(references: References) -> Iterator[Evidence]:
    """Steps of the torque on a hub that spins: constant matrices in its frame, nonlinear motions in the inertial one.

    Half the difference of a step up and one down is free of the square of the turn, which is larger than what moves the tip
    along the blade in proportion: the centrifugal force of a faster hub, in the frame a Coriolis force. It is 1e-7
    of what the tip moves across, so the steps are small and solved to rounding.
    """
    state = lm.equilibrium(hub(0.0, spin=True, hold=True)).final
    system = hub(0.0, spin=True)
    names = ("hub.euler.yaw", "tip.position.y", "tip.position.x")
    model = lm.linearise(system, ("motor",), names, state=state).state_space()
    runs, method = [], lm.GeneralizedAlpha(dt=5e-4, rho_inf=0.95, newton=lm.Newton(tolerance=1e-12))
    for torque in (HUB_STEP, -HUB_STEP):
        inertial = hub(torque, spin=False).compile()
        v = np.cross([0.0, 0.0, OMEGA], state.q.reshape(-1, 3)).reshape(-1)
        start = State(0.0, state.q, v, np.zeros_like(v), np.zeros(inertial.n_lam), state.reaction)
        runs.append(lm.simulate(inertial, 0.15, method, initial=start))
    angles = [run["pin.angle"].values for run in runs]
    frame = 0.5 * (angles[0] + angles[1])  # its own lag behind Omega t, 1e-5, would turn some of the way across into one along
    c, s = np.cos(frame), np.sin(frame)
    (x, y), (x_, y_) = (run["tip.position"].values[:, :2].T for run in runs)
    found = np.stack([angles[0] - angles[1], c * (y - y_) - s * (x - x_), c * (x - x_) + s * (y - y_)]) / (2.0 * HUB_STEP)
    y = model.step_response(runs[0].at, "motor").T
    for k, name in enumerate(("angle", "tip across the blade", "tip along the blade")):
        yield references.check(f"spinning hub, step of the torque, {name}", difference(found[k], y[k]))


def run() -> Iterator[Evidence]:
    """Yield the checks and pictures of this case."""
    references = References.beside(__file__)
    for part in (bent_plate, slider_crank, spinning_hub):
        yield from part(references)
