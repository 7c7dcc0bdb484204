"""The pictures of the study."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from lamella.examples.swing import Swing, animation_of
from lamella.roles import Floats
from lamella.study.measures import spectrum

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from lamella.study.study import Study

Heights = Mapping[tuple[int, int], float]
Swings = Mapping[tuple[int, str], Swing]
Trace = tuple[Sequence[float], Sequence[float]]
SHOWN = (0.05, 0.1, 0.15, 0.2)
"""Times of the shaded pictures [s]."""
SCALE = 30.0
"""Factor on the displacements in the shaded pictures."""


def show_all(
    study: Study,
    swings: Swings,
    middle: str,
    stiffening: tuple[Floats, Floats],
    pinned: Heights,
    sliding: Heights,
    others: Heights,
    trace: Trace | None,
) -> None:
    """Draw everything for the report page, the paper's figures first."""
    from lamella.viz.plots import plot_energy

    forces = sorted({force for force, _ in swings})
    study.show(
        deflections(swings, middle, trace),
        "deflection",
        "Deflection of C over time on several meshes, figures 6 and 7 of the paper. The thin dashed line is the static "
        "deflection.",
    )
    if pinned:
        study.show(
            convergence(pinned, sliding, others),
            "convergence",
            "Static deflection of C over the mesh. Left: with pinned corners it grows on with the logarithm of the number of "
            "elements (straight lines), with corners that slide in the plane it has a limit. Right: what doubling the number of "
            "elements along a side adds.",
        )
    study.show(
        frequencies({force: swings[force, middle] for force in forces}, stiffening),
        "frequency",
        "Left: spectra of the deflection of C. Right: natural frequencies of small vibrations about the equilibrium under the "
        "force.",
    )
    study.show(
        plot_energy(swings[forces[-1], middle].result, title=f"Energy, {forces[-1]} N"),
        "energy",
        "Energies and work, and below what their balance leaves over: what the integrator has damped.",
    )
    shapes(study, swings[forces[-1], middle], f"{forces[-1]}N-mesh-{middle}", forces[-1])


