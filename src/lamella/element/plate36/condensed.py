"""Force blocks of Plate36: those of Plate48 in coordinates of the elements' own, expanded and condensed by a constant matrix."""

from __future__ import annotations

from typing import Any

import numpy as np

from lamella.element.block import ElementBlock, Range
from lamella.element.plate36 import kernels
from lamella.element.plate36.shape import Plate36, expansion
from lamella.element.plate48.damping import DampedShellBlock, KelvinVoigtBlock
from lamella.element.plate48.entries import ALL_PAIRS, PAIRS, all_entries, upper_entries
from lamella.element.plate48.exact import ShellBlock
from lamella.element.plate48.section import Section
from lamella.element.plate48.shape import Plate48, product_order
from lamella.lane import WIDTH, aligned
from lamella.roles import Floats, Ints
from lamella.threads import Workspace

CONDENSED = 3e-6
"""Seconds that it takes to condense the tangent of an element."""


class CondensedBlock(ElementBlock):
    """A force of Plate36 elements from that of Plate48 elements of the same shape.

    The functions of Plate36 are among those of Plate48, so that with e48 = P e36, one constant matrix for all elements,

        W36 = W48(P e36),      f36 = P^T f48,      K36 = P^T K48 P

    exactly, for every energy and every dissipation.

    Args:
        name: name of the body, for messages.
        coords: global coordinates of each element in element order, shape (n_element, 36).
        scale: factors from global to element coordinates, shape (n_element, 36).
        reference: unscaled stress-free coordinates, shape (n_element, 36).
        model: the block of Plate48.
        others: its arguments behind the element tables.

    Raises:
        ModelError: as that block.
    """

    def __init__(
        self,
        name: str,
        coords: Ints,
        scale: Floats,
        reference: Floats,
        model: type[ShellBlock] | type[KelvinVoigtBlock],
        *others: Any,
    ) -> None:
        symmetric = model.symmetry == "symmetric"
        super().__init__(name, Plate36(), np.arange(36), coords, scale, reference, *_entries(symmetric))
        P, kept = expansion(), _kept_first()
        vectors = self.rest.reshape(self.n_element, 12, 3)
        rest = np.einsum("ki,eic->ekc", P, vectors).reshape(self.n_element, 48)
        self._full = model(name, _own_coords(self.n_element), np.ones(rest.shape), rest, *others)
        self.symmetry, self.depends_on_velocity = self._full.symmetry, self._full.depends_on_velocity
        self._twists = P[kept[12:]].reshape(-1)
        vector_place = np.argsort(product_order()).reshape(16, 3)[:, 0]  # of each vector in the order of the kernels
        self._places = vector_place[kept]
        self._source, self._is_upper = _sources(symmetric, self._places)
        n = self.n_block * WIDTH
        self._q, self._v, self._q_previous, self._f = (aligned(48 * n) for _ in range(4))
        self._k, self._work = aligned(len(self._full.rows) * n), Workspace(12 * 16 * WIDTH)

    def force(self, t: float, q: Floats, v: Floats, f: Floats) -> None:
        """The force P^T f48."""
        self._full.force(t, self._expanded(q, self._q), self._velocities(v), self._f)
        kernels.condense_force(self._f, self._twists, self._places, f)

    def damping_force(self, t: float, q: Floats, v: Floats, f: Floats) -> None:
        """What velocities add to the force."""
        self._full.damping_force(t, self._expanded(q, self._q), self._velocities(v), self._f)
        kernels.condense_force(self._f, self._twists, self._places, f)

    def force_tangent(
        self, t: float, q: Floats, v: Floats, alpha_q: float, alpha_v: float, q_previous: Floats, f: Floats, k: Floats
    ) -> None:
        """The force and its tangent P^T K48 P."""
        full = self._expanded(q, self._q)
        previous = full if q_previous is q else self._expanded(q_previous, self._q_previous)
        self._full.force_tangent(t, full, self._velocities(v), alpha_q, alpha_v, previous, self._f, self._k)
        kernels.condense_force(self._f, self._twists, self._places, f)
        self.over_blocks(CONDENSED, lambda blocks: self._condense(blocks, k))

    def _condense(self, blocks: Range, k: Floats) -> None:
        full, own = blocks.of(self._k), blocks.of(k)
        n, work = len(self._full.rows), self._work.array
        kernels.condense_tangent(full, n, self._source, self._is_upper, self._twists, work, own)

    def energy(self, t: float, q: Floats) -> float:
        """Potential energy [J]."""
        return self._full.energy(t, self._expanded(q, self._q))

    def dissipation(self, t: float, q: Floats, v: Floats) -> float:
        """Power turned into heat [W]."""
        return self._full.dissipation(t, self._expanded(q, self._q), self._velocities(v))

    def _expanded(self, q: Floats, out: Floats) -> Floats:
        kernels.expand(q, self._index, self._scale, self._twists, self._places, out)
        return out

    def _velocities(self, v: Floats) -> Floats:
        return self._expanded(v, self._v) if self.depends_on_velocity else self._v


