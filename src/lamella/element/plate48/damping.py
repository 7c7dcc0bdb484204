"""Damping of Plate48 shells: Kelvin-Voigt on the strains, and mass-proportional."""

from __future__ import annotations

from collections.abc import Sequence
from typing import ClassVar

import numpy as np
from scipy.sparse import csr_array

from lamella.element.block import Range
from lamella.element.plate48 import damping_kernels as kernels
from lamella.element.plate48.beside import force_change
from lamella.element.plate48.damping_symmetric import symmetric_tangent, work_size
from lamella.element.plate48.entries import all_entries, upper_entries
from lamella.element.plate48.kernels import energy as elastic_energy
from lamella.element.plate48.layout import KernelArguments, Plate48Block, gauss_tables, seen
from lamella.element.plate48.matrix_free import ShellTangent
from lamella.element.plate48.section import Section
from lamella.inertia import of_components
from lamella.lane import WIDTH, aligned
from lamella.numbering import Numbering
from lamella.roles import Bools, Floats, Force, ForceBlock, InertiaBlock, Ints, MatrixFreeBlock, Symmetry
from lamella.threads import Workspace

FORCE, TANGENT, SYMMETRIC_TANGENT = 60e-9, 0.8e-6, 0.4e-6
"""Seconds that force and tangents take for a Gauss point of an element."""


class KelvinVoigtBlock(Plate48Block):
    """Viscous resultants c C dE/dt on the strains E = (eps, kap) of the section's definition: f = int (dE/dq)^T c C dE/dt dA.

    Rigid motion has no strain rate, so it is not damped. The tangent is not symmetric, but its unsymmetric part is small.

    Args:
        name: name of the body, for messages.
        coords: global coordinates of each element in element order, shape (n_element, 48).
        scale: factors from global to element coordinates, shape (n_element, 48).
        reference: unscaled stress-free coordinates, shape (n_element, 48).
        section: the section as in :class:`ShellBlock`, with the elastic stiffness.
        time: retardation time c [s].
        n_gauss: Gauss points in each direction.

    Raises:
        ModelError: shapes do not agree, or the reference surface has no area.
    """

    symmetry: Symmetry = "nearly"
    depends_on_velocity = linear_in_velocity = True
    elastic: ClassVar[bool] = False
    """Whether the elastic force is added."""

    def __init__(
        self, name: str, coords: Ints, scale: Floats, reference: Floats, section: Section | Floats, time: float, n_gauss: int = 4
    ) -> None:
        super().__init__(name, coords, scale, reference, *all_entries())
        self.time, self.arguments = time, self.kernel_arguments(gauss_tables(self, section, n_gauss))
        self._work = Workspace(kernels.viscous_work_size(n_gauss) * WIDTH)
        self._n_gauss = n_gauss
        self._make_buffers()

    def _make_buffers(self) -> None:
        self._power = aligned(self.n_block * WIDTH)
        self._unused, self._energies = np.zeros(len(self.f_coords)), aligned(self.n_block * WIDTH)
        if len(self.arguments) > 1:
            self._f, self._k, self._part_power = aligned(self.f_coords.size), aligned(self.n_k), self._power.copy()
        self._symmetric_form = SymmetricDampingBlock(self, self.arguments, self._n_gauss)

    def force(self, t: float, q: Floats, v: Floats, f: Floats) -> None:
        """Viscous force, with the elastic one if that is added."""
        self._force(q, v, f, elastic=self.elastic)

    def damping_force(self, t: float, q: Floats, v: Floats, f: Floats) -> None:
        """Viscous force."""
        self._force(q, v, f, elastic=False)

    def _force(self, q: Floats, v: Floats, f: Floats, *, elastic: bool) -> None:
        self._viscous_force(self.arguments[0], q, v, elastic, f, self._power)
        for arguments in self.arguments[1:]:
            self._viscous_force(arguments, q, v, elastic, self._f, self._part_power)
            f += self._f
            self._power += self._part_power

    def _viscous_force(self, arguments: KernelArguments, q: Floats, v: Floats, elastic: bool, f: Floats, power: Floats) -> None:
        def call(blocks: Range) -> None:
            own = seen(arguments, blocks)
            kernels.viscous_force(q, v, self.time, elastic, *own, self._work.array, blocks.of(f), blocks.of(power))

        self.over_blocks(FORCE * arguments[4] ** 2, call)

    def force_tangent(
        self, t: float, q: Floats, v: Floats, alpha_q: float, alpha_v: float, q_previous: Floats, f: Floats, k: Floats
    ) -> None:
        """Viscous force and its exact tangent."""
        self.force(t, q, v, f)
        how = q_previous, q_previous is not q, alpha_q, alpha_v
        self._viscous_tangent(self.arguments[0], q, v, how, k)
        for arguments in self.arguments[1:]:
            self._viscous_tangent(arguments, q, v, how, self._k)
            k += self._k

    def _viscous_tangent(
        self, arguments: KernelArguments, q: Floats, v: Floats, how: tuple[Floats, bool, float, float], k: Floats
    ) -> None:
        def call(blocks: Range) -> None:
            own = seen(arguments, blocks)
            kernels.viscous_tangent(q, v, *how, self.time, self.elastic, *own, self._work.array, blocks.of(k))

        self.over_blocks(TANGENT * arguments[4] ** 2, call)

    def force_change(self, beside: Sequence[ForceBlock], weights: Sequence[float]) -> Force | None:
        """As the role says; not by the retardation time."""
        same = [each for each in beside if isinstance(each, type(self)) and each.time == self.time]
        return force_change(self, same, weights, self.time, self.elastic) if len(same) == len(beside) else None

    def tangent(self) -> ShellTangent:
        """The exact tangent."""
        return ShellTangent(self, self.arguments, self._work, self.time, self.elastic)

    @property
    def symmetric_form(self) -> MatrixFreeBlock:
        """The same force with a symmetric tangent."""
        return self._symmetric_form

    def energy(self, t: float, q: Floats) -> float:
        """No potential."""
        return 0.0

    def dissipation(self, t: float, q: Floats, v: Floats) -> float:
        """Power int dE/dt . c C dE/dt dA [W]."""
        self.force(t, q, v, self._unused)
        return float(self._power[: self.n_element].sum())


