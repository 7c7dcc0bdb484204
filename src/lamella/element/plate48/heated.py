"""Plate48 shells with thermal strain, and what their force and the sun's flux owe to temperature and shape."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from copy import copy

import numpy as np

from lamella.element.packing import packed, packed_indices, packed_targets
from lamella.element.plate48 import heat_kernels as kernels
from lamella.element.plate48.beside import Place, ReferenceChange, comparable, weighed
from lamella.element.plate48.exact import ShellBlock
from lamella.element.plate48.interpolation import N_SECTION
from lamella.element.plate48.layout import GaussTables, KernelArguments, Plate48Block, gauss_tables
from lamella.element.plate48.matrix_free import ShellTangent
from lamella.element.plate48.section import Section
from lamella.element.plate48.shape import hermite_table, product_order
from lamella.element.plate48.strain import Cubed
from lamella.lane import WIDTH, aligned
from lamella.math.gauss import gauss_rule
from lamella.numbering import Numbering
from lamella.roles import Bools, Floats, Force, ForceBlock, Ints, Symmetry
from lamella.threads import Workspace

NODES = ((0, 0), (1, 0), (0, 1), (1, 1))
"""Order of an element's nodes, (a, b), in its temperatures."""


class HeatedShellBlock(ShellBlock):
    """A shell whose stress-free strains follow its temperatures: W(s - s_T), N = C (s - s_T), with

        C s_T = (N_T, -M_T),     N_T = a0 T_N + a1 T_M,     M_T = a1 T_N + a2 T_M

    as membrane strain eps and curvature kap enter by E = eps - z kap. For finite strains s_T is added to the Green-Lagrange
    strains (to first order in alpha T, which is some per cent at most). The energy differs from the section's free energy by a
    function of temperature alone.

    Args:
        temperatures: coordinates of T_N and then T_M at an element's four nodes, shape (n_element, 8).
        expansion: thermal resultants a0, a1, a2 of (1, 2, 12) for each power of z, shape (3, 3).
        others: as for :class:`ShellBlock`.
    """

    varies = True
    same_sections = False

    def __init__(
        self,
        name: str,
        coords: Ints,
        scale: Floats,
        reference: Floats,
        section: Section | Floats,
        n_gauss: int,
        temperatures: Ints,
        expansion: Floats,
    ) -> None:
        super().__init__(name, coords, scale, reference, section, n_gauss)
        self.temperatures = temperatures
        a0, a1, a2 = np.asarray(expansion, float)
        resultants = np.array([np.concatenate([a0, -a1]), np.concatenate([a1, -a2])])
        local = np.asarray(np.linalg.solve(Section.of(section).by_element, resultants.T), float)
        tables = gauss_tables(self, section, n_gauss)
        self.parts = [HeatedPart(self, part, local, own[2]) for part, own in zip(tables, self.arguments, strict=True)]
        self.index_T, self.work_T = packed_indices(temperatures), aligned(8 * WIDTH)

    def acting_on(self, coordinates: Bools, numbering: Numbering | None) -> None:
        """None: temperatures change the constants of all elements."""

    def repeated(self, n: int, n_q: int) -> None:
        """None, as well."""

    def heat(self, q: Floats) -> None:
        """Count strains from the thermal strains of the temperatures in q."""
        for part in self.parts:
            part.heat(q, self.index_T, self.work_T)

    def force(self, t: float, q: Floats, v: Floats, f: Floats) -> None:
        """Elastic force dW/de."""
        self.heat(q)
        super().force(t, q, v, f)

    def force_tangent(
        self, t: float, q: Floats, v: Floats, alpha_q: float, alpha_v: float, q_previous: Floats, f: Floats, k: Floats
    ) -> None:
        """Elastic force and alpha_q d2W/de2."""
        self.heat(q)
        super().force_tangent(t, q, v, alpha_q, alpha_v, q_previous, f, k)

    def tangent(self) -> ShellTangent:
        """The tangent d2W/de2."""
        return _HeatedTangent(self, self.arguments, self._work, self.heat)

    def force_change(self, beside: Sequence[ForceBlock], weights: Sequence[float]) -> Force | None:
        """As the role says, with the thermal strains of the models beside."""
        same = [each for each in beside if type(each) is HeatedShellBlock and np.array_equal(each.index_T, self.index_T)]
        if len(same) != len(beside) or not all(comparable(self, other) for other in same):
            return None
        return _HeatedChange(self, same, weights)

    def energy(self, t: float, q: Floats) -> float:
        """Strain energy of s - s_T [J]."""
        self.heat(q)
        return super().energy(t, q)


class _HeatedTangent(ShellTangent):
    """That of a heated shell, whose resultants depend on the temperatures.

    Args:
        block, arguments, work: as for :class:`ShellTangent`.
        heat: gives the points of the block the temperatures in q.
    """

    def __init__(
        self, block: ShellBlock, arguments: Sequence[KernelArguments], work: Workspace, heat: Callable[[Floats], None]
    ) -> None:
        super().__init__(block, arguments, work)
        self._heat = heat

    def look(self, t: float, q: Floats, v: Floats, alpha_q: float, alpha_v: float) -> None:
        """Evaluate what all products at a point need."""
        self._heat(q)
        super().look(t, q, v, alpha_q, alpha_v)


