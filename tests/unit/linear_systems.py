"""Small systems with inputs, whose linear models are tested."""

from __future__ import annotations

import numpy as np

import lamella as lm

ALUMINIUM = lm.Isotropic(E=70e9, nu=0.3, rho=2700.0)
SECTION = lm.Laminate(ALUMINIUM, thickness=2e-3)
OFF = lm.Constant(0.0)


def system_of(*items):
    system = lm.System()
    for item in items:
        system.add(item)
    return system


def cantilever(load=0.0, damping=0.0, size=(0.5, 0.2), mesh=(3, 1)):
    """A clamped plate with a force of 1 N at its tip, times ``load``."""
    plate = lm.Plate("plate", size, mesh, SECTION, damping=damping)
    tip = plate.marker("tip", size[0], 0.5 * size[1])
    clamp = lm.Clamp("root", plate.edge("x-"))
    return system_of(plate, clamp, lm.PointForce("load", tip, (0, 0, 1.0), profile=lm.Constant(load)))


MASS, INERTIA, ARM = 2.0, 0.03, 0.7


def pendulum(angle=0.0, torque=OFF):
    """A body on a revolute joint about -y, turned by ``angle`` from where it hangs."""
    ground, (c, s) = lm.Ground(), (np.cos(angle), np.sin(angle))
    place = {"position": (ARM * s, 0, -ARM * c), "rotation": (0, -angle, 0)}
    bob = lm.RigidBody("bob", mass=MASS, inertia=(0.02, INERTIA, 0.01), **place)
    pin = lm.RevoluteJoint("pin", ground.origin, bob.marker("hub", 0, 0, ARM), axis=(0, -1, 0))
    motor = lm.PointMoment("motor", bob.origin, (0, -1.0, 0), profile=torque)
    return system_of(ground, bob, pin, lm.Gravity("gravity"), motor)


M_B, STIFFNESS, DAMPER = 3.0, 300.0, 2.0


def carriage():
    """A mass b behind a spring and a damper on a carriage a of 1 kg, which a drive moves."""
    ground = lm.Ground()
    a = lm.RigidBody("a", mass=1.0, inertia=(1, 1, 1))
    b = lm.RigidBody("b", mass=M_B, inertia=(1, 1, 1), position=(1, 0, 0))
    rail_a = lm.PrismaticJoint("rail_a", ground.origin, a.origin, axis=(1, 0, 0))
    rail_b = lm.PrismaticJoint("rail_b", a.origin, b.origin, axis=(1, 0, 0))
    spring = lm.SlideSpring("spring", rail_b, stiffness=STIFFNESS, damping=DAMPER, rest=lm.Constant(1.0))
    return system_of(ground, a, b, rail_a, rail_b, spring, lm.SlideDrive("drive", rail_a, displacement=OFF))


def hub(omega=0.0, torque=0.0, spin=False, hold=False, damping=0.0):
    """A hub about z with a blade that bends in the plane of rotation, and a motor between ground and hub."""
    ground = lm.Ground()
    body = lm.RigidBody("hub", mass=1.0, inertia=(2e-3, 2e-3, 2e-3), angular_velocity=(0, 0, omega))
    place = {"position": (0.05, 0, -0.025), "rotation": (np.pi / 2, 0, 0)}
    blade = lm.Plate("blade", (0.4, 0.05), (3, 1), SECTION, damping=damping, **place)
    blade.marker("tip", 0.4, 0.025)
    pin = lm.RevoluteJoint("pin", ground.origin, body.origin, axis=(0, 0, 1))
    root = lm.FixedJoint("root", body.marker("rim", 0.05, 0, 0), blade.edge("x-"))
    motor = lm.PointMoment("motor", body.origin, (0, 0, 1.0), profile=lm.Constant(torque))
    frame = [lm.SteadySpin("spin", (0, 0, omega))] if spin else []
    drive = [lm.AngleDrive("drive", pin, angle=OFF)] if hold else []
    return system_of(ground, body, blade, pin, root, motor, *frame, *drive)
