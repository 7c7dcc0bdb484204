"""The first bending mode of a panel in the sun, in closed form: response to sudden light, and stability."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.interpolate import CubicHermiteSpline
from scipy.optimize import root_scalar

import lamella as lm
from lamella.body.mesh import PlateMesh
from lamella.body.plate import Plate
from lamella.errors import DeclarationError
from lamella.roles import Floats
from lamella.system import System
from lamella.thermal.prescribed import PrescribedTemperature
from lamella.thermal.solar import SolarFlux

BEAM_ROOTS = np.array([1.875104069, 4.694091133, 7.854757438, 10.99554073])
"""beta L of a clamped-free beam, cos(beta L) cosh(beta L) = -1."""
POINTS = 2001
"""Points of the trapezoidal rule along an edge or a beam; integrals are good to six digits."""


@dataclass(frozen=True)
class FirstMode:
    """Deflection y of the tip in the first bending mode, and u, the deflection that the temperature asks for:

        y'' + 2 zeta omega y' + omega^2 (y + u) = 0,    tau u' + u = push + gain y

    A panel that is much longer than thick conducts heat through its thickness alone, tau dT_M/dt + T_M = g Gamma, with
    tau = rho c h^2 / (12 k), g = alpha_s S / (2 k) and Gamma = -s.n0 = Gamma_0 + s_x w_x of light that travels along s.
    T_M does work on the curvature of the mode phi (int rho h phi^2 dA = 1), m_T int T_M lap phi dA with m_T = D (1 + nu) alpha.
    The one-pole law holds for that integral as it does at each point, so that no shape of T_M has to be assumed, and

        push = g m_T Gamma_0 phi(tip) I_1 / omega^2,    I_1 = int lap phi dA,
        gain = g m_T s_x I_x / omega^2,                 I_x = int phi_x lap phi dA

    For a beam push = 0.891 rest, and gain = alpha g s_x phi'(L)^2 / (2 int phi''^2 dx) = 0.3065 alpha g L s_x.

    Args:
        omega: natural angular frequency [1/s].
        tau: time constant of T_M [s].
        push: deflection of the tip by steady heat of the undeformed panel, downwards [m].
        gain: part of a deflection that the heat due to it takes back when steady [-]; 0 when heat does not follow the shape.
        rest: ``push`` of all modes, for a beam alpha g Gamma_0 L^2 / 2 [m].
    """

    omega: float
    tau: float
    push: float
    gain: float
    rest: float

    @property
    def uncoupled(self) -> FirstMode:
        """The mode heated as if it kept its reference shape."""
        return replace(self, gain=0.0)

    @property
    def mirrored(self) -> FirstMode:
        """The mode in light that comes from the other end."""
        return replace(self, gain=-self.gain)

    @property
    def delay(self) -> float:
        """omega tau, time constant of heat over that of the vibration."""
        return self.omega * self.tau

    def polynomial(self, zeta: float) -> Floats:
        """Coefficients of (s^2 + 2 zeta omega s + omega^2) (tau s + 1) + omega^2 gain, highest power first."""
        w, tau = self.omega, self.tau
        return np.array([tau, 1 + 2 * zeta * w * tau, 2 * zeta * w + w**2 * tau, w**2 * (1 + self.gain)])

    def pole(self, zeta: float) -> complex:
        """The root that swings: rate of growth + i angular frequency [1/s]."""
        roots = np.roots(self.polynomial(zeta))
        return complex(roots[np.argmax(roots.imag)])

    def amplitude(self, zeta: float) -> float:
        """Amplitude of the vibration that sudden light leaves, at the time of the light [m].

        By the residue at the pole; push / sqrt(1 + (omega tau)^2) for zeta = gain = 0 (Boley 1956).
        """
        s = self.pole(zeta)
        return float(2 * abs(self.omega**2 * self.push / (s * np.polyval(np.polyder(self.polynomial(zeta)), s))))

    def response(self, zeta: float, t: Floats) -> Floats:
        """Tip at times t [s] after sudden light, upwards [m]: this mode, and the others as if they had no inertia."""
        polynomial = self.polynomial(zeta)
        roots = np.roots(polynomial)
        shares = -(self.omega**2) * self.push / (roots * np.polyval(np.polyder(polynomial), roots))
        t = np.maximum(t, 0.0)
        first = -self.push / (1 + self.gain) + np.real(np.exp(np.outer(t, roots)) @ shares)
        return first + (self.rest - self.push) * np.expm1(-t / self.tau)

    def critical_damping(self) -> float:
        """Damping ratio at which vibration neither grows nor decays.

        Of a s^3 + b s^2 + c s + d all roots are stable exactly if all coefficients are positive and b c > a d (Routh, Hurwitz):
        2 zeta (1 + p^2 + 2 zeta p) > p gain with p = omega tau, about zeta > gain p / (2 (1 + p^2)).
        """
        p = self.delay
        return float(np.roots([4 * p, 2 * (1 + p**2), -p * self.gain]).max()) if p else 0.0

    def pole_of_four(self, zeta: float) -> complex:
        """The root of the first mode when the next three of a beam are heated and bend with it.

        With the modes of a clamped-free beam, tau u_i' + u_i = sum_j gain_ij y_j and gain_ij ~ int phi_i'' phi_j' dx / int
        phi_i''^2 dx; Kelvin-Voigt damping damps mode i by zeta omega_i / omega.
        """
        ratio, coupling = beam_modes()
        n, w = len(ratio), self.omega * ratio
        matrix = np.zeros((3 * n, 3 * n))
        y, v, u = (slice(k * n, (k + 1) * n) for k in range(3))
        matrix[y, v] = np.eye(n)
        matrix[v, y] = matrix[v, u] = -np.diag(w**2)
        matrix[v, v] = -np.diag(2 * zeta * ratio * w)
        matrix[u, y], matrix[u, u] = self.gain * coupling / self.tau, -np.eye(n) / self.tau
        roots = np.linalg.eigvals(matrix)
        return complex(roots[np.argmin(np.abs(roots - self.pole(zeta)))])

    def critical_damping_of_four(self) -> float:
        """As :meth:`critical_damping`, by the root of four modes, for light that drives (gain > 0)."""
        return root_scalar(lambda zeta: self.pole_of_four(zeta).real, bracket=(0.0, 2 * self.critical_damping())).root


def beam_modes() -> tuple[Floats, Floats]:
    """Frequencies over the first one, and gain_ij over gain_11, of the first four modes of a clamped-free beam."""
    x, b = np.linspace(0.0, 1.0, POINTS), BEAM_ROOTS[:, None]
    s = (np.cosh(b) + np.cos(b)) / (np.sinh(b) + np.sin(b))
    slope = b * (np.sinh(b * x) + np.sin(b * x) - s * (np.cosh(b * x) - np.cos(b * x)))
    curvature = b**2 * (np.cosh(b * x) + np.cos(b * x) - s * (np.sinh(b * x) + np.sin(b * x)))
    products = np.trapezoid(curvature[:, None] * slope, x) / np.asarray(np.trapezoid(curvature**2, x))[:, None]
    return (BEAM_ROOTS / BEAM_ROOTS[0]) ** 2, products / products[0, 0]


def first_mode(system: System) -> FirstMode:
    """The first mode of a system's plate in the light of its sun.

    Args:
        system: a plate with the marker ``tip``, in the plane z = 0 and clamped at x = 0, in sunlight which begins after t = 0
            and which both sides absorb alike. It is given a temperature, so another one is needed to simulate.

    Raises:
        DeclarationError: the light does not come from the side of the root, has a part along y, or comes exactly edge-on.
    """
    plate = next(item for item in system.declarations if isinstance(item, Plate))
    sun = next(item for item in system.declarations if isinstance(item, SolarFlux))
    section, s = plate.laminate, np.array(sun.direction) / np.linalg.norm(sun.direction)
    if s[0] <= 0.0 or s[1] != 0.0 or s[2] == 0.0:
        raise DeclarationError(
            f"SolarFlux '{sun.name}'",
            f"direction = {sun.direction}",
            "accepted is light (x, 0, z) with x > 0, from the side of the root, and z not zero",
        )
    height, through = float(section.z[-1] - section.z[0]), section.conductivity_through
    steady = float(np.max(sun.absorptivity)) * sun.constant * height / (2 * through)
    moment = float(section.thermal_moments[2, 0])
    modes = lm.modes(system, 1)
    omega = 2 * np.pi * float(modes.frequencies[0])
    system.add(PrescribedTemperature("steady", plate, temperature=0.0, gradient=-float(s[2]) * steady))
    tip, one, along = mode_integrals(modes.model.plates[0], modes.model.vectors(modes.shapes[:, 0])[:, 2])
    scale = steady * moment / omega**2
    return FirstMode(
        omega=omega,
        tau=float(section.heat_capacity[2]) / through,
        push=-scale * float(s[2]) * one * tip,
        gain=scale * float(s[0]) * along,
        rest=-float(lm.equilibrium(system)["tip.position"].sel(component="z")),
    )


def mode_integrals(mesh: PlateMesh, normal: Floats) -> tuple[float, float, float]:
    """phi at the middle of the far edge, int lap phi dA and int phi_x lap phi dA of a deflection that is clamped at x = 0.

    Both integrals are those of a divergence, so that the mode's edges suffice, where it is a cubic between nodes:

        int lap phi dA = oint phi_n ds,    int phi_x lap phi dA = oint ((phi_x^2 - phi_y^2) n_x / 2 + phi_x phi_y n_y) ds

    Args:
        mesh: the plate.
        normal: z of all vectors of the mode.
    """
    nodes = np.arange(mesh.n_nodes).reshape(mesh.ny + 1, mesh.nx + 1)
    w, w_x, w_y, w_xy = (
        np.array([[normal[mesh.vector(int(node), name)] for node in row] for row in nodes])
        for name in ("r", "r_x", "r_y", "r_xy")
    )
    places = np.linspace(0, mesh.size[0], mesh.nx + 1), np.linspace(0, mesh.size[1], mesh.ny + 1)
    x, y = (np.linspace(0, side, POINTS) for side in mesh.size)
    one = along = 0.0
    for edge, outwards in ((0, -1.0), (-1, 1.0)):
        phi_x = CubicHermiteSpline(places[0], w[edge], w_x[edge])(x, 1)
        phi_y = CubicHermiteSpline(places[0], w_y[edge], w_xy[edge])(x)
        one += outwards * float(np.trapezoid(phi_y, x))
        along += outwards * float(np.trapezoid(phi_x * phi_y, x))
    end = CubicHermiteSpline(places[1], w[:, -1], w_y[:, -1])
    phi_x, phi_y = CubicHermiteSpline(places[1], w_x[:, -1], w_xy[:, -1])(y), end(y, 1)
    one += float(np.trapezoid(phi_x, y))
    along += 0.5 * float(np.trapezoid(phi_x**2 - phi_y**2, y))
    return float(end(mesh.size[1] / 2)), one, along