class _HeatedChange(ReferenceChange):
    """The derivative of a heated shell's force: the references change with the temperatures, and their derivatives too.

    Args:
        block, beside, weights: as for :func:`lamella.element.plate48.beside.force_change`.
    """

    def __init__(self, block: HeatedShellBlock, beside: Sequence[HeatedShellBlock], weights: Sequence[float]) -> None:
        super().__init__(block, beside, weights, 0.0, elastic=True)
        self._own = block
        self._change = [
            part.weighed(others, weights, sections)
            for part, sections, *others in zip(block.parts, self.changes, *(other.parts for other in beside), strict=True)
        ]

    def _write(self, at: Place, kept: Sequence[Floats], f: Floats) -> None:
        q = at[0]
        self._own.heat(q)
        for part in self._change:
            part.heat(q, self._own.index_T, self._own.work_T)
        super()._write(at, kept, f)


class GaussPoints:
    """What blocks with temperatures share with the elastic block of their elements.

    Args:
        block: the elastic block.
        n_gauss: Gauss points in each direction.
    """

    def __init__(self, block: Plate48Block, n_gauss: int) -> None:
        self.n = n_gauss
        s = gauss_rule(n_gauss)[0]
        self.corners = np.stack([1.0 - s, s], axis=1).reshape(-1)
        self.index, self.scale, self.table = block._index, block._scale, hermite_table(n_gauss)
        self.work = aligned(kernels.thermal_work_size(n_gauss) * WIDTH)


class HeatedPart(GaussPoints):
    """Thermal strain and stress at the Gauss points of a part of a section.

    Args:
        block: the elastic block.
        tables: the part's tables.
        local: thermal strains s_T of the whole section for T_N = 1 and T_M = 1 in the local frame, shape (..., 6, 2).
        sections: the constants of the Gauss points that the block's kernels read.
    """

    def __init__(self, block: Plate48Block, tables: GaussTables, local: Floats, sections: Floats) -> None:
        super().__init__(block, tables.n)
        self.cubed: Cubed = tables.cubed
        transform = tables.transform
        strain = np.swapaxes(np.linalg.solve(transform, np.broadcast_to(local, (*transform.shape[:-2], 6, 2))), -1, -2)
        self.strain, self.stress = packed(np.asarray(strain, float)), packed(np.asarray(strain @ tables.stiffness, float))
        self._sections = sections
        self._cold = np.ascontiguousarray(sections.reshape(-1, N_SECTION, WIDTH)[:, 21:]).reshape(-1)

    def weighed(self, others: Sequence[HeatedPart], weights: Sequence[float], sections: Floats) -> HeatedPart:
        """The part whose tables are sums of those of others, with ``sections`` for its constants."""
        found = copy(self)
        found._sections = sections
        found._cold = weighed(weights, [other._cold for other in others])
        found.strain = weighed(weights, [other.strain for other in others])
        return found

    def heat(self, q: Floats, index: Ints, work: Floats) -> None:
        """Count strains from the thermal strain of the temperatures at ``index``."""
        kernels.set_reference(q, index, self.corners, self.n, self._cold, self.strain, work, self._sections)


class CrossBlock(ForceBlock):
    """A block with tangents between the shape of Plate48 elements (48 coordinates each) and their eight temperatures."""

    symmetry: Symmetry = "none"

    def __init__(self, name: str, elastic: Plate48Block, coords: Ints, temperatures: Ints) -> None:
        self.name = name
        order = product_order()
        shape = (len(coords), 8, 48)
        self._coords = packed_targets(np.broadcast_to(coords[:, None, order], shape).reshape(len(coords), -1))
        self._fields = packed_targets(np.broadcast_to(temperatures[:, :, None], shape).reshape(len(coords), -1))
        scale = np.broadcast_to(elastic.element_scale[:, None, :], shape)
        self.k_scale = packed(np.ascontiguousarray(scale).reshape(len(coords), -1))


class ThermalCouplingBlock(CrossBlock):
    """The derivative of a heated shell's force by its temperatures; the force itself is that of :class:`HeatedShellBlock`.

    Args:
        name: name of the body.
        shell: the heated shell.
        coords: global coordinates of each element, shape (n_element, 48).
    """

    def __init__(self, name: str, shell: HeatedShellBlock, coords: Ints) -> None:
        super().__init__(name, shell, coords, shell.temperatures)
        self.f_coords, self.f_scale = np.zeros(0, np.int64), np.zeros(0)
        self.k_rows, self.k_cols = self._coords, self._fields
        self._parts, self._k = shell.parts, aligned(self.k_rows.size if len(shell.parts) > 1 else 0)

    def force(self, t: float, q: Floats, v: Floats, f: Floats) -> None:
        """Nothing beyond the shell's own."""

    def force_tangent(
        self, t: float, q: Floats, v: Floats, alpha_q: float, alpha_v: float, q_previous: Floats, f: Floats, k: Floats
    ) -> None:
        """alpha_q df/dT."""
        first, *others = self._parts
        _thermal_tangent(first, q, alpha_q, k)
        for part in others:
            _thermal_tangent(part, q, alpha_q, self._k)
            k += self._k

    def energy(self, t: float, q: Floats) -> float:
        """That of the shell."""
        return 0.0


def _thermal_tangent(p: HeatedPart, q: Floats, alpha_q: float, k: Floats) -> None:
    kernels.thermal_tangent(q, p.index, p.scale, p.table, p.corners, p.n, p.cubed, p.stress, alpha_q, p.work, k)
