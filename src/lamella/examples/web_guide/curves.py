"""What is read from a run of the steered belt."""

from __future__ import annotations

import numpy as np

from lamella.result import Result
from lamella.roles import Floats
from lamella.study.measures import component, least_squares_slope, time_average

PERIOD = 0.01
"""Of the controller [s]."""


def even(run: Result) -> Floats:
    """Times of which every second is a sample time of the controller, over a run [s]."""
    return run.at[0] + 0.5 * PERIOD * np.arange(round(float(run.at[-1] - run.at[0]) / (0.5 * PERIOD)) + 1)


def at(grid: Floats, t: Floats, z: Floats) -> Floats:
    """A curve at other times."""
    return np.interp(grid, t, z)


def edge(run: Result) -> tuple[Floats, Floats]:
    """Times and place of the edge under the sensor [m]."""
    return component(run, "eye.position", "z")


def angle(run: Result) -> Floats:
    """Steering angle [rad]."""
    return np.asarray(run.samples("pivot2.angle"), float)


def tension(run: Result, end: str) -> Floats:
    """Membrane force along the edge of an end, mean around the loop [N/m]."""
    return np.asarray(run.samples(f"edge_{end}.mean"), float)


def drift(run: Result, since: float) -> float:
    """Sideways speed of the belt as a whole from a time on [m/s]."""
    t, z = component(run, "loop.position", "z")
    late = t >= since
    return least_squares_slope(t[late], z[late])


def difference(run: Result, since: float) -> float:
    """Tension of edge b less that of edge a over their mean, averaged from a time on."""
    late = run.at >= since
    a, b = (time_average(run.at[late], tension(run, end)[late]) for end in "ab")
    return (b - a) / (0.5 * (a + b))


def apart(run: Result, model: Floats) -> float:
    """Root of the mean square of what run and model differ by [m]."""
    return float(np.sqrt(np.mean((at(even(run), *edge(run)) - model) ** 2)))
