"""A plate made of one biquadratic patch, whose position, normal and strains are exact and cheap: results to draw and to write."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np

import lamella as lm
from lamella.body.mesh import PlateSample
from lamella.dofs import Signal
from lamella.material.lamina import Lamina
from lamella.material.laminate import Laminate
from lamella.result import Cause, Outcome, Recorder, Result, Statistics
from lamella.state import State

STRONG = {"Xt": 1500e6, "Xc": 1500e6, "Yt": 40e6, "Yc": 246e6, "S12": 68e6}
SIZE = (1.5, 2.0)


def laminate(**strengths: float) -> Laminate:
    return Laminate(Lamina(E1=181e9, E2=10.3e9, G12=7.7e9, nu12=0.28, rho=1560, **strengths), angles=(0, 90, 0), thickness=1.5e-3)


class QuadraticPlate:
    """Nine points, shape (3, 3), numbered x fastest, interpolated by Lagrange polynomials of degree 2 in each direction."""

    temperature = None
    loops = (False, False)

    nx, ny = 4, 4

    def __init__(self, name: str, first: int = 0, **strengths: float) -> None:
        self.name, self.size, self.laminate, self.first = name, SIZE, laminate(**strengths), first

    def sample(self, q: Any, per_element: int = 4) -> PlateSample:
        return self.grid(per_element).sample(q)

    def grid(self, per_element: int = 4) -> QuadraticGrid:
        return QuadraticGrid(self, per_element)


class QuadraticGrid:
    """Points of a :class:`QuadraticPlate`."""

    def __init__(self, plate: QuadraticPlate, per_element: int) -> None:
        counts = zip(SIZE, (plate.nx, plate.ny), strict=True)
        self.x, self.y = (np.linspace(0.0, length, n * per_element + 1) for length, n in counts)
        self.laminate, self.mine = plate.laminate, slice(3 * plate.first, 3 * plate.first + 27)

    def derivatives(self, q: Any) -> dict[tuple[int, int], Any]:
        bx, by = basis(self.x, SIZE[0]), basis(self.y, SIZE[1])
        nodes = q[..., self.mine].reshape(*q.shape[:-1], 3, 3, 3)
        return {(i, j): np.einsum("ay,bx,...abc->...yxc", by[j], bx[i], nodes) for i in range(3) for j in range(3 - i)}

    def positions(self, q: Any) -> Any:
        return self.derivatives(q)[0, 0]

    def sample(self, q: Any) -> PlateSample:
        at = self.derivatives(q)
        r_x, r_y = at[1, 0], at[0, 1]
        n = np.cross(r_x, r_y)
        n /= np.linalg.norm(n, axis=-1, keepdims=True)
        dot = lambda a, b: np.sum(a * b, axis=-1)  # noqa: E731
        eps = [0.5 * (dot(r_x, r_x) - 1), 0.5 * (dot(r_y, r_y) - 1), dot(r_x, r_y)]
        kap = [dot(at[2, 0], n), dot(at[0, 2], n), 2 * dot(at[1, 1], n)]
        return PlateSample(self.laminate, self.x, self.y, at[0, 0], n, np.stack(eps + kap, axis=-1))


def basis(s: Any, length: float) -> Any:
    """Values and two derivatives of the three Lagrange polynomials on [0, length]; shape (3, 3, len(s)): derivative, node."""
    t, one = s / length, np.ones_like(s)
    values = [(1 - t) * (1 - 2 * t), 4 * t * (1 - t), t * (2 * t - 1)]
    first = [(4 * t - 3) / length, (4 - 8 * t) / length, (4 * t - 1) / length]
    second = [4 * one / length**2, -8 * one / length**2, 4 * one / length**2]
    return np.array([values, first, second])


def flat(offset: float = 0.0) -> Any:
    j, i = np.divmod(np.arange(9), 3)
    return np.stack([i * SIZE[0] / 2, j * SIZE[1] / 2 + offset, 0.0 * i], axis=1)


def swinging(q0: Any, t: float) -> Any:
    """Coordinates at time t: the plate bends down along x like a cantilever and twists a little."""
    nodes = q0.reshape(-1, 3).copy()
    s = nodes[:, 0] / SIZE[0]
    nodes[:, 2] -= 0.5 * np.sin(2 * np.pi * t) ** 2 * s**2 * (1 + 0.3 * nodes[:, 1])
    return nodes.reshape(-1)


def rates(q0: Any, t: float) -> Any:
    step = 1e-6
    return (swinging(q0, t + step) - swinging(q0, t - step)) / (2 * step)


def energies(t: float) -> tuple[float, float, float]:
    """Kinetic and strain energy and the loads' work of an oscillator that starts at rest, in balance."""
    work = 4.0 * np.sin(2 * np.pi * t) ** 2
    kinetic = work * np.cos(2 * np.pi * t) ** 2
    return kinetic, work - kinetic, work


