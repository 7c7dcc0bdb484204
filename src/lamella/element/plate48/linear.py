"""Elastic shells with the constant stiffness of the reference: the small-deformation comparator."""

from __future__ import annotations

import numpy as np

from lamella._jit import njit
from lamella.element.block import ElementBlock
from lamella.element.packing import packed, unpacked
from lamella.element.plate48.exact import ExactModel, ShellBlock, reference_tangent
from lamella.element.plate48.section import Section
from lamella.lane import WIDTH, aligned, load, spread, store
from lamella.roles import Floats, Ints


@njit
def deviations(q: Floats, index: Ints, scale: Floats, rest: Floats, out: Floats) -> None:
    """Scaled coordinates of the elements less those at rest, out (block, coordinate)."""
    for k in range(index.size):
        out[k] = q[index[k]] * scale[k] - rest[k]


@njit
def symmetric_products(matrices: Floats, rows: Ints, columns: Ints, n: int, d: Floats, f: Floats) -> None:
    """f = K d of each element with n coordinates, from the upper entries of K (block, entry) at the given rows and columns."""
    for block in range(d.size // (n * WIDTH)):
        at = block * n
        for i in range(n):
            store(f, at + i, spread(0.0))
        for m in range(rows.size):
            row, column = at + rows[m], at + columns[m]
            value = load(matrices, block * rows.size + m)
            store(f, row, load(f, row) + value * load(d, column))
            if row != column:
                store(f, column, load(f, column) + value * load(d, row))


class LinearShellBlock(ElementBlock):
    """Elastic shell with the constant stiffness of the stress-free reference.

    f = K0 (e - e_ref),  W = 1/2 (e - e_ref) . K0 (e - e_ref)

    with K0 the exact tangent at the reference. Rigid rotation of more than a few degrees strains it, as it does every
    small-deformation model in a fixed frame. The arguments are those of :class:`ShellBlock`, and

    Args:
        exact: the element's model of exact strains.
    """

    def __init__(
        self,
        name: str,
        coords: Ints,
        scale: Floats,
        reference: Floats,
        section: Section | Floats,
        n_gauss: int = 4,
        exact: ExactModel = ShellBlock,
    ) -> None:
        shell, self.matrix_entries = reference_tangent(exact, name, coords, scale, reference, section, n_gauss)
        super().__init__(name, shell.element, shell.order, coords, scale, reference, shell.rows, shell.columns)
        self._rest = packed(self.rest[:, self.order])
        self._at_rest, self._deviations = np.zeros_like(self._rest), aligned(self.f_coords.size)

    def force(self, t: float, q: Floats, v: Floats, f: Floats) -> None:
        """Elastic force K0 (e - e_ref)."""
        deviations(q, self._index, self._scale, self._rest, self._deviations)
        self._products(f)

    def times_stiffness(self, v: Floats, f: Floats) -> None:
        """K0 v, for velocities."""
        deviations(v, self._index, self._scale, self._at_rest, self._deviations)
        self._products(f)

    def force_tangent(
        self, t: float, q: Floats, v: Floats, alpha_q: float, alpha_v: float, q_previous: Floats, f: Floats, k: Floats
    ) -> None:
        """Elastic force and alpha_q K0."""
        self.force(t, q, v, f)
        np.multiply(self.matrix_entries, alpha_q, out=k)

    def energy(self, t: float, q: Floats) -> float:
        """Strain energy [J]."""
        f = np.empty_like(self._deviations)
        self.force(t, q, q, f)
        return 0.5 * float(unpacked(f * self._deviations, self.n_element).sum())

    def turns(self, q: Floats) -> Floats:
        """Turn of the frame from the reference, which is none, shape (1, 3, 3)."""
        return np.eye(3)[None]

    def _products(self, f: Floats) -> None:
        symmetric_products(self.matrix_entries, self.rows, self.columns, len(self.order), self._deviations, f)
