"""Numbers that describe a recorded motion: time average, crossings of a level, period, spectrum."""

from __future__ import annotations

import numpy as np

from lamella.result import Result
from lamella.roles import Floats


def component(result: Result, name: str, label: str) -> tuple[Floats, Floats]:
    """Axis and one component of a vector signal.

    Args:
        result: of a solution.
        name: of the signal, such as ``C.position``.
        label: of the component, such as ``z``.
    """
    return result.at, result.samples(name)[:, result.signals[name].labels.index(label)]


def time_average(t: Floats, z: Floats) -> float:
    """``1/T int z dt`` by the trapezoidal rule; steps may differ."""
    return float(np.trapezoid(z, t) / (t[-1] - t[0]))


def least_squares_slope(t: Floats, z: Floats) -> float:
    """Slope a of the line a t + b of least int (z - a t - b)^2 dt, by the trapezoidal rule; steps may differ [unit of z / of t].

    A jump, which has two samples at one time, counts on both sides.
    """
    lever = t - time_average(t, t)
    return float(np.trapezoid(lever * z, t) / np.trapezoid(lever**2, t))


def crossings(t: Floats, z: Floats, level: float) -> Floats:
    """Times at which z passes a level, by linear interpolation between samples [unit of t], ascending."""
    k = np.flatnonzero((z[:-1] - level) * (z[1:] - level) < 0)
    return t[k] + (level - z[k]) / (z[k + 1] - z[k]) * (t[k + 1] - t[k])


def period(t: Floats, z: Floats, level: float) -> float:
    """Mean time between a crossing of a level and the next one in the same direction [unit of t]; NaN when there is none.

    Meant for a motion with one dominant frequency; others add crossings.
    """
    times = crossings(t, z, level)
    return float(np.mean(times[2:] - times[:-2])) if len(times) > 2 else float("nan")


def spectrum(t: Floats, z: Floats, *, padding: int = 16) -> tuple[Floats, Floats]:
    """Frequencies and amplitudes of the part of z that varies, seen through a Hann window.

    Zeros are added to ``padding`` times the length: this interpolates peaks, it does not resolve closer ones than 2/T.

    Args:
        t: equally spaced times [s].
        z: signal, shape like t.
        padding: factor on the length.

    Returns:
        Frequencies [Hz] and amplitudes of sines [unit of z].
    """
    window = np.hanning(len(z))
    amplitudes = 2.0 * np.abs(np.fft.rfft((z - z.mean()) * window, padding * len(z))) / window.sum()
    frequencies = np.arange(len(amplitudes)) / (padding * len(z) * float(t[1] - t[0]))
    return frequencies, np.asarray(amplitudes, float)


def dominant_frequency(t: Floats, z: Floats) -> float:
    """Frequency of the largest peak of the spectrum [Hz]."""
    frequencies, amplitudes = spectrum(t, z)
    return float(frequencies[np.argmax(amplitudes)])
