"""A surface given by a Python function."""

from __future__ import annotations

from collections.abc import Callable
from typing import ClassVar, Literal

import numpy as np

from lamella.declaration import declaration
from lamella.errors import DeclarationError
from lamella.roles import Floats
from lamella.surface.base import Surface, SurfacePoints
from lamella.units import Thickness

DEGREE = 24
"""Degree of the polynomial that stands for the function between two of its samples."""
RESOLVED = 1e-7
"""Largest share of the last coefficients, relative to the largest: beyond, the function is not smooth enough."""


@declaration
class FunctionSurface(Surface):
    """A smooth surface r = function(x, y) over 0 <= x <= lengths[0], 0 <= y <= lengths[1].

    The function is taken as a Chebyshev series of degree 24 in each direction, whose derivatives give the slopes to about 1e-10;
    a function that the series does not resolve is refused.

    Args:
        function: takes arrays x, y [m] of shape (n,) and returns positions [m], shape (n, 3).
        lengths: of the parameters x and y [m].
        closed: ``x`` or ``y`` or ``xy`` for directions in which the surface closes on itself smoothly.

    Raises:
        DeclarationError: the function fails, returns another shape or values that are not finite, or is not smooth.
    """

    python_only: ClassVar[bool] = True
    function: Callable[[Floats, Floats], Floats]
    lengths: tuple[Thickness, Thickness]
    closed: Literal["", "x", "y", "xy"] = ""

    def __post_init__(self) -> None:
        """Sample the function and expand it."""
        nodes = 0.5 - 0.5 * np.cos(np.pi * (np.arange(DEGREE + 1) + 0.5) / (DEGREE + 1))
        y, x = (v.reshape(-1) for v in np.meshgrid(self.lengths[1] * nodes, self.lengths[0] * nodes, indexing="ij"))
        values = self._sampled(x, y).reshape(DEGREE + 1, DEGREE + 1, 3)
        vander = np.polynomial.chebyshev.chebvander(2.0 * nodes - 1.0, DEGREE)
        inverse = np.linalg.inv(vander)
        series = np.einsum("ij,kl,jlc->ikc", inverse, inverse, values)
        tail = max(np.abs(series[-2:]).max(), np.abs(series[:, -2:]).max())
        if tail > RESOLVED * np.abs(series).max():
            raise DeclarationError(
                "FunctionSurface",
                f"the function is not smooth: its last Chebyshev coefficients are {tail:.1e} m",
                "accepted is a function with many derivatives; several shells may be joined where it has a kink",
            )
        object.__setattr__(self, "_series", series)

    def _sampled(self, x: Floats, y: Floats) -> Floats:
        try:
            r = np.asarray(self.function(x, y), float)
        except Exception as error:
            raise DeclarationError("FunctionSurface", f"the function failed: {error}", "accepted are arrays x, y") from error
        if r.shape != (len(x), 3) or not np.isfinite(r).all():
            problem = f"the function returned the shape {r.shape}" if r.shape != (len(x), 3) else "the function is not finite"
            raise DeclarationError("FunctionSurface", problem, f"accepted are finite positions of shape ({len(x)}, 3)")
        return r

    @property
    def size(self) -> tuple[float, float]:
        return self.lengths

    @property
    def loops(self) -> tuple[bool, bool]:
        return "x" in self.closed, "y" in self.closed

    def at(self, x: Floats, y: Floats) -> SurfacePoints:
        chebyshev = np.polynomial.chebyshev
        series: Floats = self._series  # type: ignore[attr-defined]
        scaled = [2.0 * v / length - 1.0 for v, length in zip((x, y), self.lengths, strict=True)]
        rows: dict[tuple[int, int], Floats] = {}
        for dx in (0, 1):
            for dy in (0, 1):
                c = chebyshev.chebder(chebyshev.chebder(series, dy, axis=0), dx, axis=1)
                factor = (2.0 / self.lengths[0]) ** dx * (2.0 / self.lengths[1]) ** dy
                rows[dx, dy] = np.asarray(factor * chebyshev.chebval2d(scaled[1], scaled[0], c).T, float)
        return SurfacePoints(rows[0, 0], rows[1, 0], rows[0, 1], rows[1, 1])
