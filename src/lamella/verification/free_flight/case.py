"""A plate that spins, flies and vibrates freely keeps momentum and energy."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

import lamella as lm
from lamella.model import Model
from lamella.state import State
from lamella.verification import Evidence, Orders, References

slow = False

STEPS = (1e-3, 5e-4, 2.5e-4)
END = 0.1


def flying() -> tuple[Model, State]:
    """A free plate with translation, spin and the velocity of its first two elastic modes."""
    layup = lm.Laminate(lm.Isotropic(E=2e9, nu=0.3, rho=1200.0), thickness=0.02)
    system = lm.System()
    velocity, spin = (1.0, -2.0, 3.0), (2.0, 5.0, -3.0)
    system.add(lm.Plate("plate", (1.0, 0.8), (2, 2), layup, velocity=velocity, angular_velocity=spin, rotation=(0.3, 0.2, 0.1)))
    modes = lm.modes(system, 8)
    model = modes.model
    v = model.v0 + sum(modes.displaced(mode, speed) - modes.state for mode, speed in ((6, 1.0), (7, 0.5)))
    return model, State(0.0, model.q0.copy(), v, 0.0 * v, np.zeros(0), np.zeros(0))


def momenta(model: Model, state: State) -> tuple[np.ndarray, np.ndarray]:
    """Linear momentum, and angular momentum about the origin: the sum of x_k x (M v)_k over all vectors, slopes too."""
    p = (model.mass @ state.v).reshape(-1, 3)
    return p[model.is_position].sum(axis=0), np.cross(state.q.reshape(-1, 3), p).sum(axis=0)


def run() -> Iterator[Evidence]:
    """Yield the checks and pictures of this case."""
    references = References.beside(__file__)
    model, start = flying()
    P, H = momenta(model, start)
    drift, energy, final = [], [], start
    for dt in STEPS:
        integrator = lm.GeneralizedAlpha(dt=dt, rho_inf=1.0, newton=lm.Newton(tolerance=1e-11))
        result = lm.simulate(model, END, integrator, initial=start)
        final = result.final
        P_end, H_end = momenta(model, final)
        drift.append(np.abs(H_end - H).max() / np.linalg.norm(H))
        energy.append(np.abs(result["energy.balance"].values).max() / result["energy.strain"].values.max())
        yield references.check(f"change of linear momentum, {dt * 1e3:g} ms", np.abs(P_end - P).max() / np.linalg.norm(P))
    forces = internal_resultants(model, final)
    yield references.check("resultant of internal forces", forces[0])
    yield references.check("torque of internal forces", forces[1])
    yield references.check("change of angular momentum, 0.25 ms", drift[-1])
    yield references.check("change of energy, 0.25 ms", energy[-1])
    yield references.check("observed order of energy", np.log2(energy[0] / energy[2]) / 2)
    yield references.check("observed order of angular momentum", np.log2(drift[0] / drift[2]) / 2)
    yield Orders("Changes in free flight", "Time step [s]", {"energy": (STEPS, energy), "angular momentum": (STEPS, drift)}, (2,))


def internal_resultants(model: Model, state: State) -> tuple[float, float]:
    """Sum of the internal forces and of their torques in a state, relative to the sum of their magnitudes."""
    f = np.zeros(model.n_q)
    for block in model.forces:
        part = np.empty(len(block.f_coords))
        block.force(state.t, state.q, state.v, part)
        used = block.f_coords >= 0
        np.add.at(f, block.f_coords[used], (part * block.f_scale)[used])
    f = f.reshape(-1, 3)
    size = np.abs(f).sum()
    force, torque = f[model.is_position].sum(axis=0), np.cross(state.q.reshape(-1, 3), f).sum(axis=0)
    return float(np.abs(force).max() / size), float(np.abs(torque).max() / size)
