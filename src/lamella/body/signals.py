"""Signals that bodies record."""

from __future__ import annotations

import numpy as np

from lamella.body.rigid_frame import RigidFrame
from lamella.dofs import Signal
from lamella.kinematics import PointRows, vectors_of
from lamella.math.rotation import euler_from_rotation, quaternion_from_rotation
from lamella.roles import Floats
from lamella.state import OncePerState, State

AXES = ("x", "y", "z")


def marker_signals(name: str, where: str, rows: PointRows) -> list[Signal]:
    """Position and velocity of a marker."""

    def velocity(state: State) -> Floats:
        return rows.moved(vectors_of(state.v))

    position = f"{name}.position", "m", AXES, lambda state: rows.at(vectors_of(state.q)), f"position of {where}"
    return [
        Signal(*position, derivative=lambda _, change: rows.moved(vectors_of(change.q)), of_vectors=rows.vectors),
        Signal(
            f"{name}.velocity",
            "m/s",
            AXES,
            velocity,
            f"velocity of {where}",
            derivative=lambda _, change: velocity(change),
            of_vectors=rows.vectors,
        ),
    ]


def rigid_signals(name: str, frame: RigidFrame) -> list[Signal]:
    """Position, velocity and orientation of a rigid body, and its angular velocity w = 1/2 sum_i d_i x d_i'."""
    first, axes = frame.first, slice(frame.first + 1, frame.first + 4)

    def angular_velocity(state: State) -> Floats:
        S = vectors_of(state.q)[axes].T @ vectors_of(state.v)[axes]  # twice its skew part; cross is slow on this
        return 0.5 * np.array([S[1, 2] - S[2, 1], S[2, 0] - S[0, 2], S[0, 1] - S[1, 0]])

    def position(state: State) -> Floats:
        return vectors_of(state.q)[first].copy()

    def velocity(state: State) -> Floats:
        return vectors_of(state.v)[first].copy()

    turned = OncePerState(lambda state: frame.rotation(state.q))
    elements = tuple(f"{i}{j}" for i in AXES for j in AXES)
    where = f"the origin of {name}"
    return [
        Signal(f"{name}.position", "m", AXES, position, f"position of {where}", derivative=lambda _, change: position(change)),
        Signal(f"{name}.velocity", "m/s", AXES, velocity, f"velocity of {where}", derivative=lambda _, change: velocity(change)),
        Signal(f"{name}.rotation", "1", elements, lambda s: turned(s).reshape(-1), f"rotation matrix of {name}"),
        Signal(
            f"{name}.quaternion",
            "1",
            ("w", "x", "y", "z"),
            lambda s: quaternion_from_rotation(turned(s)),
            f"orientation of {name} as a unit quaternion",
        ),
        Signal(
            f"{name}.euler",
            "rad",
            ("yaw", "pitch", "roll"),
            lambda s: euler_from_rotation(turned(s)),
            f"orientation of {name} as angles about the turned axes z, y, x",
        ),
        Signal(f"{name}.angular_velocity", "rad/s", AXES, angular_velocity, f"angular velocity of {name} in the inertial frame"),
    ]
