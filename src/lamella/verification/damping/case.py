"""Kelvin-Voigt damping takes energy from vibration and none from rigid rotation."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

import lamella as lm
from lamella.model import Model
from lamella.roles import Floats
from lamella.state import State
from lamella.verification import Check, Curves, Evidence, References
from lamella.verification.free_flight.case import internal_resultants

slow = False

LAYUP = lm.Laminate(lm.Isotropic(E=2e9, nu=0.0, rho=1200.0), thickness=0.02)
C = 2e-4
SPIN = 10.0


def decay() -> tuple[Floats, Floats, float]:
    """Times [s], energy of a cantilever in its first mode over ten periods [J], and the decay rate c omega^2 / 2 [1/s]."""
    system = lm.System()
    plate = system.add(lm.Plate("plate", (1.0, 0.2), (4, 1), LAYUP, damping=C))
    system.add(lm.Clamp("root", plate.edge("x-")))
    modes = lm.modes(system, 1)
    omega = 2 * np.pi * modes.frequencies[0]
    v = omega * (modes.displaced(0, 1e-3) - modes.state)
    start = State(0.0, modes.state.copy(), v, 0.0 * v, np.zeros(0), np.zeros(0))
    end = 10 * 2 * np.pi / omega
    result = lm.simulate(system, end, lm.GeneralizedAlpha(dt=1e-3, rho_inf=1.0), initial=start)
    return result.at, result["energy.kinetic"].values + result["energy.strain"].values, 0.5 * C * omega**2


def spin(dt: float) -> tuple[float, float, float]:
    """Free spin of a damped plate for half a second.

    Returns:
        relative change of angular momentum, and the heat relative to the kinetic energy: all of it, and of the second half.
    """
    system = lm.System()
    system.add(lm.Plate("plate", (1.0, 0.2), (4, 1), LAYUP, damping=1e-3, angular_velocity=(0, 0, SPIN)))
    model = system.compile()
    options = lm.GeneralizedAlpha(dt=dt, rho_inf=1.0, newton=lm.Newton(tolerance=1e-10))
    result = lm.simulate(model, 0.5, options)
    before, after = angular_momentum(model, model.q0, model.v0), angular_momentum(model, result.final.q, result.final.v)
    heat, kinetic = result["work.dissipated"].values, result["energy.kinetic"].values[0]
    return abs(after / before - 1), heat[-1] / kinetic, (heat[-1] - heat[len(heat) // 2]) / kinetic


def angular_momentum(model: Model, q: np.ndarray, v: np.ndarray) -> float:
    """Angular momentum about the z axis [kg m^2/s]."""
    return float(np.cross(q.reshape(-1, 3), (model.mass @ v).reshape(-1, 3)).sum(axis=0)[2])


def resultants() -> tuple[float, float]:
    """Relative sums of the internal forces, most of them damping, and of their torques in a state without any order."""
    system = lm.System()
    system.add(lm.Plate("plate", (1.0, 0.2), (4, 1), LAYUP, damping=1.0))
    model, rng = system.compile(), np.random.default_rng(1)
    q = model.q0 + 0.1 * model.magnitude * rng.uniform(-1, 1, model.n_q)
    v = model.magnitude * rng.uniform(-1, 1, model.n_q)
    return internal_resultants(model, State(0.0, q, v, 0.0 * v, np.zeros(0), np.zeros(0)))


def run() -> Iterator[Evidence]:
    """Yield the checks and pictures of this case."""
    references = References.beside(__file__)
    t, energy, expected = decay()
    rate = 0.5 * np.log(energy[0] / energy[-1]) / t[-1]
    closed = {"E₀ exp(−c ω² t)": (t, energy[0] * np.exp(-2 * expected * t))}
    yield Curves("Energy of a damped cantilever in its first mode", "Time [s]", "Energy [J]", {"lamella": (t, energy)}, closed)
    why = "the period error of the scheme, (omega dt)^2 / 12 = 6e-5, and an amplitude of 1e-3 of the length"
    yield Check("decay rate of the first mode", rate, expected, 1e-3, source="c omega^2 / 2", unit="1/s", reason=why)
    change, heat, late = spin(5e-4)
    yield references.check("change of angular momentum in free spin", change)
    yield references.check("heat of setting out", heat)
    yield references.check("heat in the second half of the spin", late)
    force, torque = resultants()
    yield references.check("resultant of damping and elastic forces", force)
    yield references.check("torque of damping and elastic forces", torque)
