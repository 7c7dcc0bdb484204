"""Rotations: exponential and logarithm, conventions of quaternions and Euler angles, polar decomposition."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.linalg import expm

from lamella.errors import LamellaError
from lamella.math.rotation import (
    euler_from_matrix,
    euler_from_rotation,
    matrix_from_euler,
    matrix_from_quaternion,
    matrix_from_vector,
    polar,
    quaternion_from_matrix,
    quaternion_from_rotation,
    vector_from_matrix,
)

vectors = st.lists(st.floats(-1.7, 1.7), min_size=3, max_size=3).map(np.array)  # angles below pi, where the logarithm is unique


def cross(v: np.ndarray) -> np.ndarray:
    return np.array([[0, -v[2], v[1]], [v[2], 0, -v[0]], [-v[1], v[0], 0]])


@given(vectors)
def test_matrix_is_the_exponential(vector: np.ndarray) -> None:
    np.testing.assert_allclose(matrix_from_vector(vector), expm(cross(vector)), atol=1e-13)


@given(vectors)
def test_ways_back(vector: np.ndarray) -> None:
    R = matrix_from_vector(vector)
    np.testing.assert_allclose(vector_from_matrix(R), vector, atol=1e-7)  # close to pi the logarithm loses half the digits
    np.testing.assert_allclose(matrix_from_quaternion(quaternion_from_matrix(R)), R, atol=1e-13)
    if abs(R[2, 0]) < 0.999:  # away from a pitch of 90 degrees
        np.testing.assert_allclose(matrix_from_euler(euler_from_matrix(R)), R, atol=1e-12)


@given(vectors)
def test_what_is_recorded_is_what_scipy_finds(vector: np.ndarray) -> None:
    R = matrix_from_vector(vector)
    found, expected = quaternion_from_rotation(R), quaternion_from_matrix(R)
    np.testing.assert_allclose(found * np.sign(found @ expected), expected, atol=1e-13)  # after half a turn either sign will do
    if abs(R[2, 0]) < 0.999:
        difference = euler_from_rotation(R) - euler_from_matrix(R)
        difference -= 2.0 * np.pi * np.round(difference / (2.0 * np.pi))  # half a turn to either side is the same
        np.testing.assert_allclose(difference, 0.0, atol=1e-12)


@pytest.mark.parametrize("axis", [(1, 0, 0), (0, -1, 0), (0, 0, 1), (0.6, 0.0, -0.8), (0.36, 0.48, 0.8)])
def test_quaternion_of_a_half_turn(axis: tuple[float, float, float]) -> None:
    R = matrix_from_vector(np.pi * np.array(axis))
    found = quaternion_from_rotation(R)
    assert found[0] >= 0.0
    np.testing.assert_allclose(np.abs(found), np.abs([0.0, *axis]), atol=1e-15)
    np.testing.assert_allclose(matrix_from_quaternion(found), R, atol=1e-15)


def test_conventions() -> None:
    quarter = matrix_from_vector(np.array([0, 0, np.pi / 2]))
    np.testing.assert_allclose(quarter @ [1, 0, 0], [0, 1, 0], atol=1e-15)
    np.testing.assert_allclose(quaternion_from_matrix(quarter), [np.sqrt(0.5), 0, 0, np.sqrt(0.5)], atol=1e-15)
    np.testing.assert_allclose(euler_from_matrix(quarter), [np.pi / 2, 0, 0], atol=1e-15)
    yaw, pitch = matrix_from_vector(np.array([0, 0, 0.3])), matrix_from_vector(np.array([0, 0.2, 0]))
    np.testing.assert_allclose(matrix_from_euler(np.array([0.3, 0.2, 0.0])), yaw @ pitch, atol=1e-15)
    np.testing.assert_allclose(matrix_from_euler(np.array([0.0, 0.2, 0.3]), "xyz"), yaw @ pitch, atol=1e-15)


def test_stacks_keep_their_shape() -> None:
    many = np.linspace(-1, 1, 12).reshape(4, 3)
    R = matrix_from_vector(many)
    assert R.shape == (4, 3, 3)
    assert quaternion_from_matrix(R).shape == (4, 4)
    np.testing.assert_allclose(vector_from_matrix(R), many, atol=1e-14)


@given(vectors, st.lists(st.floats(0.2, 5.0), min_size=3, max_size=3), vectors)
def test_polar_finds_rotation_and_stretch(turn: np.ndarray, stretches: list[float], axes: np.ndarray) -> None:
    R, N = matrix_from_vector(turn), matrix_from_vector(axes)
    U = N @ np.diag(stretches) @ N.T
    found_R, found_U = polar(R @ U)
    np.testing.assert_allclose(found_R, R, atol=1e-12)
    np.testing.assert_allclose(found_U, U, atol=1e-12)


@given(vectors, st.floats(0.5, 2.0), st.floats(0.5, 2.0), st.floats(-0.3, 0.3))
def test_polar_of_a_surface_completes_the_frame_with_the_normal(turn: np.ndarray, a: float, b: float, shear: float) -> None:
    R, U = matrix_from_vector(turn), np.array([[a, shear], [shear, b]])
    F = R[:, :2] @ U
    found_R, found_U = polar(F)
    np.testing.assert_allclose(found_R, R, atol=1e-12)
    np.testing.assert_allclose(found_U, U, atol=1e-12)
    normal = np.cross(F[:, 0], F[:, 1])
    np.testing.assert_allclose(found_R[:, 2], normal / np.linalg.norm(normal), atol=1e-12)


def test_polar_of_many_surfaces() -> None:
    F = np.random.default_rng(1).normal(size=(5, 2, 3, 2))
    R, U = polar(F)
    assert R.shape == (5, 2, 3, 3)
    np.testing.assert_allclose(R[..., :2] @ U, F, atol=1e-13)
    np.testing.assert_allclose(np.linalg.det(R), 1.0, atol=1e-13)


@pytest.mark.parametrize("F", [np.diag([1.0, 1.0, -1.0]), np.zeros((3, 3)), np.array([[1.0, 2.0], [1.0, 2.0], [0, 0]])])
def test_polar_refuses_gradients_without_nearest_rotation(F: np.ndarray) -> None:
    with pytest.raises(LamellaError, match="singular or a reflection; accepted are independent, right-handed columns"):
        polar(F)
