"""A structured grid of points on a compiled plate or shell, with all that does not depend on its coordinates."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from lamella.body.sample import PlateSample
from lamella.element.plate48.recovery import ShellRecovery
from lamella.roles import Floats

if TYPE_CHECKING:
    from lamella.body.mesh import PlateMesh


class Grid:
    """Points at given parameters of a mesh.

    Args:
        mesh: the plate or shell.
        xi: places along x, counted in elements from 0 to nx.
        eta: places along y, counted in elements from 0 to ny.
    """

    def __init__(self, mesh: PlateMesh, xi: Floats, eta: Floats) -> None:
        self._mesh, self._xi, self._eta = mesh, xi, eta
        i, j = np.minimum(xi.astype(int), mesh.nx - 1), np.minimum(eta.astype(int), mesh.ny - 1)
        self._element = (j[:, None] * mesh.nx + i[None, :]).reshape(-1)
        points_xi = np.broadcast_to(xi - i, (len(eta), len(xi))).reshape(-1)
        points_eta = np.broadcast_to((eta - j)[:, None], (len(eta), len(xi))).reshape(-1)
        section = mesh.section
        recovery = ShellRecovery(mesh.element, mesh.coords, mesh.scale, mesh.reference, section.direction, section.curvature)
        self._points = recovery.points(self._element, points_xi, points_eta)

    def positions(self, q: Floats) -> Floats:
        """Positions, shape (..., my, mx, 3), which are linear in q (..., n_q): those of rates are velocities."""
        return self._points.positions(q).reshape(*q.shape[:-1], len(self._eta), len(self._xi), 3)

    def sample(self, q: Floats) -> PlateSample:
        """Positions, normals and strains in the configuration ``q`` (n_q,), or in a stack of them (..., n_q)."""
        mesh = self._mesh
        found = self._points.at(q, None if mesh.turns is None else np.apply_along_axis(mesh.turns, -1, q))
        strains = found.strains
        if mesh.section.prestrain is not None:
            strains = strains + np.concatenate([mesh.section.prestrain, np.zeros(3)])
        shape = (*q.shape[:-1], len(self._eta), len(self._xi))
        heat: tuple[Floats, Floats] | tuple[()] = ()
        if mesh.temperature is not None:
            y, x = np.meshgrid(self._eta * mesh.ly, self._xi * mesh.lx, indexing="ij")
            source, places = mesh.temperature, (x.reshape(-1), y.reshape(-1))
            T_N, T_M = np.moveaxis(np.apply_along_axis(lambda one: np.stack(source.at(one, *places)), -1, q), -2, 0)
            heat = T_N.reshape(shape), T_M.reshape(shape)
        factors = mesh.thickness_factors
        return PlateSample(
            mesh.laminate,
            self._xi * mesh.lx,
            self._eta * mesh.ly,
            found.r.reshape(*shape, 3),
            found.n.reshape(*shape, 3),
            strains.reshape(*shape, 6),
            *heat,
            thickness_factors=1.0 if factors is None else factors[self._element].reshape(shape[-2:]),
        )
