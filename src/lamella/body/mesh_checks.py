"""Whether a reference surface makes a mesh: its ends meet where they should, and no element folds or degenerates."""

from __future__ import annotations

from functools import cache
from typing import TYPE_CHECKING

import numpy as np

from lamella.element.base import ELEMENTS
from lamella.element.plate48.surface import derivatives_at_points
from lamella.element.plate48.surface_kernels import find_folds
from lamella.errors import DeclarationError
from lamella.roles import Floats
from lamella.surface.base import Surface

if TYPE_CHECKING:
    from lamella.body.mesh import PlateMesh

GAP = 1e-6
"""Largest difference between the ends of a closed direction, relative to the size, and to the slopes."""
DEGENERATE = 1e-3
"""Smallest sine of the angle between r_x and r_y."""
POINTS = (0.0, 0.25, 0.5, 0.75, 1.0)
"""Where elements are looked at, in each direction: at the nodes and between."""


def check_loops(name: str, surface: Surface, counts: tuple[int, int]) -> None:
    """Refuse a closed direction whose ends do not meet, or with fewer than three elements.

    Raises:
        DeclarationError: names the place.
    """
    for axis, letter in enumerate("xy"):
        if not surface.loops[axis]:
            continue
        if counts[axis] < 3:
            problem = f"{counts[axis]} elements along the closed direction {letter}"
            raise DeclarationError(f"'{name}'", problem, "accepted are at least 3")
        along = np.linspace(0.0, surface.size[1 - axis], counts[1 - axis] + 1)
        ends = [
            surface.at(*(np.full_like(along, end) if k == axis else along for k in (0, 1))) for end in (0.0, surface.size[axis])
        ]
        reach = max(surface.size)
        for what, scale, words in (
            ("r", reach, "do not meet"),
            ("r_x", 1.0, "meet at an angle"),
            ("r_y", 1.0, "meet at an angle"),
        ):
            gaps = np.linalg.norm(getattr(ends[1], what) - getattr(ends[0], what), axis=1)
            if gaps.max() > GAP * scale:
                worst = int(gaps.argmax())
                at = ", ".join(f"{x:.4g}" for x in ends[0].r[worst])
                size = f"{gaps[worst]:.3g} m apart" if what == "r" else f"{what} differs by {gaps[worst]:.3g}"
                raise DeclarationError(
                    f"'{name}'",
                    f"closed along {letter}, but its ends {words} at ({at}) m, where {letter} is 0: {size}",
                    "accepted is a surface that closes smoothly, or one that is not closed",
                )


@cache
def _looked_at(element: str) -> tuple[Floats, Floats, Floats]:
    """The points xi, eta, and shape functions with first derivatives there."""
    xi, eta = (v.reshape(-1) for v in np.meshgrid(POINTS, POINTS))
    return xi, eta, ELEMENTS[element].shape(xi, eta)[:3]


def check_folds(mesh: PlateMesh) -> None:
    """Refuse elements whose stress-free configuration has no area or turns over.

    Raises:
        DeclarationError: names the place.
    """
    xi, eta, shape = _looked_at(mesh.element.name)
    r, r_xi, r_eta = derivatives_at_points(shape, mesh.reference * mesh.scale).swapaxes(1, 2)
    thin, turned = find_folds(r_xi, r_eta, DEGENERATE, np.empty((len(xi), 3)))
    for bad, words in (
        (thin, "degenerates: r_x and r_y are parallel, or one of them vanishes"),
        (turned, "folds: its normal turns over"),
    ):
        if bad >= 0:
            element, point = divmod(bad, len(xi))
            j, i = divmod(element, mesh.nx)
            at = ", ".join(f"{x:.4g}" for x in r[point, element])
            x, y = (i + xi[point]) * mesh.lx, (j + eta[point]) * mesh.ly
            raise DeclarationError(
                f"'{mesh.name}'",
                f"the surface {words} at x = {x:.4g} m, y = {y:.4g} m, which is the point ({at}) m",
                "accepted is a surface with a normal everywhere that the mesh resolves",
            )
