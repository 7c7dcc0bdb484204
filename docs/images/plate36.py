"""Draw plate36.png: what it means that the element Plate36 is not conforming. Run from anywhere; takes some ten seconds."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

import lamella as lm
from lamella.roles import Floats
from lamella.verification.belt import LENGTH, WIDTH, Element, belt
from lamella.verification.plate36.case import held_square
from lamella.verification.ring.case import plane_frequencies
from lamella.viz.style import COLOURS, new_figure, save_figure, styled

if TYPE_CHECKING:
    from matplotlib.axes import Axes

FINE = (160, 1)
"""Mesh of plate48 whose frequency stands for the exact one."""
SERIES: tuple[tuple[str, Element, tuple[tuple[int, int], ...], str], ...] = (
    ("plate48, one across", "plate48", ((20, 1), (40, 1), (80, 1)), "o-"),
    ("plate36, one across", "plate36", ((20, 1), (40, 1), (80, 1), (160, 1)), "s-"),
    ("plate36, four across", "plate36", ((20, 4), (40, 4), (80, 4)), "^--"),
)


def main() -> None:
    """Draw the three panels and save them beside this file."""
    with styled():
        figure = new_figure(2.9, width=10.5)
        left, middle, right = figure.subplots(1, 3)
        slopes(left)
        rings(middle)
        squares(right)
        save_figure(figure, Path(__file__).with_suffix(".png"))


def slopes(axes: Axes) -> None:
    """Slope across one edge in the ring mode with four waves, from the elements on both sides."""
    for element, colour in (("plate48", COLOURS[0]), ("plate36", COLOURS[1])):
        y, both = edge_slopes(element)
        for slope, dash, side in zip(both, ("-", "--"), ("left", "right"), strict=True):
            label = element if element == "plate48" else f"{element}, from the {side}"
            axes.plot(y, slope, dash, color=colour, label=label if side == "left" or element == "plate36" else None)
    axes.set(
        title="Slope across an edge of the belt",
        xlabel="Place along the edge [m]",
        ylabel="Slope between nodes / largest [–]",
    )
    axes.set_ylim(-0.036, 0.034)
    axes.legend(loc="upper center")


def edge_slopes(element: Element) -> tuple[Floats, Floats]:
    """Places along the edge whose slope jumps most, and by what the normal's turning on both sides differs from the nodes'."""
    modes = lm.modes(belt((40, 1), element=element), 18)
    number = int(np.argmin(np.abs(modes.frequencies - plane_frequencies(modes)[2])))
    mesh, vectors = modes.model.plates[0], modes.model.vectors(modes.shapes[:, number])
    reference = modes.model.vectors(modes.model.q0)
    eta = np.linspace(0.0, 1.0, 101)
    turning = np.empty((2, mesh.nx, len(eta)))  # side of the edge at the element's end, element
    for side, xi in enumerate((1.0, 0.0)):
        shape = mesh.element.shape(np.full_like(eta, xi), eta)
        for index in range(mesh.nx):
            coords, scale = mesh.coords[index, ::3] // 3, mesh.scale[index, ::3, None]
            d, r = vectors[coords] * scale, reference[coords] * scale
            n = np.cross(shape[1] @ r, shape[2] @ r)
            n /= np.linalg.norm(n, axis=1, keepdims=True)
            turning[side, index] = np.sum((shape[1] @ d) * n, axis=1) / mesh.lx
    turning[1] = np.roll(turning[1], -1, axis=0)  # the element behind the edge
    edge = int(np.abs(turning[0] - turning[1]).max(axis=1).argmax())
    between = turning - turning[..., :1] - eta * (turning[..., -1:] - turning[..., :1])
    return eta * WIDTH, between[:, edge] / np.abs(turning[..., 0]).max()


def rings(axes: Axes) -> None:
    """Error of the ring frequency with four waves over the length of an element."""
    exact = four_waves("plate48", FINE)
    for k, (label, element, meshes, style) in enumerate(SERIES):
        errors = [abs(four_waves(element, mesh) / exact - 1) for mesh in meshes]
        axes.loglog([LENGTH / mesh[0] for mesh in meshes], errors, style, color=COLOURS[k], markersize=4.5, label=label)
    label_sizes(axes, [LENGTH / n for n in (160, 80, 40, 20)])
    axes.set(title="Belt, four waves", xlabel="Length of an element around [m]", ylabel="Error of the frequency [–]")
    axes.set_ylim(bottom=1e-6)
    axes.legend(loc="lower left")


def four_waves(element: Element, mesh: tuple[int, int]) -> float:
    """Frequency [Hz] of the ring mode with four waves."""
    return float(plane_frequencies(lm.modes(belt(mesh, element=element), 18))[2])


def squares(axes: Axes) -> None:
    """Error of the first frequency of a simply supported square, 2 in units of pi^2 sqrt(D/(rho h))/L^2."""
    counts = (2, 4, 8, 16)
    for k, element in enumerate(("plate48", "plate36")):
        errors = [abs(held_square(element, n)[0] / 2 - 1) for n in counts]
        axes.loglog([1 / n for n in counts], errors, "os"[k] + "-", color=COLOURS[k], markersize=4.5, label=element)
    label_sizes(axes, [1 / n for n in counts])
    axes.set(title="Simply supported square", xlabel="Length of an element / side [–]", ylabel="Error of the first frequency [–]")
    axes.legend(loc="best")


def label_sizes(axes: Axes, sizes: list[float]) -> None:
    """Ticks where elements are compared."""
    axes.set_xticks(sizes, [f"{size:.3g}" for size in sizes])
    axes.set_xticks([], minor=True)


if __name__ == "__main__":
    main()
