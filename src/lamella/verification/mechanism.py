"""Mechanisms of rigid links in the x-z plane, and the equations of motion in minimal coordinates they are compared with."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

import lamella as lm

if TYPE_CHECKING:
    from lamella.body.base import Marker
    from lamella.roles import Floats

G = 9.81
"""Acceleration of gravity along -z [m/s^2]."""


def link(name: str, start: tuple[float, float], end: tuple[float, float], mass: float) -> tuple[lm.RigidBody, Marker, Marker]:
    """An even slender link between two points (x, z) [m], its x axis along it, and markers at both ends; J = mass length^2/12."""
    (x, z), (dx, dz) = start, np.subtract(end, start)
    length = float(np.hypot(dx, dz))
    J = mass * length**2 / 12
    given = {"position": (x + 0.5 * dx, 0.0, z + 0.5 * dz), "rotation": (0.0, -float(np.arctan2(dz, dx)), 0.0)}
    body = lm.RigidBody(name, mass=mass, inertia=(1e-2 * J, J, J), **given)
    return body, body.marker(f"{name} start", -0.5 * length, 0, 0), body.marker(f"{name} end", 0.5 * length, 0, 0)


def solved(rates: Callable[[float, Floats], Floats], start: Sequence[float] | Floats, times: Floats) -> Floats:
    """Solution of y' = rates(t, y) at given times by an explicit method of order 8 with errors of some 1e-11, shape (n, n_times).

    Source: Hairer, Norsett and Wanner (1993), DOP853.
    """
    from scipy.integrate import solve_ivp

    span = (float(times[0]), float(times[-1]))
    return solve_ivp(rates, span, start, method="DOP853", t_eval=times, rtol=1e-11, atol=1e-12).y


def one_degree_of_freedom(
    inertia: Callable[[Any], Any], along: Callable[[Any], Any], force: Callable[[Floats], float]
) -> Callable[[float, Floats], Floats]:
    """Rates of (angles, speed) of a mechanism whose angles all follow the first one: angles' = along(angles) speed,

        M speed' + 1/2 (dM / dangle_1) speed^2 = force

    Args:
        inertia: M(angles) with kinetic energy 1/2 M speed^2 [kg m^2]; it takes complex angles, so that dM is exact.
        along: derivatives of the angles by the first one; it takes complex angles.
        force: generalised force on the first angle [N m].
    """

    def rates(t: float, y: Floats) -> Floats:
        angles, speed = y[:-1], y[-1]
        direction = along(angles)
        slope = float(np.imag(inertia(angles + 1e-30j * direction))) / 1e-30
        return np.append(direction * speed, (force(angles) - 0.5 * slope * speed**2) / inertia(angles))

    return rates
