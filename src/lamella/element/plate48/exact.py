"""Elastic Plate48 shells with exact Kirchhoff-Love strains."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

import numpy as np

from lamella.element.block import ElementBlock, Range
from lamella.element.plate48 import kernels
from lamella.element.plate48.beside import force_change
from lamella.element.plate48.entries import upper_entries
from lamella.element.plate48.layout import KernelArguments, Plate48Block, gauss_tables, seen
from lamella.element.plate48.matrix_free import ShellTangent
from lamella.element.plate48.section import Section
from lamella.lane import WIDTH, aligned
from lamella.roles import Floats, Force, ForceBlock, Ints
from lamella.threads import Workspace

FORCE, TANGENT = 40e-9, 0.36e-6
"""Seconds that force, and force with tangent, take for a Gauss point of an element."""


class ShellBlock(Plate48Block):
    """Elastic shell with exact Kirchhoff-Love strains (Green-Lagrange membrane strains, curvature with the exact normal).

    W = int 1/2 eps.A eps - eps.B kap + 1/2 kap.D kap dA with E(z) = eps - z kap: the section stiffness of (eps, kap) is
    [[A, -B], [-B, D]] and the resultants are N = A eps - B kap, M = -B eps + D kap.

    Args:
        name: name of the body, for messages.
        coords: global coordinates of each element in element order, shape (n_element, 48).
        scale: factors from global to element coordinates, shape (n_element, 48).
        reference: unscaled stress-free coordinates, flat or curved, shape (n_element, 48).
        section: the section, or its stiffness [[A, -B], [-B, D]] alone, shape (6, 6) or (n_element, 6, 6).
        n_gauss: Gauss points in each direction; 4 is nearly exact, 3 faster and softer. The section may ask for fewer for the
            in-plane forces.

    Raises:
        ModelError: shapes do not agree, the reference surface has no area, or the section cannot be integrated as asked.
    """

    def __init__(
        self, name: str, coords: Ints, scale: Floats, reference: Floats, section: Section | Floats, n_gauss: int = 4
    ) -> None:
        super().__init__(name, coords, scale, reference, *upper_entries())
        self.arguments = self.kernel_arguments(gauss_tables(self, section, n_gauss))
        self._work = Workspace(kernels.work_size(n_gauss) * WIDTH)
        self._make_buffers()

    def _make_buffers(self) -> None:
        self._energies = aligned(self.n_block * WIDTH)
        if len(self.arguments) > 1:
            self._f, self._k = aligned(self.f_coords.size), aligned(self.n_k)

    def force(self, t: float, q: Floats, v: Floats, f: Floats) -> None:
        """Elastic force dW/de."""
        self._force(self.arguments[0], q, f)
        for arguments in self.arguments[1:]:
            self._force(arguments, q, self._f)
            f += self._f

    def _force(self, arguments: KernelArguments, q: Floats, f: Floats) -> None:
        self.over_blocks(
            FORCE * arguments[4] ** 2,
            lambda blocks: kernels.force(q, *seen(arguments, blocks), self._work.array, blocks.of(f)),
        )

    def force_tangent(
        self, t: float, q: Floats, v: Floats, alpha_q: float, alpha_v: float, q_previous: Floats, f: Floats, k: Floats
    ) -> None:
        """Elastic force and alpha_q d2W/de2; geometric part with strains extrapolated from ``q_previous``."""
        self._force_tangent(self.arguments[0], q, q_previous, alpha_q, f, k)
        for arguments in self.arguments[1:]:
            self._force_tangent(arguments, q, q_previous, alpha_q, self._f, self._k)
            f += self._f
            k += self._k

    def _force_tangent(
        self, arguments: KernelArguments, q: Floats, q_previous: Floats, alpha_q: float, f: Floats, k: Floats
    ) -> None:
        extrapolate = q_previous is not q

        def call(blocks: Range) -> None:
            own, part = seen(arguments, blocks), blocks.of(k)
            kernels.force_tangent(q, q_previous, extrapolate, *own, self._work.array, blocks.of(f), part)
            if alpha_q != 1.0:
                part *= alpha_q

        self.over_blocks(TANGENT * arguments[4] ** 2, call)

    def tangent(self) -> ShellTangent:
        """The tangent d2W/de2."""
        return ShellTangent(self, self.arguments, self._work)

    def force_change(self, beside: Sequence[ForceBlock], weights: Sequence[float]) -> Force | None:
        """As the role says; not of heated elements."""
        same = [each for each in beside if type(each) is ShellBlock]
        if type(self) is not ShellBlock or len(same) != len(beside):
            return None
        return force_change(self, same, weights, None, elastic=True)

    def energy(self, t: float, q: Floats) -> float:
        """Strain energy [J]."""
        total = 0.0
        for arguments in self.arguments:
            kernels.energy(q, *arguments, self._work.array, self._energies)
            total += float(self._energies[: self.n_element].sum())
        return total


class ExactModel(Protocol):
    """The exact strain model of an element: :class:`ShellBlock`, or another that takes the same arguments."""

    def __call__(
        self, name: str, coords: Ints, scale: Floats, reference: Floats, section: Section | Floats, n_gauss: int = 4
    ) -> ElementBlock:
        """The block of the elements."""
        ...


def reference_tangent(
    model: ExactModel, name: str, coords: Ints, scale: Floats, reference: Floats, section: Section | Floats, n_gauss: int
) -> tuple[ElementBlock, Floats]:
    """The exact tangent K0 of each element at the reference.

    Returns:
        The block of the elements, each with coordinates of its own, and its tangent buffer.
    """
    own = np.arange(coords.size, dtype=np.int64).reshape(coords.shape)
    shell = model(name, own, scale, reference, section, n_gauss)
    f, k = aligned(shell.f_coords.size), aligned(len(shell.k_rows))
    rest = np.ascontiguousarray(reference, float).reshape(-1)
    shell.force_tangent(0.0, rest, rest, 1.0, 0.0, rest, f, k)
    return shell, k