def signals(scale: float = 1.0) -> tuple[Signal, ...]:
    return (
        Signal("C.position", "m", ("x", "y", "z"), lambda s: scale * s.q[24:27], "position of plate.C"),
        Signal(
            "root.force", "N", ("x", "y", "z"), lambda s: np.array([0.0, 0.1, 10.0 * np.sin(40 * s.t)]), "force of support root"
        ),
        Signal("energy.kinetic", "J", (), lambda s: energies(s.t)[0], "kinetic energy"),
        Signal("energy.strain", "J", (), lambda s: energies(s.t)[1], "strain energy"),
        Signal("work.loads", "J", (), lambda s: energies(s.t)[2], "work of the loads"),
        Signal("work.dissipated", "J", (), lambda s: 0.0, "energy turned into heat by damping"),
        Signal("energy.balance", "J", (), lambda s: -1e-5 * s.t, "energy balance: zero for an exact solution"),
    )


def result(plates: int = 1, frames: int = 10, scale: float = 1.0, axis: str = "time", **strengths: float) -> Result:
    """A finished run of one or two swinging plates; ``frame_v`` is kept as result files do."""
    q0 = np.concatenate([flat(2.5 * k) for k in range(plates)]).reshape(-1)
    model = SimpleNamespace(
        imperfection=None,
        q0=q0,
        plates=tuple(QuadraticPlate(f"plate{k}", 9 * k, **strengths) for k in range(plates)),
        rigid_bodies=(),
        description=None,
    )
    recorder = Recorder(signals(scale), axis, 0.0, 0.5, frames=frames)
    velocities = []
    for t in np.linspace(0.0, 0.5, 10 * frames + 1):
        state = State(float(t), swinging(q0, t), rates(q0, t), q0, np.empty(0), np.empty(0))
        kept = len(recorder.frame_at)
        recorder.sample(float(t), state)
        velocities += [state.v] * (len(recorder.frame_at) - kept)
    done = Result(model, recorder, state, Outcome(Cause.COMPLETED, 0.5, 0.5), Statistics(steps=100, seconds_run=0.1))  # type: ignore[arg-type]
    done.frame_v = np.array(velocities)  # type: ignore[attr-defined]
    return done


def snap_through(points: int = 12) -> Result:
    """A path whose load factor passes a limit point while the plate goes on bending."""
    q0 = flat().reshape(-1)
    model = SimpleNamespace(q0=q0, plates=(QuadraticPlate("plate0"),), rigid_bodies=(), description=None, imperfection=None)
    factor = Signal("load_factor", "1", (), lambda s: s.factor, "factor of loads and support motions")
    recorder = Recorder((factor, *signals()), "path", 0.0, 1.0)
    for k, t in enumerate(np.linspace(0.0, 0.25, points)):
        zero, none = np.zeros_like(q0), np.empty(0)
        state = State(0.0, swinging(q0, t), zero, zero, none, none, factor=float(np.sin(12 * t)))
        recorder.sample(float(k), state)
    return Result(model, recorder, state, Outcome(Cause.COMPLETED, 1.0, 1.0), Statistics(steps=points))  # type: ignore[arg-type]


def pendulum() -> Result:
    """A box on a pin with a ball at its end and a body without shape between them, which swing; there is no plate."""
    system, ground = lm.System(), lm.Ground()
    arm = system.add(lm.RigidBody("arm", shape=lm.Box((1.0, 0.1, 0.2)), density=1000.0, position=(0.5, 0.0, 0.0)))
    ball = system.add(lm.RigidBody("ball", shape=lm.Sphere(0.15), density=2000.0, position=(1.15, 0.0, 0.0)))
    weight = system.add(lm.RigidBody("weight", mass=3.0, inertia=(0.1, 0.1, 0.1), position=(0.5, 0.0, 0.0)))
    system.add(lm.RevoluteJoint("pin", ground.origin, arm.marker("heel", -0.5, 0.0, 0.0), axis=(0.0, 1.0, 0.0)))
    system.add(lm.FixedJoint("weld", arm.marker("tip", 0.5, 0.0, 0.0), ball.marker("pole", -0.15, 0.0, 0.0)))
    system.add(lm.FixedJoint("bolt", arm.origin, weight.origin))
    system.add(lm.Gravity("weight_force"))
    return lm.simulate(system, 0.2, lm.GeneralizedAlpha(dt=5e-3), frames=5)