class CondensedShell(CondensedBlock):
    """Elastic Plate36 shell with exact Kirchhoff-Love strains: :class:`ShellBlock`, condensed; the arguments are the same."""

    def __init__(
        self, name: str, coords: Ints, scale: Floats, reference: Floats, section: Section | Floats, n_gauss: int = 4
    ) -> None:
        super().__init__(name, coords, scale, reference, ShellBlock, section, n_gauss)


class CondensedDamping(CondensedBlock):
    """Kelvin-Voigt damping of Plate36 shells: :class:`KelvinVoigtBlock`, condensed; the arguments are the same."""

    def __init__(
        self, name: str, coords: Ints, scale: Floats, reference: Floats, section: Section | Floats, time: float, n_gauss: int = 4
    ) -> None:
        super().__init__(name, coords, scale, reference, KelvinVoigtBlock, section, time, n_gauss)


class CondensedDamped(CondensedBlock):
    """Elastic Plate36 shell with Kelvin-Voigt damping: :class:`DampedShellBlock`, condensed; the arguments are the same."""

    def __init__(
        self, name: str, coords: Ints, scale: Floats, reference: Floats, section: Section | Floats, time: float, n_gauss: int = 4
    ) -> None:
        super().__init__(name, coords, scale, reference, DampedShellBlock, section, time, n_gauss)


def _kept_first() -> Ints:
    """Vectors of Plate48 in element order: the twelve that Plate36 has, in its order, and then the four twists."""
    names = Plate48.vector_names * len(Plate48.nodes)
    return np.array(sorted(range(len(names)), key=lambda k: names[k] not in Plate36.vector_names))


def _own_coords(n_element: int) -> Ints:
    """Coordinates of the elements' own, shape (n_element, 48), numbered so that the kernels read them one after the other."""
    block, lane = np.divmod(np.arange(n_element), WIDTH)
    coords = np.empty((n_element, 48), np.int64)
    coords[:, product_order()] = (48 * block[:, None] + np.arange(48)) * WIDTH + lane[:, None]
    return coords


def _entries(symmetric: bool) -> tuple[Ints, Ints]:
    """Rows and columns of the entries of an element's tangent in the order of :func:`kernels.condense_tangent`."""
    entries = [
        (3 * i + c, 3 * j + d)
        for c, d in (PAIRS if symmetric else ALL_PAIRS)
        for i in range(12)
        for j in range(i if symmetric and c == d else 0, 12)
    ]
    rows, columns = np.array(entries).T
    return np.ascontiguousarray(rows), np.ascontiguousarray(columns)


def _sources(symmetric: bool, places: Ints) -> tuple[Ints, Ints]:
    """Where :func:`kernels.condense_tangent` finds each entry, and which pairs of components have an upper triangle only."""
    rows, columns = upper_entries() if symmetric else all_entries()
    number = np.empty((48, 48), np.int64)
    if symmetric:
        number[columns, rows] = np.arange(len(rows))
    number[rows, columns] = np.arange(len(rows))
    pairs = PAIRS if symmetric else ALL_PAIRS
    source = np.stack([number[(places + c)[:, None], places + d] for c, d in pairs])
    return source.reshape(-1), np.array([int(symmetric and c == d) for c, d in pairs])
