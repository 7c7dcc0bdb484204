"""Every joint between two bodies, for every pair of bodies it can join, in generic skew positions.

A pair says what a textbook says of its joint: in which of the six directions of the joint frame b can move against a.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

import lamella as lm
from lamella.math.rotation import matrix_from_vector, vector_from_matrix

SECTION = lm.Laminate(lm.Isotropic(E=2e9, nu=0.3, rho=1200.0), thickness=0.02)
AT = np.array((0.4, -0.2, 0.3))  # where the joint is [m]
AXIS, SECOND = (0.3, -0.5, 0.8), (0.7, 0.4, 0.1)
ALONG = np.array(AXIS) / np.linalg.norm(AXIS)
ACROSS = np.cross((1.0, 0.0, 0.0), ALONG) / np.linalg.norm(np.cross((1.0, 0.0, 0.0), ALONG))
INERTIA = {"mass": 2.0, "inertia": (0.11, 0.14, 0.2), "products": (0.01, -0.02, 0.015), "centre_of_mass": (0.05, -0.03, 0.08)}
TURN_A, TURN_B = (0.6, -1.1, 0.4), (-1.3, 0.2, 0.9)
SPIN_A, SPIN_B = (1.1, -0.4, 2.0), (-0.7, 1.5, 0.6)
SIZE_A, SIZE_B = (0.8, 0.6), (0.7, 0.6)


def rigid(name, turn, offset, spin, at):
    """A rigid body whose origin lies at ``at + offset``, and its marker at ``at``."""
    body = lm.RigidBody(name, **INERTIA, position=tuple(at + offset), rotation=turn, angular_velocity=spin)
    return body, body.marker(f"on {name}", *(-matrix_from_vector(np.array(turn)).T @ offset))


def panel(name, size, turn, place, spin, at, strain="exact", mesh=(1, 1)):
    """A plate whose point ``place`` lies at ``at``, and its marker there."""
    position = at - matrix_from_vector(np.array(turn)) @ (*place, 0.0)
    given = {"position": tuple(position), "rotation": turn, "angular_velocity": spin, "strain": strain}
    body = lm.Plate(name, size, mesh, SECTION, **given)
    return body, body.marker(f"on {name}", *place)


BODY_A = {
    "ground": lambda at: (ground := lm.Ground("a"), ground.marker("on a", *at)),
    "rigid": lambda at: rigid("a", TURN_A, np.array((-0.3, 0.2, 0.4)), SPIN_A, at),
    "plate": lambda at: panel("a", SIZE_A, TURN_A, (0.8, 0.25), SPIN_A, at),
    "rigid plate": lambda at: panel("a", SIZE_A, TURN_A, (0.8, 0.25), SPIN_A, at, "rigid"),
}
BODY_B = {
    "rigid": lambda at: rigid("b", TURN_B, np.array((0.25, 0.1, -0.35)), SPIN_B, at),
    "plate": lambda at: panel("b", SIZE_B, TURN_B, (0.2, 0.35), SPIN_B, at),
    "rigid plate": lambda at: panel("b", SIZE_B, TURN_B, (0.2, 0.35), SPIN_B, at, "rigid"),
}
FREE_MARKER = {  # the joint, what it leaves free, and where b's marker lies from a's
    "spherical": (lambda a, b: lm.SphericalJoint("joint", a, b), "rx ry rz", 0.0 * ALONG),
    "revolute": (lambda a, b: lm.RevoluteJoint("joint", a, b, axis=AXIS), "rz", 0.0 * ALONG),
    "prismatic": (lambda a, b: lm.PrismaticJoint("joint", a, b, axis=AXIS), "tz", 0.2 * ALONG),
    "cylindrical": (lambda a, b: lm.CylindricalJoint("joint", a, b, axis=AXIS), "tz rz", -0.15 * ALONG),
    "universal": (lambda a, b: lm.UniversalJoint("joint", a, b, axis_a=AXIS, axis_b=SECOND), "rx ry", 0.0 * ALONG),
    "point on line": (lambda a, b: lm.PointOnLineJoint("joint", a, b, axis=AXIS), "tz rx ry rz", 0.1 * ALONG),
    "point in plane": (lambda a, b: lm.PointInPlaneJoint("joint", a, b, axis=AXIS), "tx ty rx ry rz", 0.2 * ACROSS),
    "fixed": (lambda a, b: lm.FixedJoint("joint", a, b), "", 0.0 * ALONG),
}
MARKER_PAIRS = (
    ("ground", "rigid"),
    ("rigid", "rigid"),
    ("rigid", "plate"),
    ("plate", "rigid"),
    ("plate", "plate"),
    ("rigid plate", "rigid plate"),
)


@dataclass(frozen=True)
class Pair:
    """A joint between two bodies.

    Args:
        make: gives body a, body b and the joint, whose name is ``joint``.
        held: number of equations by which it lowers the number of degrees of freedom.
        free: directions of the joint frame in which a rigid b can move: ``tx`` to ``tz``, turns ``rx`` to ``rz`` about centre.
        axes: axes of the joint frame in the reference configuration as columns, shape (3, 3).
        centre: the point of b to which the joint's torque refers, in the reference configuration [m].
    """

    make: Callable
    held: int
    free: str
    axes: np.ndarray
    centre: np.ndarray

    def system(self, gravity=(1.0, -2.0, -9.0), **options):
        """The two bodies and the joint under a field of acceleration."""
        system = lm.System(**options)
        for item in self.make():
            system.add(item)
        if gravity is not None:
            system.add(lm.Gravity("gravity", gravity))
        return system


def between_markers(joint, kind_a, kind_b):
    make, free, offset = FREE_MARKER[joint]

    def bodies():
        (a, on_a), (b, on_b) = BODY_A[kind_a](AT), BODY_B[kind_b](AT + offset)
        return a, b, make(on_a, on_b)

    z = ALONG
    if joint in ("spherical", "fixed"):
        axes = np.eye(3)
    elif joint == "universal":  # x along the first axis, y along the part of the second that is perpendicular to it
        y = np.array(SECOND) - (np.array(SECOND) @ z) * z
        axes = np.stack([z, y / np.linalg.norm(y), np.cross(z, y / np.linalg.norm(y))], axis=1)
    else:
        axes = np.stack([ACROSS, np.cross(z, ACROSS), z], axis=1)
    return Pair(bodies, 6 - len(free.split()), free, axes, AT + offset)


def marker_to_edge(kind_a, strain, side="y+", mesh=(1, 2), kind="full"):
    """A fixed edge: what its kind holds of position, slopes and twist; a rigid plate loses its six degrees of freedom."""

    def bodies():
        (a, on_a), (b, _) = BODY_A[kind_a](AT), panel("b", SIZE_B, TURN_B, (0.3, 0.5), SPIN_B, AT + 0.1, strain, mesh)
        return a, b, lm.FixedJoint("joint", on_a, b.edge(side), kind=kind)

    nodes = (mesh[1] if side[0] == "x" else mesh[0]) + 1
    middle = {"y+": (0.5 * SIZE_B[0], SIZE_B[1], 0.0), "x-": (0.0, 0.5 * SIZE_B[1], 0.0)}[side]
    centre = AT + 0.1 + matrix_from_vector(np.array(TURN_B)) @ (np.array(middle) - (0.3, 0.5, 0.0))
    held = {"full": 12 * nodes, "restrained": 8 * nodes, "sliding": 6 * nodes + 1}[kind]
    return Pair(bodies, held if strain == "exact" else 6, "", np.eye(3), centre)


def mean_of_edge(kind_a, strain, free="rz", mesh=(2, 1), **held):
    """A body that carries an edge in the mean; the edge lies along the inertial z axis."""
    turn = (0.0, -0.5 * np.pi, 0.0)

    def bodies():
        (a, on_a), (b, _) = BODY_A[kind_a](AT), panel("b", SIZE_B, turn, (0.3, 0.5), SPIN_B, AT + 0.1, strain, mesh)
        return a, b, lm.EdgeAverage("joint", b.edge("y+"), to=on_a, **held)

    centre = AT + 0.1 + matrix_from_vector(np.array(turn)) @ (0.5 * SIZE_B[0] - 0.3, SIZE_B[1] - 0.5, 0.0)
    return Pair(bodies, 6 - len(free.split()), free, np.eye(3), centre)


def two_edges(joint, held, free, strain="exact", reverse=False, mesh_a=(1, 2), mesh_b=(1, 2)):
    """Two plates of 0.6 m edges, x+ of a on x- of b, or on x+ of b turned by half a turn about the normal, at a fold."""

    def bodies():
        R = matrix_from_vector(np.array(TURN_A))
        a = lm.Plate("a", SIZE_A, mesh_a, SECTION, position=tuple(AT), rotation=TURN_A, angular_velocity=SPIN_A, strain=strain)
        begin = AT + R @ (SIZE_A[0], 0.0, 0.0)
        fold = matrix_from_vector(R[:, 1] * (0.0 if joint is weld else 0.5))
        if reverse:
            turned, corner = fold @ R @ np.diag((-1.0, -1.0, 1.0)), begin + SIZE_A[1] * R[:, 1]
            corner = corner - turned @ (SIZE_B[0], 0.0, 0.0)
        else:
            turned, corner = fold @ R, begin
        vector = vector_from_matrix(turned)
        given = {"position": tuple(corner), "rotation": tuple(vector), "strain": strain}
        b = lm.Plate("b", SIZE_B, mesh_b, SECTION, angular_velocity=SPIN_B, **given)
        return a, b, joint(a.edge("x+"), b.edge("x+" if reverse else "x-"))

    R = matrix_from_vector(np.array(TURN_A))
    return Pair(bodies, held, free, R[:, [2, 0, 1]], AT + R @ (SIZE_A[0], 0.5 * SIZE_A[1], 0.0))


def hinge(a, b):
    return lm.EdgeHinge("joint", a, b)


def point_hinge(a, b):
    return lm.EdgeHinge("joint", a, b, points=(0.1, 0.45))


def weld(a, b):
    return lm.FixedJoint("joint", a, b)


PAIRS = {
    **{f"{joint}, {a} and {b}": between_markers(joint, a, b) for joint in FREE_MARKER for a, b in MARKER_PAIRS},
    "fixed edge, ground and plate": marker_to_edge("ground", "exact"),
    "fixed edge, rigid and plate": marker_to_edge("rigid", "exact"),
    "fixed edge x-, rigid and plate": marker_to_edge("rigid", "exact", "x-"),
    "fixed edge, rigid and rigid plate": marker_to_edge("rigid", "rigid"),
    "fixed edge, plate and plate": marker_to_edge("plate", "exact"),
    "restrained edge, ground and plate": marker_to_edge("ground", "exact", kind="restrained"),
    "restrained edge, rigid and plate": marker_to_edge("rigid", "exact", kind="restrained"),
    "restrained edge x-, plate and plate": marker_to_edge("plate", "exact", "x-", kind="restrained"),
    "restrained edge, rigid and rigid plate": marker_to_edge("rigid", "rigid", kind="restrained"),
    "sliding edge, ground and plate": marker_to_edge("ground", "exact", kind="sliding"),
    "sliding edge, rigid and plate": marker_to_edge("rigid", "exact", mesh=(3, 1), kind="sliding"),
    "sliding edge x-, rigid and plate": marker_to_edge("rigid", "exact", "x-", kind="sliding"),
    "sliding edge, plate and plate": marker_to_edge("plate", "exact", kind="sliding"),
    "sliding edge, rigid and rigid plate": marker_to_edge("rigid", "rigid", kind="sliding"),
    "mean of edge, ground and plate": mean_of_edge("ground", "exact", rotations="xy"),
    "mean of edge, rigid and plate": mean_of_edge("rigid", "exact", rotations="xy"),
    "mean of edge, plate and plate": mean_of_edge("plate", "exact", rotations="yx"),
    "mean of edge, rigid and rigid plate": mean_of_edge("rigid", "rigid", rotations="xy"),
    "mean position of edge, rigid and rigid plate": mean_of_edge("rigid", "rigid", "rx ry rz"),
    "some axes of mean of edge, rigid and plate": mean_of_edge("rigid", "exact", "tz rx rz", axes="yx", rotations="y"),
    # position and tangent at three nodes; the twist of a cubic edge is free
    "hinge": two_edges(hinge, 18, "rz"),
    "hinge, reversed": two_edges(hinge, 18, "rz", reverse=True),
    "hinge, 2 and 4 elements": two_edges(hinge, 30, "rz", mesh_b=(1, 4)),
    "hinge, 4 and 2 elements reversed": two_edges(hinge, 30, "rz", reverse=True, mesh_a=(1, 4)),
    "hinge, rigid": two_edges(hinge, 5, "rz", strain="rigid"),
    "hinge at points": two_edges(point_hinge, 6, "rz"),
    "hinge at points, reversed, 2 and 3 elements": two_edges(point_hinge, 6, "rz", reverse=True, mesh_b=(1, 3)),
    "hinge at points, rigid": two_edges(point_hinge, 5, "rz", strain="rigid"),
    "weld": two_edges(weld, 36, ""),
    "weld, rigid": two_edges(weld, 6, "", strain="rigid"),
}
