"""The controllers: feedback of the measured attitude, and torques ahead from what each knows of the panel."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.polynomial import Polynomial

from lamella.linear.state_space import StateSpace
from lamella.roles import Floats

INCIDENCE = np.radians(65.0)
SUNRISE = (10.0, 20.0)
SLEW, TURN = (40.0, 80.0), 0.5 * np.pi
HUB = 200.0
RHO, C, ALPHA, H, FLUX = 36.8, 921.0, 2.3e-5, 0.0103, 0.79 * 1350.0
PERIOD = 0.2
"""Time between two samples of the controller [s]."""
OMEGA, ZETA = 0.1, 0.7
"""Bandwidth [rad/s] and damping ratio of the feedback, for a satellite that were rigid."""
GRID = 0.01
"""Interval at which what is foretold is computed [s]."""
SHAPE = Polynomial([0, 0, 0, 0, 35, -84, 70, -20])
"""From 0 to 1 with three derivatives that vanish at both ends."""


def reference(t: Floats | float, order: int = 0) -> Floats:
    """Attitude that is wanted [rad], or its derivatives by time."""
    length = SLEW[1] - SLEW[0]
    inside = np.clip((np.asarray(t, float) - SLEW[0]) / length, 0.0, 1.0)
    curve = SHAPE if order == 0 else SHAPE.deriv(order)
    return np.asarray(TURN * curve(inside) / length**order)


def light(t: Floats) -> Floats:
    """Share of the sunlight, the profile of the model file: a quintic."""
    tau = np.clip((t - SUNRISE[0]) / (SUNRISE[1] - SUNRISE[0]), 0.0, 1.0)
    return tau**3 * (10.0 + tau * (-15.0 + 6.0 * tau))


@dataclass(frozen=True)
class Knowledge:
    """What the linear model says of the satellite as seen from the wheel, from its answers to slow torques and slow light.

    theta = (1 + b w^2) / (-J w^2) u from the wheel and theta = -(s / J) e^(-i w tau) d from the light, with its factor d.

    Args:
        inertia: J [kg m^2].
        bend: b: how much more inertia a quick torque feels, because the panel stays behind [s^2].
        thermal: s: angular momentum, for a rate of d of 1/s, that the bending of the panel takes [N m s^2].
        lag: tau, time that the panel takes to bend [s].
    """

    inertia: float
    bend: float
    thermal: float
    lag: float


def known(plant: StateSpace) -> Knowledge:
    """The coefficients, from two low frequencies."""
    slow, faster = 2e-3, 1e-2  # [Hz]; the panel vibrates at 0.2 Hz
    G = plant.frequency_response(np.array([slow, faster]))[:, 0, :]
    w2 = (2.0 * np.pi * np.array([slow, faster])) ** 2
    felt = -(1.0 / (w2 * G[:, 0])).real
    bend = (felt[1] / felt[0] - 1.0) / (w2[1] - w2[0])
    inertia = felt[0] / (1.0 + bend * w2[0])
    lag = -np.angle(-G[0, 1]) / np.sqrt(w2[0])
    return Knowledge(inertia, bend, -inertia * G[0, 1].real, lag)


class Law:
    """u_k = k_p e + k_d e' + (H(t_k + T) - H(t_k)) / T with the angular momentum H that the satellite will have.

    Args:
        knowledge: of the satellite.
        t_end: time until which H is needed [s].
        thermal: whether H knows that heat bends the panel and makes it longer.
    """

    def __init__(self, knowledge: Knowledge, t_end: float, *, thermal: bool) -> None:
        self.k_p = knowledge.inertia * OMEGA**2
        self.k_d = 2.0 * ZETA * knowledge.inertia * OMEGA
        self._t = np.arange(-1.0, t_end + 2.0 * PERIOD, GRID)
        J = np.full_like(self._t, knowledge.inertia)
        bent = np.zeros_like(self._t)
        if thermal:
            view = np.cos(reference(self._t) - INCIDENCE)
            mean = np.cumsum(FLUX * light(self._t) * np.abs(view)) * GRID / (RHO * C * H)  # T_N [K]
            J += (knowledge.inertia - HUB) * ((1.0 + ALPHA * mean) ** 2 - 1.0)
            d = light(self._t) * view / np.cos(INCIDENCE)
            late = np.interp(self._t - knowledge.lag, self._t, d)
            bent = knowledge.thermal * np.gradient(late, GRID)
        self._H = J * reference(self._t, 1) - knowledge.inertia * knowledge.bend * reference(self._t, 3) + bent

    def ahead(self, t: float) -> float:
        """Torque that changes the angular momentum as foretold, the mean over the next period [N m]."""
        now, then = np.interp([t, t + PERIOD], self._t, self._H)
        return float(then - now) / PERIOD

    def __call__(self, t: float, y: Floats) -> float:
        """Torque of the wheel [N m] for the measured attitude [rad] and its rate [rad/s]."""
        error, slow = float(reference(t)) - y[0], float(reference(t, 1)) - y[1]
        return self.k_p * error + self.k_d * slow + self.ahead(t)
