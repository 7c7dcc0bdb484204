"""Derivatives of the numbers that describe a recorded signal."""

from __future__ import annotations

import numpy as np

from lamella.errors import DeclarationError
from lamella.roles import Floats
from lamella.study.measures import least_squares_slope, time_average
from lamella.sweep.outputs import NORM, SignalOutput

ROUNDING = 1e-12
"""Scatter of a signal, as a share of its largest value, that is rounding."""


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
        dz = np.einsum("nc,npc->np", values, derivatives) / np.where(z, z, np.nan)[:, None]  # none where it vanishes
    else:
        k = labels.index(output.component) if output.component is not None else 0
        z, dz = values[:, k], derivatives[:, :, k]
    columns = [output.within(at, dz[:, p])[1] for p in range(dz.shape[1])]
    times, z = output.within(at, z)
    dz = np.array(columns).reshape(dz.shape[1], -1)
    found = np.array([_derivative(output, times, z, column) for column in dz])
    if np.isnan(found).any():
        raise _refused(output, "the length of a vector that vanishes")
    return found


def _derivative(output: SignalOutput, t: Floats, z: Floats, dz: Floats) -> float:
    kind = output.statistic
    if kind == "last":
        return float(dz[-1])
    if kind == "mean":
        return time_average(t, dz)
    if kind == "slope":
        return least_squares_slope(t, dz)
    if kind in ("rms", "std"):
        centre = time_average(t, z) if kind == "std" else 0.0
        size = float(np.sqrt(time_average(t, (z - centre) ** 2)))
        if size <= ROUNDING * np.abs(z).max():
            raise _refused(output, f"{kind} of a signal that does not vary")
        product = (z - centre) * dz
        return time_average(t, np.where(z, product, 0.0) if kind == "rms" else product) / size  # z^2 is smooth at zero
    height = {"max": z, "min": -z, "largest": np.abs(z)}[kind]
    top = np.flatnonzero(height == height.max())
    signs = np.sign(z[top]) if kind == "largest" else np.ones(len(top))
    slopes = signs * dz[top]
    if np.ptp(slopes) > 1e-9 * np.abs(slopes).max(initial=0.0) or (kind == "largest" and not signs.all()):
        raise _refused(output, f"{kind}, which is reached at several times")
    return float(slopes[0])


def _refused(output: SignalOutput, what: str) -> DeclarationError:
    return DeclarationError("gradient", f"the output of '{output.signal}' has no derivative here: {what}")
