"""Elastic Plate48 shells with the constant stiffness of the reference: the small-deformation comparator."""

from __future__ import annotations

import numpy as np

from lamella._jit import njit
from lamella.element.packing import aligned, packed, unpacked
from lamella.element.plate48.entries import upper_entries
from lamella.element.plate48.exact import ShellBlock
from lamella.element.plate48.layout import Plate48Block
from lamella.element.plate48.section import Section
from lamella.element.plate48.shape import product_order
from lamella.lane import WIDTH, load, spread, store
from lamella.roles import Floats, Ints


@njit
def deviations(q: Floats, index: Ints, scale: Floats, rest: Floats, out: Floats) -> None:
    """Scaled coordinates of the elements less those at rest, out (block, 48)."""
    for k in range(index.size):
        out[k] = q[index[k]] * scale[k] - rest[k]


@njit
def symmetric_products(matrices: Floats, rows: Ints, columns: Ints, d: Floats, f: Floats) -> None:
    """f = K d of each element, from the upper entries of K (block, entry) at the given rows and columns."""
    for block in range(d.size // (48 * WIDTH)):
        at = block * 48
        for i in range(48):
            store(f, at + i, spread(0.0))
        for m in range(rows.size):
            row, column = at + rows[m], at + columns[m]
            value = load(matrices, block * rows.size + m)
            store(f, row, load(f, row) + value * load(d, column))
            if row != column:
                store(f, column, load(f, column) + value * load(d, row))


class LinearShellBlock(Plate48Block):
    """Elastic shell with the constant stiffness of the stress-free reference.

    f = K0 (e - e_ref),  W = 1/2 (e - e_ref) . K0 (e - e_ref)

    with K0 the exact tangent at the reference. Rigid rotation of more than a few degrees strains it, as it does every
    small-deformation model in a fixed frame. The arguments are those of :class:`ShellBlock`.
    """

    def __init__(
        self, name: str, coords: Ints, scale: Floats, reference: Floats, section: Section | Floats, n_gauss: int = 4
    ) -> None:
        self._rows, self._columns = upper_entries()
        super().__init__(name, coords, scale, reference, self._rows, self._columns)
        self._rest = packed(self.rest[:, product_order()])
        self._at_rest = np.zeros_like(self._rest)
        self.matrices, self._deviations = aligned(self.k_rows.size), aligned(self.f_coords.size)
        own = np.arange(coords.size, dtype=np.int64).reshape(coords.shape)
        exact = ShellBlock(name, own, scale, reference, section, n_gauss)
        rest = np.ascontiguousarray(reference, float).reshape(-1)
        exact.force_tangent(0.0, rest, rest, 1.0, 0.0, rest, self._deviations, self.matrices)

    def force(self, t: float, q: Floats, v: Floats, f: Floats) -> None:
        """Elastic force K0 (e - e_ref)."""
        deviations(q, self._index, self._scale, self._rest, self._deviations)
        symmetric_products(self.matrices, self._rows, self._columns, self._deviations, f)

    def times_stiffness(self, v: Floats, f: Floats) -> None:
        """K0 v, for velocities."""
        deviations(v, self._index, self._scale, self._at_rest, self._deviations)
        symmetric_products(self.matrices, self._rows, self._columns, self._deviations, f)

    def force_tangent(
        self, t: float, q: Floats, v: Floats, alpha_q: float, alpha_v: float, q_previous: Floats, f: Floats, k: Floats
    ) -> None:
        """Elastic force and alpha_q K0."""
        self.force(t, q, v, f)
        np.multiply(self.matrices, alpha_q, out=k)

    def energy(self, t: float, q: Floats) -> float:
        """Strain energy [J]."""
        f = np.empty_like(self._deviations)
        self.force(t, q, q, f)
        return 0.5 * float(unpacked(f * self._deviations, self.n_element).sum())
