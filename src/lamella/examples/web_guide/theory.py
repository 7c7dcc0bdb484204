"""The linear model: a belt that enters each roller at right angles to its axle, and a roller that is turned about the strands.

The upper strand runs from roller 1 to roller 2, the lower one back. z1 and z2 are where the belt meets the rollers, z1e and z2e
where it leaves them. An ideal web is straight between the rollers, and meets them at right angles to the axle: what it is off,
times the speed, is how fast it moves sideways (Shelton and Reid, Lateral dynamics of an idealized moving web, J. Dyn. Sys.,
Meas., Control 93 (1971) 187-192),

    T zeta2' = z1e - z2,        T z1' = z2e - z1 + T v kappa psi,        T = span / v

psi turns roller 1 about the vertical; an ideal web follows all of it, kappa = 1. A belt leaves at right angles to the axle as
well, and is a beam in its plane: in the middle of the strand it is off by -span psi / 8. phi turns roller 2 about the strands:
what lies on it goes along, by r phi above and by -r phi below. In the roller, where it sticks, the belt keeps its place zeta:

    z2 = zeta2 + r phi,      z2e(t) = zeta2(t - w) - r phi(t),      z1e(t) = z1(t - w),      w = pi r / v

In each turn, of the length l, the belt so goes sideways by -2 r phi, at the rate -2 r phi v / l.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import factorial
from typing import Any

import numpy as np
from scipy import linalg, signal
from scipy.optimize import brentq, least_squares

from lamella.linear.state_space import StateSpace
from lamella.load.control_law import PID
from lamella.roles import Floats

PADE = 3
"""Order of the rational functions that stand for the delays; their phase errs by less than 0.01 rad up to 2.4 / w."""


@dataclass(frozen=True)
class Web:
    """An ideal web, with factors on what the theory says.

    Args:
        radius: r, of the belt's middle on the rollers [m].
        span: length of a strand [m].
        speed: v [m/s].
        servo: time constant of the steering [s].
        lag: factor on T.
        lever: factor on r where phi turns the roller.
        share: kappa.
    """

    radius: float
    span: float
    speed: float
    servo: float
    lag: float = 1.0
    lever: float = 1.0
    share: float = 1.0

    @property
    def length(self) -> float:
        """Of the belt [m]."""
        return 2.0 * (self.span + np.pi * self.radius)

    @property
    def rate(self) -> float:
        """Sideways speed for each rad of steering, in the long run [m/s]."""
        return -2.0 * self.lever * self.radius * self.speed / (2.0 * (self.lag * self.span + np.pi * self.radius))

    def state_space(self) -> StateSpace:
        """From the commanded angle and the misalignment to the edge in the middle of the upper strand."""
        T, r, v = self.lag * self.span / self.speed, self.lever * self.radius, self.speed
        a, b, c, d = delay(np.pi * self.radius / v)
        n = len(a)
        size = 3 + 2 * n  # zeta2, z1, phi, then the delays of z1 and of zeta2
        zeta2, z1, phi = np.eye(size)[:3]
        first, second = np.eye(size)[3 : 3 + n], np.eye(size)[3 + n :]
        z1e, z2e = c @ first + d * z1, c @ second + d * zeta2 - r * phi
        z2 = zeta2 + r * phi
        A = np.zeros((size, size))
        A[0], A[1], A[2] = (z1e - z2) / T, (z2e - z1) / T, -phi / self.servo
        A[3 : 3 + n] = a @ first + np.outer(b, z1)
        A[3 + n :] = a @ second + np.outer(b, zeta2)
        B = np.zeros((size, 2))
        B[2, 0], B[1, 1] = 1.0 / self.servo, v * self.share
        D = np.array([[0.0, -self.span / 8.0]])
        names = ("command", "misalignment"), ("eye",), ("rad", "rad"), ("m",)
        return StateSpace(A, B, 0.5 * (z1e + z2)[None], D, *names, np.zeros(2), np.zeros(1))


def delay(time: float) -> tuple[Floats, Floats, Floats, float]:
    """A, B, C, D of Padé's approximation of exp(-s time)."""
    n = PADE
    powers = [factorial(2 * n - k) / (factorial(k) * factorial(n - k)) * time**k for k in range(n, -1, -1)]
    signs = [(-1.0) ** k for k in range(n, -1, -1)]
    A, B, C, D = signal.tf2ss(np.multiply(powers, signs), powers)
    return A, B[:, 0], C[0], float(D[0, 0])