def deflections(swings: Swings, middle: str, trace: Trace | None) -> Figure:
    """Figures 6 and 7 of the paper: a panel for each force, a curve for each mesh."""
    from lamella.viz.style import COLOURS, DASHES, INK, new_figure, styled

    forces = sorted({force for force, _ in swings})
    with styled():
        figure = new_figure(5.6)
        panels = figure.subplots(len(forces), 1, sharex=True)
        for axes, force in zip(panels, forces, strict=True):
            grids = [grid for one, grid in swings if one == force]
            for grid, colour, dash in zip(
                grids, (COLOURS[3], COLOURS[0], COLOURS[1]), (DASHES[2], DASHES[0], DASHES[1]), strict=False
            ):
                swing = swings[force, grid]
                axes.plot(swing.t, 1e3 * swing.z, color=colour, linestyle=dash, label=f"{grid} elements")
            still = 1e3 * swings[force, middle].still
            axes.axhline(still, color=INK, linestyle=DASHES[1], linewidth=0.8, label=f"static, {middle}")
            if trace and force == forces[0]:
                t, z = trace
                marks = {"markerfacecolor": "white", "markeredgecolor": INK, "markersize": 5, "zorder": 3}
                axes.plot(t, 1e3 * np.asarray(z), "o", label="another ANCF code, 6x6", **marks)
            axes.set(title=f"{force} N", ylabel="Deflection of C [mm]")
            axes.margins(x=0.01)
        panels[-1].set_xlabel("Time [s]")
        handles, labels = panels[0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside lower center", ncols=3)
    return figure


def convergence(pinned: Heights, sliding: Heights, others: Heights) -> Figure:
    """Static deflection over the mesh, of pinned and of sliding corners."""
    from lamella.viz.style import COLOURS, DASHES, INK, new_figure, styled

    forces, sizes = (sorted({key[k] for key in pinned}) for k in (0, 1))
    with styled():
        figure = new_figure(3.9)
        left, right = figure.subplots(1, 2)
        for heights, name, colour in ((pinned, "pinned", COLOURS[1]), (sliding, "sliding", COLOURS[0])):
            for force, dash, marker in zip(forces, (DASHES[0], DASHES[1]), "os", strict=True):
                look = {"color": colour, "linestyle": dash, "marker": marker, "markersize": 4, "label": f"{name}, {force} N"}
                left.plot(sizes, [heights[force, n] / heights[force, 6] for n in sizes], **look)
                halves = [n for n in sizes if 2 * n in sizes]
                right.plot(halves, [100.0 * abs(heights[force, 2 * n] / heights[force, n] - 1.0) for n in halves], **look)
        for (force, n), z in others.items():
            text = {"label": "pinned, CalculiX S8R"} if n == 8 and force == forces[0] else {}
            left.plot(n, z / pinned[force, 6], "D", color="white", markeredgecolor=INK, markersize=5, zorder=3, **text)
        left.set(title="Static deflection over that of 6x6", ylabel="z / z of 6x6 [–]", xscale="log")
        right.set(title="Change when n is doubled", ylabel="Change [%]", xscale="log", yscale="log")
        right.set_yticks([0.1, 1.0, 10.0], ["0.1", "1", "10"])
        _tick_meshes(left, sizes)
        _tick_meshes(right, [n for n in sizes if 2 * n in sizes])
        figure.legend(*left.get_legend_handles_labels(), loc="outside lower center", ncols=3, handlelength=3.6)
    return figure


def _tick_meshes(axes: Axes, sizes: Sequence[int]) -> None:
    axes.set_xticks(sizes, [str(n) for n in sizes])
    axes.set_xticks([], minor=True)
    axes.set_xlabel("Elements along a side n [–]")


def frequencies(swings: Mapping[int, Swing], stiffening: tuple[Floats, Floats]) -> Figure:
    """Spectra of the motions, and natural frequencies over the force."""
    from lamella.viz.style import COLOURS, DASHES, new_figure, styled

    with styled():
        figure = new_figure(3.4)
        left, right = figure.subplots(1, 2)
        for (force, swing), colour in zip(swings.items(), (COLOURS[0], COLOURS[1]), strict=True):
            f, amplitude = spectrum(swing.t, swing.z)
            kept = f < 20.0
            left.plot(f[kept], 1e3 * amplitude[kept], color=colour, label=f"{force} N: {swing.peak_frequency:.2f} Hz")
        left.set(title="Spectrum of z of C", xlabel="Frequency [Hz]", ylabel="Amplitude [mm]")
        left.set_ylim(bottom=0.0)
        left.legend(loc="upper right")
        forces, natural = stiffening
        for k, name, dash in ((0, "first mode", DASHES[0]), (1, "second mode", DASHES[1])):
            right.plot(forces, natural[:, k], color=COLOURS[2], linestyle=dash, marker="o", markersize=3, label=name)
        right.set(title="Small vibrations about equilibrium", xlabel="Force [N]", ylabel="Natural frequency [Hz]")
        right.set_ylim(bottom=0.0)
        right.legend(loc="lower right")
    return figure


def shapes(study: Study, swing: Swing, name: str, force: int) -> None:
    """Shaded pictures at several times and the animation, coloured by the stress."""
    from lamella.viz.scene import picture

    study.say("drawing the deformed plate")
    folder, title = study.folder / "pictures", f"Under {force} N, displacement × {SCALE:g}"
    shape = picture(swing.result, folder / "shape.png", at=SHOWN, field="von_mises", scale=SCALE, title=title)
    study.captions[shape] = f"The plate under {force} N, coloured by the largest von Mises stress of all plies."
    study.files.append(shape)
    if moving := animation_of(study, name):
        study.captions[moving] = f"The motion under {force} N, slowed down; displacement × {SCALE:g}."
