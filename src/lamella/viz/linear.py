"""Figures of a linear model: Bode diagram and step responses (matplotlib)."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from lamella.linear.state_space import StateSpace
from lamella.roles import Floats
from lamella.viz.plots import unit_label
from lamella.viz.style import COLOURS, new_figure, place_legend, styled

if TYPE_CHECKING:
    from matplotlib.figure import Figure

MOST_OUTPUTS = 8
"""Outputs drawn: as many as there are colours."""
POINTS, NEAR_POLE = 400, 12
"""Frequencies of a Bode diagram, equally spaced in their logarithm, and more about each vibration."""
LIGHTEST = 1e-3
"""Damping ratio from which a vibration counts as decaying fast enough to wait for its end."""


def plot_bode(model: StateSpace) -> Figure:
    """Magnitude and phase of every output over the frequency, a column for each input."""
    from matplotlib.ticker import MultipleLocator

    f = bode_frequencies(model)
    response = model.frequency_response(f)
    with styled():
        figure = new_figure(4.6)
        grid = figure.subplots(2, len(model.inputs), sharex=True, sharey="row", squeeze=False, height_ratios=(3, 2))
        for j, (upper, lower) in enumerate(zip(*grid, strict=True)):
            for i, name in enumerate(model.outputs[:MOST_OUTPUTS]):
                gain = response[:, i, j]
                if not np.any(np.abs(gain) > 1e-12 * np.abs(response[:, i]).max()):
                    continue
                label = unit_label(name, model.output_units[i])
                upper.loglog(f, np.abs(gain), color=COLOURS[i], label=label)
                lower.semilogx(f, np.degrees(np.unwrap(np.angle(gain))), color=COLOURS[i])
            upper.set_title(f"From {unit_label(model.inputs[j], model.input_units[j])}")
            lower.set_xlabel("Frequency [Hz]")
            lower.yaxis.set_major_locator(MultipleLocator(180.0))
        grid[0][0].set_ylabel("Magnitude")
        grid[1][0].set_ylabel("Phase [deg]")
        place_legend(grid[0][-1])
    return figure


def plot_step(model: StateSpace) -> Figure:
    """Changes of every output after a unit step of each input: a row for each output, a column for each input."""
    t = step_times(model)
    with styled():
        shown = model.outputs[:MOST_OUTPUTS]
        figure = new_figure(0.6 + 1.6 * len(shown))
        grid = figure.subplots(len(shown), len(model.inputs), sharex=True, squeeze=False)
        for j, name in enumerate(model.inputs):
            y = model.step_response(t, name)
            grid[0][j].set_title(f"Unit step of {unit_label(name, model.input_units[j])}")
            grid[-1][j].set_xlabel("Time [s]")
            for i, output in enumerate(shown):
                grid[i][j].plot(t, y[:, i], color=COLOURS[i])
                if j == 0:
                    grid[i][j].set_ylabel(unit_label(output, model.output_units[i]))
    return figure


def bode_frequencies(model: StateSpace) -> Floats:
    """Frequencies from below the slowest to above the fastest pole [Hz], dense where vibrations resound."""
    poles = model.poles()
    sizes = np.abs(poles) / (2.0 * np.pi)
    sizes = sizes[sizes > 1e-9 * sizes.max(initial=0.0)]
    if not len(sizes):
        return np.logspace(-2, 2, POINTS)
    low, high = 0.1 * sizes.min(), 3.0 * sizes.max()
    about = [np.logspace(np.log10(low), np.log10(high), POINTS)]
    for pole in poles[poles.imag > 0.0]:
        centre, width = pole.imag / (2.0 * np.pi), max(abs(pole.real), 1e-4 * pole.imag) / (2.0 * np.pi)
        aside = width * np.logspace(-1, 2, NEAR_POLE)
        about += [centre - aside, centre + aside]  # not at the centre, where nothing may be left of an undamped one
    f = np.unique(np.concatenate(about))
    return f[(f >= low) & (f <= high)]


def step_times(model: StateSpace) -> Floats:
    """Equally spaced times over which a step response shows the slowest motion, and some periods of it where nothing decays."""
    poles = model.poles()
    largest = np.abs(poles).max(initial=1.0)
    moving = poles[np.abs(poles) > 1e-9 * largest]
    if not len(moving):
        return np.linspace(0.0, 1.0, POINTS)
    slowest = moving[np.argmin(np.abs(moving))]
    periods = 10.0 * 2.0 * np.pi / abs(slowest)
    decays = -slowest.real > LIGHTEST * abs(slowest)
    return np.linspace(0.0, min(6.0 / -slowest.real, periods) if decays else 0.5 * periods, 3 * POINTS)