def fitted(web: Web, t: Floats, command: Floats, moved: Floats) -> Web:
    """The web whose factors on lag and lever make the smallest squares of what is left of a response.

    Args:
        web: the ideal one.
        t: equally spaced times [s].
        command: commanded angle [rad].
        moved: change of the edge [m].
    """

    def left(factors: Floats) -> Floats:
        return answer(replace(web, lag=factors[0], lever=factors[1]), t, command, 0.0 * t) - moved

    lag, lever = least_squares(left, [1.0, 1.0], x_scale=0.1, diff_step=1e-4).x
    return replace(web, lag=float(lag), lever=float(lever))


def with_share(web: Web, t: Floats, misalignment: Floats, moved: Floats) -> Web:
    """The web with the share of the misalignment that fits a response; it is linear in it."""
    none, whole = (answer(replace(web, share=share), t, 0.0 * t, misalignment) for share in (0.0, 1.0))
    unit = whole - none
    return replace(web, share=float(unit @ (moved - none) / (unit @ unit)))


def answer(web: Web, t: Floats, command: Floats, misalignment: Floats) -> Floats:
    """Change of the edge [m] at equally spaced times."""
    return web.state_space().response(t, np.stack([command, misalignment], axis=1))[:, 0]


@dataclass(frozen=True)
class Design:
    """A PI controller and what it promises.

    Args:
        proportional: [rad/m].
        integral: [rad/m/s].
        crossover: [rad/s].
        margin: phase margin [rad].
    """

    proportional: float
    integral: float
    crossover: float
    margin: float


def open_loop(model: StateSpace, omega: float, period: float) -> complex:
    """Response from command to edge, with half a period for the hold."""
    plant = model.frequency_response(np.array([omega / (2.0 * np.pi)]))[0, 0, 0]
    return complex(plant * np.exp(-0.5j * omega * period))


def designed(model: StateSpace, period: float, margin: float, corner: float) -> Design:
    """PI for a phase margin: u = k (e + omega_i int e dt) with omega_i = omega_c / corner.

    The plant integrates with a negative sign, so k is negative.

    Args:
        model: the plant.
        period: of sampling [s].
        margin: phase margin [rad].
        corner: crossover over the frequency at which the integral takes over.
    """

    def excess(omega: float) -> float:
        loop = -open_loop(model, omega, period) * (1.0 + 1.0 / (1j * corner))
        return float(np.mod(np.angle(loop), 2.0 * np.pi) - np.pi - margin)  # the phase counts from -2 pi to 0

    grid = np.geomspace(0.05, 30.0, 200)
    first = next(k for k, omega in enumerate(grid) if excess(omega) < 0.0)
    root: Any = brentq(excess, grid[first - 1], grid[first])
    crossover = float(root)
    k = -1.0 / abs(open_loop(model, crossover, period) * (1.0 + 1.0 / (1j * corner)))
    return Design(k, k * crossover / corner, crossover, margin)


def closed_loop(web: Web, law: PID, period: float, t: Floats, misalignment: Floats, start: float) -> tuple[Floats, Floats]:
    """Edge [m] and command [rad] of the linear model under the sampled law, at times of which every second is a sample time.

    Args:
        web: the plant.
        law: the law itself, with its limit.
        period: of sampling [s], twice the step of ``t``.
        t: times [s].
        misalignment: of roller 1 at these [rad].
        start: place of the edge at rest [m].
    """
    model = web.state_space()
    n, dt = model.n_states, float(t[1] - t[0])
    whole = np.zeros((n + 2, n + 2))
    whole[:n, :n], whole[:n, n:] = dt * model.A, dt * model.B
    moved = linalg.expm(whole)[:n]  # with inputs that are held over a step
    x, memory, u = np.zeros(n), law.initial, np.zeros(1)
    edge, command = np.empty(len(t)), np.empty(len(t))
    for k, now in enumerate(t):
        edge[k] = start + float(model.C[0] @ x + model.D[0, 1] * misalignment[k])  # the command passes through the servo
        if k % 2 == 0:
            u, memory = law.sample(float(now), edge[k : k + 1], memory, period)
        command[k] = u[0]
        between = 0.5 * (misalignment[k] + misalignment[min(k + 1, len(t) - 1)])
        x = moved @ np.concatenate([x, u, [between]])
    return edge, command
