"""Systems drawn by chance from what there is, in units and in a place of one's choice."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

import lamella as lm
from lamella.roles import Floats
from lamella.system import System

STEPS, STEP = 15, 2e-3


@dataclass(frozen=True)
class World:
    """Where and in which units a system stands: lengths, times and masses are counted in these units, all is turned and moved."""

    m: float = 1.0
    s: float = 1.0
    kg: float = 1.0
    turn: Rotation = Rotation.identity()
    place: tuple[float, float, float] = (0.0, 0.0, 0.0)

    def of(self, value: float, kg: int = 0, m: int = 0, s: int = 0) -> float:
        """A quantity of the dimension kg^a m^b s^c in the units of this world."""
        return float(value * self.kg**kg * self.m**m * self.s**s)

    def point(self, x: Floats) -> tuple[float, ...]:
        return tuple((self.m * (self.turn.apply(x) + self.place)).tolist())

    def vector(self, x: Floats, kg: int = 0, m: int = 0, s: int = 0) -> tuple[float, ...]:
        return tuple((self.of(1.0, kg, m, s) * self.turn.apply(x)).tolist())

    def rotation(self, r: Rotation) -> tuple[float, ...]:
        return tuple((self.turn * r).as_rotvec().tolist())

    def lengths(self, *values: float) -> tuple[float, ...]:
        return tuple(self.of(value, m=1) for value in values)


class Draw:
    """Numbers and choices of one seed."""

    def __init__(self, seed: int) -> None:
        self._random = np.random.default_rng(seed)

    def between(self, low: float, high: float) -> float:
        return float(self._random.uniform(low, high))

    def vector(self, size: float = 1.0) -> Floats:
        return size * self._random.standard_normal(3)

    def one_of(self, *choices):
        return choices[self._random.integers(len(choices))]


def random_system(seed: int, world: World) -> System:
    """One or two panels, on a support, on a body with a joint or free, with loads, springs, contact or heat."""
    draw, system = Draw(seed), System("drop")
    heated = draw.one_of(True, False)
    size, mesh = (draw.between(0.5, 1.2), draw.between(0.3, 0.8)), (draw.one_of(1, 2, 3), draw.one_of(1, 2))
    thickness, pose, at = draw.between(1e-3, 8e-3), Rotation.from_rotvec(draw.vector()), draw.vector(0.5)
    element = "plate48" if heated else draw.one_of("plate48", "plate36")
    strain = "exact" if heated else draw.one_of("exact", "exact", "exact", "floating", "corotational")
    heat = {"alpha": 3e-5, "k": world.of(draw.between(0.5, 50.0), 1, 1, -3), "c": world.of(900.0, 0, 2, -2)}
    stuff = {"E": world.of(10 ** draw.between(9.5, 10.8), 1, -1, -2), "nu": 0.3, "rho": world.of(1500.0, 1, -3), **heat}
    layup = lm.Laminate(lm.Isotropic(**stuff), thickness=world.of(thickness, m=1))
    made = {"element": element, "damping": world.of(draw.one_of(1e-4, 2e-3), s=1)}
    hold = draw.one_of("clamp", "hinge", "body", "joint", "joint", "free")
    free = hold in ("body", "free")  # then the whole is thrown and spins
    speed, spin = draw.vector(0.5 * free), draw.vector(0.5 * free)

    def thrown(x: Floats) -> dict[str, tuple[float, ...]]:
        velocity = world.vector(speed + np.cross(spin, x), m=1, s=-1)
        return {"velocity": velocity, "angular_velocity": world.vector(spin, s=-1)}

    def plate(name: str, length: float, cells: int, at: Floats, pose: Rotation, **more: str) -> lm.Plate:
        place = {"position": world.point(at), "rotation": world.rotation(pose), **thrown(at)}
        sides = world.lengths(length, size[1])
        return system.add(lm.Plate(name, sides, (cells, mesh[1]), layup, **place, **made, **more))

    panel = plate("panel", size[0], mesh[0], at, pose, strain=strain)
    ground = system.add(lm.Ground())
    if hold == "clamp":
        system.add(lm.Clamp("root", panel.edge("x-"), kind=draw.one_of("full", "restrained") if strain == "exact" else "full"))
    elif hold == "hinge":
        system.add(lm.EdgeSupport("root", panel.edge("x-")))
    elif hold != "free":
        centre = at + pose.apply([-0.2, 0.5 * size[1], 0.0])
        hub = _hub(draw, world, system, panel, centre, pose, strain, thrown(centre))
        if hold == "joint":
            system.add(_joint(draw, world, ground.marker("post", *world.point(centre)), hub.origin))
    if strain == "exact" and draw.one_of(True, False):
        joined, bend = draw.one_of(True, False), Rotation.from_rotvec([0, draw.between(-1, 1), 0])
        second = plate("second", 0.5, 1, at + pose.apply([size[0], 0, 0]), pose if joined else pose * bend)
        if joined:
            system.add(lm.FixedJoint("seam", panel.edge("x+"), second.edge("x-")))
        else:
            hinge = system.add(lm.EdgeHinge("hinge", panel.edge("x+"), second.edge("x-")))
            system.add(lm.TorsionSpring("spring", hinge, world.of(5.0, 1, 2, -2), world.of(0.1, 1, 2, -1)))
    _load(draw, world, system, ground, panel, at, pose, size)
    if heated:
        system.add(lm.TemperatureField("heat", panel, reference=290.0))
        sun = {"absorptivity": 0.8, "constant": world.of(5000.0, kg=1, s=-3), "model": draw.one_of("coupled", "uncoupled")}
        system.add(lm.SolarFlux("sun", panel, direction=world.vector(pose.apply([0.3, 0.2, -1.0])), **sun))
    elif strain == "exact" and draw.one_of(True, False):
        law = {"stiffness": world.of(1e8, 1, 0, -2) / world.of(1.0, m=2) / world.of(1.0, m=1) ** 0.5, "mu": draw.between(0, 0.5)}
        law |= {"damping": world.of(0.05, m=-1, s=1), "friction": lm.RegularisedFriction(velocity=world.of(1e-2, m=1, s=-1))}
        below = at + pose.apply([0.5 * size[0], 0.5 * size[1], -0.2 - 0.6 * thickness])
        system.add(lm.SphereContact("ball", panel, ground.marker("ball", *world.point(below)), world.of(0.2, m=1), **law))
    return system


def _hub(draw, world, system, panel, centre, pose, strain, thrown) -> lm.RigidBody:
    inertia = tuple(world.of(draw.between(0.3, 0.5), 1, 2) for _ in range(3))
    place = {"position": world.point(centre), "rotation": world.rotation(pose)}
    hub = system.add(lm.RigidBody("hub", world.of(5.0, kg=1), inertia, **place, **thrown))
    clamping = draw.one_of("full", "restrained") if strain == "exact" else "full"
    system.add(lm.FixedJoint("mount", hub.marker("rim", *world.lengths(0.2, 0, 0)), panel.edge("x-"), kind=clamping))
    return hub


def _joint(draw, world, post, pivot):
    axis, across = draw.vector(), draw.vector()
    across -= axis * (across @ axis) / (axis @ axis)
    return draw.one_of(
        lm.SphericalJoint("joint", post, pivot),
        lm.RevoluteJoint("joint", post, pivot, world.vector(axis)),
        lm.PrismaticJoint("joint", post, pivot, world.vector(axis)),
        lm.UniversalJoint("joint", post, pivot, world.vector(axis), world.vector(across)),
    )


def _load(draw, world, system, ground, panel, at, pose, size) -> None:
    tip = panel.marker("tip", *world.lengths(size[0], 0.3 * size[1]))
    rise = lm.SmoothStep(t_end=world.of(0.02, s=1))
    force = world.vector(draw.vector(3.0), 1, 1, -2)
    system.add(lm.PointForce("push", tip, force, rise, follower=draw.one_of(True, False)))
    system.add(lm.Gravity("weight", world.vector(draw.vector(5.0), m=1, s=-2)))
    if draw.one_of(True, False):
        system.add(lm.Pressure("wind", panel, world.of(draw.between(-20, 20), 1, -1, -2)))
    if draw.one_of(True, False):
        anchor = ground.marker("anchor", *world.point(at + pose.apply([*size, 0.5])))
        stiffness, damping = world.of(200.0, kg=1, s=-2), world.of(1.0, kg=1, s=-1)
        system.add(lm.SpringDamper("spring to ground", anchor, tip, stiffness, damping))


def ended(system: System, world: World) -> tuple[Floats, Floats]:
    """Positions, turned back and in metres, and temperatures with their gradients, at the end of a short motion."""
    newton = lm.Newton(tolerance=1e-10, max_iterations=60, keep=0.3)
    integrator = lm.GeneralizedAlpha(world.of(STEP, s=1), rho_inf=0.8, newton=newton)
    result = lm.simulate(system, STEPS * integrator.dt, integrator)
    model, q = result.model, result.final.q
    positions = model.vectors(q)[model.is_position] / world.m
    heat = q[model.n_motion :].reshape(-1, 2) * (1.0, world.m)  # at each node T_N and T_M, which is by length
    return world.turn.inv().apply(positions - world.place), heat
