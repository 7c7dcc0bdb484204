"""Loads per reference length and area on a curved plate whose parameters are no lengths, against its true length and area."""

from __future__ import annotations

import numpy as np
import pytest
from curved_plate import RADIUS, SIZE, STRETCH, R, bent_plate

import lamella as lm

ANGLE = SIZE[0] / RADIUS
LENGTHS = {"x-": STRETCH * SIZE[1], "x+": STRETCH * SIZE[1], "y-": SIZE[0], "y+": SIZE[0]}
VECTOR = np.array((3.0, -2.0, 5.0))
# an arc of 0.28 rad as a cubic curve that has its ends and end slopes is short by 0.28^4 / 720 of its length (Taylor)
ARC = (ANGLE / 6) ** 4 / 720


def resultants(make):
    """Force, and torque about the inertial origin, of a load in the reference configuration."""
    system = lm.System()
    plate = bent_plate(system)
    system.add(make(plate))
    model = system.compile()
    (block,) = model.loads
    f = np.full(len(block.f_coords), np.nan)
    block.force(0.0, model.q0, np.zeros_like(model.q0), f)
    Q = -np.bincount(block.f_coords, f * block.f_scale, minlength=model.n_q).reshape(-1, 3)
    return Q[model.is_position].sum(axis=0), np.cross(model.q0.reshape(-1, 3), Q).sum(axis=0)


@pytest.mark.parametrize("side", LENGTHS)
def test_edge_force_is_force_per_true_length(side):
    force, _ = resultants(lambda plate: lm.EdgeForce("load", plate.edge(side), tuple(VECTOR)))
    np.testing.assert_allclose(force, LENGTHS[side] * VECTOR, rtol=2 * ARC)


def test_surface_force_is_force_per_true_area():
    force, _ = resultants(lambda plate: lm.SurfaceForce("load", plate, tuple(VECTOR)))
    np.testing.assert_allclose(force, SIZE[0] * STRETCH * SIZE[1] * VECTOR, rtol=2 * ARC)


@pytest.mark.parametrize("side", LENGTHS)
def test_edge_moment_is_moment_per_true_length(side):
    force, torque = resultants(lambda plate: lm.EdgeMoment("load", plate.edge(side), tuple(VECTOR)))
    np.testing.assert_allclose(force, 0.0, atol=1e-12)
    np.testing.assert_allclose(torque, LENGTHS[side] * VECTOR, rtol=2 * ARC)


def test_bending_moments_of_a_curved_edge_sum_to_moment_times_chord():
    """int m t ds = m (r_end - r_start), whatever the parameter; the direction of the tangent is off by ARC's order."""
    _, torque = resultants(lambda plate: lm.EdgeMoment("load", plate.edge("y+"), bending=4.0))
    chord = RADIUS * R @ np.array((np.cos(ANGLE) - 1, 0.0, np.sin(ANGLE)))
    np.testing.assert_allclose(torque, 4.0 * chord, rtol=0, atol=2 * ARC * 4.0 * SIZE[0])


def test_bending_moments_of_a_stretched_edge():
    _, torque = resultants(lambda plate: lm.EdgeMoment("load", plate.edge("x+"), bending=4.0))
    np.testing.assert_allclose(torque, 4.0 * STRETCH * SIZE[1] * R[:, 1], rtol=1e-12)


@pytest.mark.parametrize("side", ["x+", "y+"])
def test_following_moments_turn_with_the_surface(side):
    """In the axes t1, t2, n0 of a cylinder: a moment about t2, its generator, is everywhere parallel to the axis."""
    _, torque = resultants(lambda plate: lm.EdgeMoment("load", plate.edge(side), (0.0, 2.5, 0.0), follower=True))
    np.testing.assert_allclose(torque, 2.5 * LENGTHS[side] * R[:, 1], rtol=2 * ARC, atol=1e-12)
