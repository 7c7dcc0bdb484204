"""Small mechanisms with one free motion, on which springs, drives, couplings and cables are tried."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

import lamella as lm

MASS, ARM, INERTIA = 2.0, 0.5, 0.2
"""An arm of mass MASS [kg] turns about a pin ARM [m] beside its centre, about which its inertia is INERTIA [kg m^2]."""
ABOUT_PIN = INERTIA + MASS * ARM**2
G = 9.81
SHEET = lm.Laminate(lm.Isotropic(E=70e9, nu=0.3, rho=2700.0), thickness=0.004)


def arm(*extra: Callable[[lm.System, lm.RevoluteJoint, lm.RigidBody], object], gravity: bool = True, joint=lm.RevoluteJoint):
    """An arm that points along x and turns about y, downwards for a growing angle; ``extra`` adds to it."""
    system, ground = lm.System(), lm.Ground()
    body = system.add(lm.RigidBody("arm", mass=MASS, inertia=(0.05, INERTIA, INERTIA), position=(ARM, 0.0, 0.0)))
    pin = system.add(joint("pin", ground.origin, body.marker("heel", -ARM, 0.0, 0.0), axis=(0, 1, 0)))
    for make in extra:
        system.add(make(system, pin, body))
    if gravity:
        system.add(lm.Gravity("gravity"))
    return system


def slider(*extra, gravity: bool = True):
    """A block that slides down along -z, on a prismatic joint whose displacement grows downwards."""
    system, ground = lm.System(), lm.Ground()
    body = system.add(lm.RigidBody("block", mass=MASS, inertia=(0.05, 0.06, 0.07), position=(0.0, 0.0, 0.3)))
    guide = system.add(lm.PrismaticJoint("guide", ground.marker("post", 0.0, 0.0, 0.3), body.origin, axis=(0, 0, -1)))
    for make in extra:
        system.add(make(system, guide, body))
    if gravity:
        system.add(lm.Gravity("gravity"))
    return system


def leaves(*extra, points=None):
    """Two plates that share an edge along y at x = 1, the first one clamped."""
    system = lm.System()
    first = system.add(lm.Plate("first", (1.0, 0.6), (1, 2), SHEET))
    second = system.add(lm.Plate("second", (1.0, 0.6), (1, 2), SHEET, position=(1.0, 0.0, 0.0)))
    system.add(lm.Clamp("root", first.edge("x-")))
    hinge = system.add(lm.EdgeHinge("hinge", first.edge("x+"), second.edge("x-"), points=points))
    for make in extra:
        system.add(make(system, hinge, second))
    return system


def pair(*extra):
    """Two wheels on pins along z."""
    system, ground, joints = lm.System(), lm.Ground(), []
    for k in range(2):
        wheel = system.add(lm.RigidBody(f"wheel{k}", mass=1.0, inertia=(0.2, 0.2, 0.2 + 0.1 * k), position=(2.0 * k, 0.0, 0.0)))
        hub = wheel.marker(f"hub{k}", 0.0, 0.0, 0.0)
        joints.append(system.add(lm.RevoluteJoint(f"pin{k}", ground.marker(f"post{k}", 2.0 * k, 0.0, 0.0), hub)))
    for make in extra:
        system.add(make(system, joints, system.bodies))
    return system


def simulated(system: lm.System, t_end: float, dt: float = 2e-3, rho_inf: float = 0.9) -> lm.Result:
    return lm.simulate(system, t_end, lm.GeneralizedAlpha(dt=dt, rho_inf=rho_inf))


def resultants(model, f, owner: str, about) -> tuple[np.ndarray, np.ndarray]:
    """Force and torque about a point of generalised forces ``f`` (n_q,) on one body, at the reference or a given state."""
    q, about = about
    mine = np.array([name == owner for name in model.owners])
    x, Q = q.reshape(-1, 3)[mine], f.reshape(-1, 3)[mine]
    places = model.is_position[mine]
    force = Q[places].sum(axis=0)
    return force, np.cross(x, Q).sum(axis=0) - np.cross(about, force)
