"""Rotations in space: rotation vectors, matrices, quaternions and Euler angles, and the rotation within a deformation gradient.

A matrix R turns vectors: ``v' = R v``. Its columns are the turned axes. All functions take stacks: leading axes (...) are kept.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from lamella.errors import LamellaError
from lamella.roles import Floats

if TYPE_CHECKING:
    from scipy.spatial.transform import Rotation


def matrix_from_vector(vector: Floats) -> Floats:
    """Rotation matrix of a rotation vector, ``R = exp(vector x)``.

    Args:
        vector: axis times angle [rad], shape (..., 3).

    Returns:
        R [-], shape (..., 3, 3).
    """
    given = np.asarray(vector, float)
    if not given.any():  # most bodies are not turned, and need not wait for SciPy's rotations
        return np.broadcast_to(np.eye(3), (*given.shape[:-1], 3, 3)).copy()
    return _transform().from_rotvec(given).as_matrix()


def vector_from_matrix(R: Floats) -> Floats:
    """Rotation vector of a rotation matrix, the inverse of :func:`matrix_from_vector`.

    Args:
        R: rotation matrix [-], shape (..., 3, 3).

    Returns:
        Axis times angle with an angle of at most pi [rad], shape (..., 3).
    """
    return _transform().from_matrix(np.asarray(R, float)).as_rotvec()


def matrix_from_quaternion(quaternion: Floats) -> Floats:
    """Rotation matrix of a quaternion.

    Args:
        quaternion: (w, x, y, z), real part first; its norm does not matter [-], shape (..., 4).

    Returns:
        R [-], shape (..., 3, 3).
    """
    return _transform().from_quat(np.asarray(quaternion, float), scalar_first=True).as_matrix()


def quaternion_from_matrix(R: Floats) -> Floats:
    """Unit quaternion of a rotation matrix.

    Args:
        R: rotation matrix [-], shape (..., 3, 3).

    Returns:
        (w, x, y, z) with w >= 0 [-], shape (..., 4).
    """
    return _transform().from_matrix(np.asarray(R, float)).as_quat(canonical=True, scalar_first=True)


def matrix_from_euler(angles: Floats, axes: str = "ZYX") -> Floats:
    """Rotation matrix of Euler angles.

    Args:
        angles: in the order of the axes [rad], shape (..., 3).
        axes: three letters; capitals turn about the turned axes (``ZYX`` = yaw, pitch, roll), small letters about the fixed ones.

    Returns:
        R [-], shape (..., 3, 3).
    """
    return _transform().from_euler(axes, np.asarray(angles, float)).as_matrix()


def euler_from_matrix(R: Floats, axes: str = "ZYX") -> Floats:
    """Euler angles of a rotation matrix, the inverse of :func:`matrix_from_euler`.

    Args:
        R: rotation matrix [-], shape (..., 3, 3).
        axes: as for :func:`matrix_from_euler`.

    Returns:
        Angles [rad], shape (..., 3). Where the first and third axis coincide, SciPy warns and sets the third angle to zero.
    """
    return _transform().from_matrix(np.asarray(R, float)).as_euler(axes)


def quaternion_from_rotation(R: Floats) -> Floats:
    """Unit quaternion of one rotation matrix, without SciPy's set-up: for what is recorded at every step.

    Args:
        R: rotation matrix [-], shape (3, 3).

    Returns:
        (w, x, y, z) with w >= 0 [-], shape (4,).

    Source: Shepperd (1978), Quaternion from rotation matrix.
    """
    (xx, xy, xz), (yx, yy, yz), (zx, zy, zz) = R.tolist()
    # 4 q q^T; its row with the largest diagonal entry is the best conditioned
    Q = (
        (1 + xx + yy + zz, zy - yz, xz - zx, yx - xy),
        (zy - yz, 1 + xx - yy - zz, xy + yx, xz + zx),
        (xz - zx, xy + yx, 1 - xx + yy - zz, yz + zy),
        (yx - xy, xz + zx, yz + zy, 1 - xx - yy + zz),
    )
    row = Q[max(range(4), key=lambda k: Q[k][k])]
    return np.array(row) / (math.hypot(*row) * (1.0 if row[0] >= 0 else -1.0))


def euler_from_rotation(R: Floats) -> Floats:
    """Yaw, pitch and roll of one rotation matrix: R = R_z(yaw) R_y(pitch) R_x(roll), about the turned axes z, y, x.

    Args:
        R: rotation matrix [-], shape (3, 3).

    Returns:
        Angles [rad], shape (3,), with the pitch within +-pi/2. At a pitch of +-pi/2 yaw and roll turn about one axis; the roll
        is then zero.
    """
    (xx, xy, _), (yx, yy, _), (zx, zy, zz) = R.tolist()
    sine = min(max(-zx, -1.0), 1.0)
    if abs(sine) > 1.0 - 1e-12:
        return np.array([math.atan2(-xy, yy), math.copysign(math.pi / 2, sine), 0.0])
    return np.array([math.atan2(yx, xx), math.asin(sine), math.atan2(zy, zz)])


def polar(F: Floats) -> tuple[Floats, Floats]:
    """Rotation and stretch of a deformation gradient, ``F = R U``.

    R is the rotation nearest to F. For a surface, F = [r_x, r_y] and the third column of R is the normal r_x x r_y / abs(...).

    Args:
        F: gradient [-], shape (..., 3, 3), or (..., 3, 2) for a surface.

    Returns:
        R, shape (..., 3, 3), and the symmetric stretch U, shape (..., 3, 3) or (..., 2, 2): ``F = R[..., :k] U`` for k columns.

    Raises:
        LamellaError: F is singular or, with three columns, a reflection: no rotation is nearest.

    Source: Higham (1986), Computing the polar decomposition.
    """
    F = np.asarray(F, float)
    W, sigma, Vt = np.linalg.svd(F, full_matrices=False)
    k = F.shape[-1]
    reflected = k == 3 and np.any(np.linalg.det(F) < 0.0)
    if reflected or np.any(
        sigma[..., -1] <= 1e-12 * sigma[..., 0]
    ):  # 1e-12: what the singular values are accurate to, with reserve
        raise LamellaError(
            "polar decomposition: the gradient is singular or a reflection; accepted are independent, right-handed columns"
        )
    R = W @ Vt
    U = np.swapaxes(Vt, -1, -2) @ (sigma[..., None] * Vt)
    if k == 2:
        R = np.concatenate([R, np.cross(R[..., 0], R[..., 1])[..., None]], axis=-1)
    return R, U


def _transform() -> type[Rotation]:
    from scipy.spatial.transform import Rotation  # imported late: 0.7 s that help and checks of a model file need not wait for

    return Rotation
