"""Torque-free spin that tumbles about the intermediate axis, against Jacobi's elliptic functions."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

import lamella as lm
from lamella.roles import Floats
from lamella.verification import Curves, Evidence, References

slow = True

I = np.array((0.2, 0.3, 0.45))  # noqa: E741  # the field's symbol
AMPLITUDES = (3.0, 1.7)  # of omega_1 and omega_3 where omega_2 is zero [rad/s]
PHASE = -1.6  # of the start, in the argument of the elliptic functions
END = 4.0
STEPS = (4e-3, 2e-3)


def exact(t: Floats) -> Floats:
    """Angular velocity in the body's axes [rad/s], shape (n, 3) (Landau and Lifshitz, Mechanics, section 37, M^2 > 2 E I_2)."""
    from scipy.special import ellipj

    a_1, a_3 = AMPLITUDES
    twice_E, M2 = I[0] * a_1**2 + I[2] * a_3**2, (I[0] * a_1) ** 2 + (I[2] * a_3) ** 2
    over, under = twice_E * I[2] - M2, M2 - twice_E * I[0]
    tau = PHASE + t * np.sqrt((I[2] - I[1]) * under / I.prod())
    sn, cn, dn, _ = ellipj(tau, (I[1] - I[0]) * over / ((I[2] - I[1]) * under))
    return np.stack([a_1 * cn, np.sqrt(over / (I[1] * (I[2] - I[1]))) * sn, a_3 * dn], axis=1)


def run() -> Iterator[Evidence]:
    """Yield the checks and pictures of this case."""
    references = References.beside(__file__)
    start = exact(np.zeros(1))[0]
    errors, times, omega = [], np.zeros(1), np.zeros((1, 3))
    for dt in STEPS:
        system = lm.System()
        system.add(lm.RigidBody("body", mass=1.0, inertia=tuple(I), angular_velocity=tuple(start)))
        result = lm.simulate(system, END, lm.GeneralizedAlpha(dt=dt, rho_inf=0.9, newton=lm.Newton(tolerance=1e-10)))
        times = result.at
        R = result["body.rotation"].values.reshape(-1, 3, 3)
        omega = np.einsum("tji,tj->ti", R, result["body.angular_velocity"].values)
        momentum = np.einsum("tij,tj->ti", R, I * omega)
        energy = result["energy.kinetic"].values
        error = np.abs(omega - exact(result.at)).max()
        drift = np.abs(momentum - I * start).max() / np.linalg.norm(I * start)
        errors.append([error, drift, np.abs(energy / energy[0] - 1).max()])
    names = ("angular velocity", "angular momentum", "kinetic energy")
    coarse, fine = errors
    for name, value in zip(names, fine, strict=True):
        yield references.check(f"largest error of the {name}", value)
    for name, before, after in zip(names[:2], coarse, fine, strict=False):
        yield references.check(f"order of the {name}", np.log2(before / after))
    names = ("ω₁", "ω₂", "ω₃")
    computed = {name: (times, values) for name, values in zip(names, omega.T, strict=True)}
    functions = {f"{name}, Jacobi": (times, values) for name, values in zip(names, exact(times).T, strict=True)}
    yield Curves("Angular velocity in the body's axes", "Time [s]", "Angular velocity [rad/s]", computed, functions)
    yield references.check("turns over", float(np.ptp(omega[:, 1])) / (2 * np.abs(omega[:, 1]).max()))
