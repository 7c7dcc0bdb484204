"""Small-deformation models of Plate48 shells with thermal strain: a constant thermal force beside the constant stiffness.

    W = 1/2 y.K0 y + y.G T + 1/2 T.S T,     p = dW/dy = K0 y + G T

with y as in :mod:`lamella.element.plate48.linear` or :mod:`lamella.element.plate48.frame` and G, S as in
:func:`thermal_matrices`. It is the strain energy of s - s_T in linear theory, the same function of temperature included.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from lamella.element.plate48.frame import FrameShellBlock
from lamella.element.plate48.frame_groups import FrameGroups
from lamella.element.plate48.framed_shape import FramedShape, framed_shape
from lamella.element.plate48.thermal_matrices import HeatedElements, thermal_matrices
from lamella.roles import Floats, ForceBlock, Ints, Symmetry


class LinearHeatBlock(ForceBlock):
    """What heat adds to a :class:`LinearShellBlock`: f = G T, W = (e - e_ref).G T + 1/2 T.S T.

    Args:
        elements: the elements and their temperatures.
    """

    symmetry: Symmetry = "none"
    varies = True

    def __init__(self, elements: HeatedElements) -> None:
        self.name, self._coords, self._temperatures = elements.name, elements.coords, elements.temperatures
        self._reference = np.asarray(elements.reference, float)
        self._G, self._S = thermal_matrices(elements)
        self.f_coords, self.f_scale = np.ascontiguousarray(elements.coords, np.int64).reshape(-1), np.ones(elements.coords.size)
        self.k_rows = np.broadcast_to(elements.coords[:, :, None], self._G.shape).reshape(-1)
        self.k_cols = np.broadcast_to(elements.temperatures[:, None, :], self._G.shape).reshape(-1)
        self.k_scale = np.ones(self._G.size)

    def force(self, t: float, q: Floats, v: Floats, f: Floats) -> None:
        """Thermal force G T."""
        np.matmul(self._G, q[self._temperatures][..., None], out=f.reshape(*self._coords.shape, 1))

    def force_tangent(
        self, t: float, q: Floats, v: Floats, alpha_q: float, alpha_v: float, q_previous: Floats, f: Floats, k: Floats
    ) -> None:
        """Thermal force and alpha_q G."""
        self.force(t, q, v, f)
        np.multiply(self._G.reshape(-1), alpha_q, out=k)

    def energy(self, t: float, q: Floats) -> float:
        """What heat adds to the strain energy [J]."""
        T = q[self._temperatures][..., None]
        return float(np.vdot(q[self._coords] - self._reference, self._G @ T) + 0.5 * np.vdot(T, self._S @ T))


@dataclass(frozen=True)
class GroupHeat:
    """Thermal matrices of groups that share a frame, in the axes of the reference's frames.

    Args:
        temperatures: coordinate of each temperature, shape (n_group, n_T).
        G: thermal forces, shape (n_group, 3 n, n_T).
        S: thermal energies, shape (n_group, n_T, n_T).
    """

    temperatures: Ints
    G: Floats
    S: Floats


def group_heat(elements: HeatedElements, groups: FrameGroups) -> GroupHeat:
    """Sum the thermal matrices of the elements of each group: all of them, or one each."""
    g, n = groups.coords.shape[:2]
    members = np.arange(len(elements.coords)).reshape(g, -1)
    temperatures = np.stack([np.unique(elements.temperatures[own]) for own in members])
    G = np.zeros((g, 3 * n, temperatures.shape[1]))
    S = np.zeros((g, temperatures.shape[1], temperatures.shape[1]))
    forces, energies = thermal_matrices(elements)
    for k, own in enumerate(members):
        coords = groups.coords[k].reshape(-1)
        order = np.argsort(coords)
        for e in own:
            rows = order[np.searchsorted(coords, elements.coords[e], sorter=order)]
            columns = np.searchsorted(temperatures[k], elements.temperatures[e])
            G[k][rows[:, None], columns] += forces[e]
            S[k][columns[:, None], columns] += energies[e]
    rest = np.zeros(int(elements.coords.max()) + 1)
    rest[elements.coords] = elements.reference
    R = framed_shape(groups, rest).R
    turned = R.swapaxes(1, 2)[:, None] @ G.reshape(g, n, 3, -1)
    return GroupHeat(temperatures, np.ascontiguousarray(turned).reshape(G.shape), S)


class HeatedFrameBlock(FrameShellBlock):
    """A shell in moving frames with thermal strain: force and tangent of :class:`FrameShellBlock` with p = K0 y + G T.

    Args:
        name: name of the body.
        groups: the groups.
        heat: their thermal matrices.
    """

    varies = True

    def __init__(self, name: str, groups: FrameGroups, heat: GroupHeat) -> None:
        super().__init__(name, groups)
        self.heat = heat

    def energy(self, t: float, q: Floats) -> float:
        """Strain energy of s - s_T [J]."""
        at, T = framed_shape(self.groups, q), q[self.heat.temperatures][..., None]
        thermal = self._thermal(at, q)
        return float(np.vdot(at.y, 0.5 * self._elastic(at) + thermal) + 0.5 * np.vdot(T, self.heat.S @ T))

    def _inner_force(self, at: FramedShape, q: Floats) -> Floats:
        return self._elastic(at) + self._thermal(at, q)

    def _thermal(self, at: FramedShape, q: Floats) -> Floats:
        return (self.heat.G @ q[self.heat.temperatures][..., None]).reshape(at.y.shape)


class FrameHeatBlock(ForceBlock):
    """The derivative of a :class:`HeatedFrameBlock`'s force by its temperatures: for T_j = 1, with G_k of that column,

        R (G_k + sum_i w_ik e_i x J^-1 sum_l y_l x G_l)

    as y does not depend on temperature.

    Args:
        shell: the heated shell.
    """

    symmetry: Symmetry = "none"

    def __init__(self, shell: HeatedFrameBlock) -> None:
        self.name, self._groups, self._heat = shell.name, shell.groups, shell.heat
        coords, G = shell.groups.coords, shell.heat.G
        self.f_coords, self.f_scale = np.zeros(0, np.int64), np.zeros(0)
        self.k_rows = np.broadcast_to(coords.reshape(len(coords), -1, 1), G.shape).reshape(-1)
        self.k_cols = np.broadcast_to(shell.heat.temperatures[:, None, :], G.shape).reshape(-1)
        self.k_scale = np.ones(G.size)

    def force(self, t: float, q: Floats, v: Floats, f: Floats) -> None:
        """Nothing beyond the shell's own."""

    def force_tangent(
        self, t: float, q: Floats, v: Floats, alpha_q: float, alpha_v: float, q_previous: Floats, f: Floats, k: Floats
    ) -> None:
        """alpha_q df/dT."""
        at, G = framed_shape(self._groups, q), self._heat.G
        inner = (G + at.turning.swapaxes(1, 2) @ (at.y_cross.swapaxes(1, 2) @ G)).reshape(*at.y.shape, -1)
        k[:] = (alpha_q * at.R[:, None] @ inner).reshape(-1)

    def energy(self, t: float, q: Floats) -> float:
        """That of the shell."""
        return 0.0
