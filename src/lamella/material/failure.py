"""Equivalent stresses and failure criteria of a ply in plane stress, over arrays of points.

Stresses are (sigma_x, sigma_y, tau_xy) or, in the fibre axes, (sigma_1, sigma_2, tau_12), in the last axis of an array (..., 3).
A failure index reaches 1 at failure. A reserve factor is what all stresses may be multiplied with until failure; it is infinite
without stress.
"""

from __future__ import annotations

import numpy as np

from lamella.material.lamina import Lamina, strengths, stress_transformation
from lamella.roles import Floats


def fibre_stress(stress: Floats, angle: float) -> Floats:
    """Turn stresses from the element axes to the fibre axes.

    Args:
        stress: (sigma_x, sigma_y, tau_xy) [Pa], shape (..., 3).
        angle: from the element x axis to the fibres [deg].

    Returns:
        (sigma_1, sigma_2, tau_12) [Pa], shape (..., 3).
    """
    return stress @ stress_transformation(angle).T


def von_mises(stress: Floats) -> Floats:
    """Von Mises stress in plane stress, ``sqrt(s_x^2 - s_x s_y + s_y^2 + 3 t^2)``.

    Args:
        stress: in any orthonormal axes [Pa], shape (..., 3).

    Returns:
        Equivalent stress [Pa], shape (...).

    Source: von Mises (1913).
    """
    s_x, s_y, t = np.moveaxis(stress, -1, 0)
    return np.sqrt(s_x**2 - s_x * s_y + s_y**2 + 3.0 * t**2)


def principal_stresses(stress: Floats) -> Floats:
    """Principal stresses in the plane, ``(s_x + s_y)/2 +- sqrt(((s_x - s_y)/2)^2 + t^2)``.

    Args:
        stress: in any orthonormal axes [Pa], shape (..., 3).

    Returns:
        The larger and the smaller one [Pa], shape (..., 2).
    """
    s_x, s_y, t = np.moveaxis(stress, -1, 0)
    mean, radius = 0.5 * (s_x + s_y), np.hypot(0.5 * (s_x - s_y), t)
    return np.stack([mean + radius, mean - radius], axis=-1)


def tsai_hill(stress: Floats, lamina: Lamina) -> Floats:
    """Tsai-Hill index ``(s_1/X)^2 - s_1 s_2 / X^2 + (s_2/Y)^2 + (t_12/S)^2``, X and Y by the signs of s_1 and s_2.

    Args:
        stress: in the fibre axes [Pa], shape (..., 3).
        lamina: ply material with its strengths.

    Returns:
        Failure index [-], shape (...). It is quadratic in the stress: the reserve factor is its inverse root.

    Raises:
        DeclarationError: strengths are not given.

    Source: Hill (1950), Azzi and Tsai (1965); Jones (1999), section 2.9.
    """
    X_t, X_c, Y_t, Y_c, S = strengths(lamina)
    s_1, s_2, t = np.moveaxis(stress, -1, 0)
    X, Y = np.where(s_1 < 0.0, X_c, X_t), np.where(s_2 < 0.0, Y_c, Y_t)
    return (s_1 / X) ** 2 - s_1 * s_2 / X**2 + (s_2 / Y) ** 2 + (t / S) ** 2


def tsai_hill_reserve(stress: Floats, lamina: Lamina) -> Floats:
    """Reserve factor by Tsai-Hill, ``1 / sqrt(index)``.

    Args:
        stress: in the fibre axes [Pa], shape (..., 3).
        lamina: ply material with its strengths.

    Returns:
        Factor [-], shape (...). With X < Y the index can be zero or negative: failure is then out of reach, the factor infinite.
    """
    index = tsai_hill(stress, lamina)
    return np.where(index > 0.0, 1.0 / np.sqrt(np.where(index > 0.0, index, 1.0)), np.inf)


def tsai_wu(stress: Floats, lamina: Lamina, interaction: float = -0.5) -> Floats:
    """Tsai-Wu index ``F1 s_1 + F2 s_2 + F11 s_1^2 + F22 s_2^2 + F66 t_12^2 + 2 F12 s_1 s_2``.

    ``F1 = 1/Xt - 1/Xc``, ``F11 = 1/(Xt Xc)``, likewise F2 and F22 with Y; ``F66 = 1/S^2``; ``F12 = interaction sqrt(F11 F22)``.

    Args:
        stress: in the fibre axes [Pa], shape (..., 3).
        lamina: ply material with its strengths.
        interaction: normalised F12 in (-1, 1) [-]; -0.5 makes an isotropic material's index that of von Mises.

    Returns:
        Failure index [-], shape (...); it may be negative.

    Raises:
        DeclarationError: strengths are not given.

    Source: Tsai and Wu (1971), A general theory of strength for anisotropic materials.
    """
    linear, quadratic = _tsai_wu_terms(stress, lamina, interaction)
    return linear + quadratic


def tsai_wu_reserve(stress: Floats, lamina: Lamina, interaction: float = -0.5) -> Floats:
    """Reserve factor by Tsai-Wu: the positive root R of ``quadratic R^2 + linear R = 1``.

    Args:
        stress: in the fibre axes [Pa], shape (..., 3).
        lamina: ply material with its strengths.
        interaction: as in :func:`tsai_wu`.

    Returns:
        Factor [-], shape (...).

    Source: Tsai and Hahn, Introduction to Composite Materials (1980), chapter 7.
    """
    b, a = _tsai_wu_terms(stress, lamina, interaction)
    root = np.sqrt(b**2 + 4.0 * a)
    # two forms of the same root: each is free of cancellation for its sign of b
    denominator = np.where(b >= 0.0, b + root, 2.0 * a)
    numerator = np.where(b >= 0.0, 2.0, root - b)
    return np.where(denominator > 0.0, numerator / np.where(denominator > 0.0, denominator, 1.0), np.inf)


def _tsai_wu_terms(stress: Floats, lamina: Lamina, interaction: float) -> tuple[Floats, Floats]:
    X_t, X_c, Y_t, Y_c, S = strengths(lamina)
    s_1, s_2, t = np.moveaxis(stress, -1, 0)
    F11, F22 = 1.0 / (X_t * X_c), 1.0 / (Y_t * Y_c)
    F12 = interaction * np.sqrt(F11 * F22)
    linear = (1.0 / X_t - 1.0 / X_c) * s_1 + (1.0 / Y_t - 1.0 / Y_c) * s_2
    quadratic = F11 * s_1**2 + F22 * s_2**2 + (t / S) ** 2 + 2.0 * F12 * s_1 * s_2
    return linear, quadratic