class SymmetricDampingBlock(MatrixFreeBlock):
    """The force of a :class:`KelvinVoigtBlock`, with a symmetric tangent that costs as much as an elastic one.

    Args:
        whole: the block, whose tangent is not symmetric.
        arguments: of the kernels, for each part of the section.
        n_gauss: Gauss points in each direction.
    """

    depends_on_velocity = linear_in_velocity = True

    def __init__(self, whole: KelvinVoigtBlock, arguments: list[KernelArguments], n_gauss: int) -> None:
        self.name, self._whole, self.arguments = whole.name, whole, arguments
        self.f_coords, self.f_scale = whole.f_coords, whole.f_scale
        self._work = Workspace(work_size(n_gauss) * WIDTH)
        self._more = aligned(self.f_coords.size), aligned(whole.n_block * len(upper_entries()[0]) * WIDTH * (len(arguments) > 1))

    @property
    def k_rows(self) -> Ints:  # pyright: ignore[reportIncompatibleVariableOverride]
        """Global coordinate of the row of each entry of the upper triangle, shape (n_k,)."""
        return self._whole.targets_of(upper_entries()[0])

    @property
    def k_cols(self) -> Ints:  # pyright: ignore[reportIncompatibleVariableOverride]
        """The same of its column."""
        return self._whole.targets_of(upper_entries()[1])

    @property
    def k_scale(self) -> Floats:  # pyright: ignore[reportIncompatibleVariableOverride]
        """Factor of each entry, shape (n_k,)."""
        return self._whole.scale_of(*upper_entries())

    @property
    def depends_on_time_alone(self) -> bool:
        """False."""
        return False

    def force(self, t: float, q: Floats, v: Floats, f: Floats) -> None:
        """As the whole block."""
        self._whole.force(t, q, v, f)

    def damping_force(self, t: float, q: Floats, v: Floats, f: Floats) -> None:
        """As the whole block."""
        self._whole.damping_force(t, q, v, f)

    def force_tangent(
        self, t: float, q: Floats, v: Floats, alpha_q: float, alpha_v: float, q_previous: Floats, f: Floats, k: Floats
    ) -> None:
        """Force and symmetric tangent."""
        first, *others = self.arguments
        how = q_previous, q_previous is not q, alpha_q, alpha_v, self._whole.time, self._whole.elastic
        self._force_tangent(first, q, v, how, f, k)
        for arguments in others:
            self._force_tangent(arguments, q, v, how, *self._more)
            f += self._more[0]
            k += self._more[1]

    def _force_tangent(
        self,
        arguments: KernelArguments,
        q: Floats,
        v: Floats,
        how: tuple[Floats, bool, float, float, float, bool],
        f: Floats,
        k: Floats,
    ) -> None:
        def call(blocks: Range) -> None:
            symmetric_tangent(q, v, *how, *seen(arguments, blocks), self._work.array, blocks.of(f), blocks.of(k))

        self._whole.over_blocks(SYMMETRIC_TANGENT * arguments[4] ** 2, call)

    def acting_on(self, coordinates: Bools, numbering: Numbering | None) -> MatrixFreeBlock | None:
        """As the whole block."""
        part = self._whole.acting_on(coordinates, numbering)
        return part and part.symmetric_form

    def repeated(self, n: int, n_q: int) -> MatrixFreeBlock | None:
        """As the whole block."""
        several = self._whole.repeated(n, n_q)
        return several and several.symmetric_form

    def force_change(self, beside: Sequence[ForceBlock], weights: Sequence[float]) -> Force | None:
        """As the whole block."""
        same = [each._whole for each in beside if isinstance(each, SymmetricDampingBlock)]
        return self._whole.force_change(same, weights) if len(same) == len(beside) else None

    def tangent(self) -> ShellTangent:
        """That of the whole block."""
        return self._whole.tangent()

    def energy(self, t: float, q: Floats) -> float:
        """As the whole block."""
        return self._whole.energy(t, q)

    def dissipation(self, t: float, q: Floats, v: Floats) -> float:
        """As the whole block."""
        return self._whole.dissipation(t, q, v)


