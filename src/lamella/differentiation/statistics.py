"""Derivatives of the numbers that describe a recorded signal."""

from __future__ import annotations

import numpy as np

from lamella.errors import DeclarationError
from lamella.roles import Floats
from lamella.study.measures import time_average
from lamella.sweep.outputs import NORM, SignalOutput


def statistic_derivative(
    output: SignalOutput, labels: tuple[str, ...], at: Floats, values: Floats, derivatives: Floats
) -> Floats:
    """Derivative of an output by each parameter, shape (n_parameter,).

    Args:
        output: what is taken from the signal.
        labels: of the signal's components.
        at: times of the samples [s].
        values: of the signal, shape (n, n_component).
        derivatives: of the signal, shape (n, n_parameter, n_component).

    Raises:
        DeclarationError: the number has no derivative, as that of the length of a vector that vanishes.
    """
    if output.component == NORM:
        z = np.linalg.norm(values, axis=1)
        if (not z.all() and output.statistic != "last") or not z[-1]:
            raise _refused(output, "the length of a vector that vanishes")
        dz = np.einsum("nc,npc->np", values, derivatives) / np.where(z, z, 1.0)[:, None]
    else:
        k = labels.index(output.component) if output.component is not None else 0
        z, dz = values[:, k], derivatives[:, :, k]
    columns = [output.within(at, dz[:, p])[1] for p in range(dz.shape[1])]
    times, z = output.within(at, z)
    dz = np.array(columns).reshape(dz.shape[1], -1)
    return np.array([_derivative(output, times, z, column) for column in dz])


def _derivative(output: SignalOutput, t: Floats, z: Floats, dz: Floats) -> float:
    kind = output.statistic
    if kind == "last":
        return float(dz[-1])
    if kind == "mean":
        return time_average(t, dz)
    if kind in ("rms", "std"):
        centre = time_average(t, z) if kind == "std" else 0.0
        size = float(np.sqrt(time_average(t, (z - centre) ** 2)))
        if size == 0.0:
            raise _refused(output, f"{kind} of a signal that does not vary")
        return time_average(t, (z - centre) * dz) / size
    height = {"max": z, "min": -z, "largest": np.abs(z)}[kind]
    top = np.flatnonzero(height == height.max())
    signs = np.sign(z[top]) if kind == "largest" else np.ones(len(top))
    slopes = signs * dz[top]
    if np.ptp(slopes) > 1e-9 * np.abs(slopes).max(initial=0.0) or (kind == "largest" and not signs.all()):
        raise _refused(output, f"{kind}, which is reached at several times")
    return float(slopes[0])


def _refused(output: SignalOutput, what: str) -> DeclarationError:
    return DeclarationError("gradient", f"the output of '{output.signal}' has no derivative here: {what}")