class DampedShellBlock(KelvinVoigtBlock):
    """Elastic shell with Kelvin-Voigt damping: :class:`ShellBlock` and :class:`KelvinVoigtBlock` in one.

    It costs little more than the second alone; the arguments are those of the second.
    """

    elastic = True

    def energy(self, t: float, q: Floats) -> float:
        """Strain energy [J]."""
        total = 0.0
        for arguments in self.arguments:
            elastic_energy(q, *arguments, self._work.array, self._energies)
            total += float(self._energies[: self.n_element].sum())
        return total


class MassDampingBlock(ForceBlock):
    """Force c M v, which damps every motion, rigid motion too.

    Args:
        name: name of the body, for messages.
        inertia: gives M.
        rate: c [1/s].
    """

    depends_on_velocity = linear_in_velocity = True

    def __init__(self, name: str, inertia: InertiaBlock, rate: float) -> None:
        self.name = name
        rows, columns, values = of_components(*inertia.mass())
        self.f_coords = np.unique(rows)
        local = (np.searchsorted(self.f_coords, rows), np.searchsorted(self.f_coords, columns))
        self._matrix = csr_array((rate * values, local), shape=(len(self.f_coords), len(self.f_coords)))
        upper = rows <= columns
        self.k_rows, self.k_cols, self._values = rows[upper], columns[upper], rate * values[upper]
        self.f_scale, self.k_scale = np.ones(len(self.f_coords)), np.ones(len(self.k_rows))

    def force(self, t: float, q: Floats, v: Floats, f: Floats) -> None:
        """The force c M v."""
        f[:] = self._matrix @ v[self.f_coords]

    def force_tangent(
        self, t: float, q: Floats, v: Floats, alpha_q: float, alpha_v: float, q_previous: Floats, f: Floats, k: Floats
    ) -> None:
        """The force and alpha_v c M."""
        self.force(t, q, v, f)
        np.multiply(self._values, alpha_v, out=k)

    def energy(self, t: float, q: Floats) -> float:
        """No potential."""
        return 0.0

    def dissipation(self, t: float, q: Floats, v: Floats) -> float:
        """Power c v . M v [W]."""
        own = v[self.f_coords]
        return float(own @ (self._matrix @ own))
