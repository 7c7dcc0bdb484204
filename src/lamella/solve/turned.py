"""Solutions by a factorisation that was made before the structure turned."""

from __future__ import annotations

from collections.abc import Sequence
from math import cos, sin, sqrt
from typing import TYPE_CHECKING

import numpy as np

from lamella._jit import kernel
from lamella.roles import Floats, Ints
from lamella.solve.base import LinearSolver

if TYPE_CHECKING:
    from lamella.assembly.equations import Equations
    from lamella.body.mesh import PlateMesh

MOST_LEFT = 0.25
"""Share of the slopes' change, in squares, that a rotation may leave; a strip that bends in its first mode leaves 0.2."""
PASSES = 20
"""Most corrections of the rotation; four suffice for half a radian."""
SETTLED = 1e-7
"""Correction of the rotation [rad] that is the last one."""


class Vectors:
    """Where the coordinate vectors of a system stand among its independent coordinates.

    Args:
        equations: the equations of a model.

    Attributes:
        rows: the independent coordinates of each vector, -1 where a component depends on others or is held, shape (n, 3).
        slopes: those of vectors that are whole and no positions, shape (m, 3).
        nodes: those of plates, each of which turns by itself; None where constraints have multipliers, which turn with no node.
    """

    def __init__(self, equations: Equations) -> None:
        vector, component = np.divmod(equations.elimination.independent[: equations.n_motion], 3)
        chosen, place = np.unique(vector, return_inverse=True)
        self.rows: Ints = np.full((len(chosen), 3), -1)
        self.rows[place, component] = np.arange(len(vector))
        whole = np.all(self.rows >= 0, axis=1)
        self.slopes: Ints = self.rows[whole & ~equations.model.is_position[chosen]]
        self.nodes = None if equations.n_lam else Nodes(equations)


class Nodes:
    """Where the nodes of plates stand among the independent coordinates; only those with both slopes there.

    Args:
        equations: the equations of a model.

    Attributes:
        slopes: first coordinate of r_x and of r_y of each node, shape (n_node, 2).
        places: first coordinate of each of their vectors that is whole, in order, shape (n_vector,).
        owners: the node of each, shape (n_vector,).
        others: all other independent coordinates of motion.
        n_motion: number of independent coordinates of motion; those of fields lie behind them, unless they are left out.
        slenderness: L (tr A / tr D)^(1/2) of the most slender plate, with its length L, membrane stiffness A and bending
            stiffness D: 12^(1/2) L/h of one material.
    """

    def __init__(self, equations: Equations) -> None:
        independent = equations.elimination.independent
        slopes, places, owners, count = [np.zeros((0, 2), np.int64)], [np.zeros(0, np.int64)], [np.zeros(0, np.int64)], 0
        for plate in equations.model.plates:
            per_node = plate.element.vectors_per_node
            coords = 3 * (plate.first + np.arange(per_node * plate.n_nodes)).reshape(-1, per_node)
            at = np.searchsorted(independent, coords)
            first, last = (independent[np.minimum(at + c, len(independent) - 1)] for c in (0, 2))
            whole = (first == coords) & (last == coords + 2)
            pair = [plate.element.vector_names.index(name) for name in ("r_x", "r_y")]
            turning = np.all(whole[:, pair], axis=1)
            number = count + np.cumsum(turning) - 1
            chosen = whole & turning[:, None]
            slopes.append(at[turning][:, pair])
            places.append(at[chosen])
            owners.append(np.broadcast_to(number[:, None], chosen.shape)[chosen])
            count += int(np.count_nonzero(turning))
        self.slenderness = max((_slenderness(plate) for plate in equations.model.plates), default=0.0)
        self.slopes, places, owners = (np.concatenate(parts) for parts in (slopes, places, owners))
        order = np.argsort(places)
        self.places, self.owners = places[order], owners[order]
        self.n_motion = equations.n_motion
        self.others = np.setdiff1d(np.arange(self.n_motion), self.places[:, None] + np.arange(3))


def _slenderness(plate: PlateMesh) -> float:
    A, D = (np.trace(plate.section.stiffness[..., part, part], axis1=-2, axis2=-1).mean() for part in (slice(3), slice(3, 6)))
    return float(max(plate.size) * np.sqrt(A / D))


class TurnedSolver(LinearSolver):
    """A solver whose factorisation of A(u) serves for A(u') too, where u' is u turned as a whole by R, and a little more:

        A(u')^-1 = Q A(u)^-1 Q^T,    Q = diag(R, ..., R, 1, ..., 1)

    Elastic, viscous and inertial forces turn with the structure, f(Q q, Q v) = Q f(q, v), so their tangents do. Coordinates are
    vectors in space: without Q a plate of length L and thickness h that has turned by an angle theta seems stiffer by the order
    of 12 (L theta / h)^2, and after a hundredth of a radian the factorisation is of no use. R is the rotation that brings the
    slopes of u nearest to those of u'; where it leaves too much, as between panels that unfold, there is none.

    Components that do not move freely are left out of Q. Multipliers stay as they are: constraints between parts that turn
    together do not see the rotation, and those to the ground are off by the order of theta.

    Args:
        linear: the solver.
        vectors: of the equations to be solved.
    """

    def __init__(self, linear: LinearSolver, vectors: Vectors) -> None:
        self.linear, self.pattern, self._vectors = linear, linear.pattern, vectors
        self._R, self._back, self._turned = np.eye(3), np.eye(3), False
        self._at: Floats | None = None

    @property
    def negative_pivots(self) -> int | None:
        """Number of negative eigenvalues, which no rotation changes."""
        return self.linear.negative_pivots

    @property
    def work_per_entry(self) -> float:
        """Of the solver."""
        return self.linear.work_per_entry

    def factorise(self, k: Floats, j: Floats) -> None:
        """Factorise the matrix; see :meth:`made_at`."""
        self._at, self._turned = None, False
        self.linear.factorise(k, j)

    def made_at(self, u: Floats) -> None:
        """Take note of the independent coordinates at which the present factorisation was made."""
        self._at, self._turned = u, False

    def shorten(self, singles: bool = True) -> None:
        """Solve roughly from now on."""
        self.linear.shorten(singles)

    def turn(self, u: Floats) -> None:
        """Turn the factorisation, whose place is known, to the independent coordinates ``u``, and shorten it."""
        assert self._at is not None, "made_at follows each factorisation"
        self.linear.shorten()
        self._turned = bool(_fit(self._vectors.slopes, self._at, u, self._R))
        self._back[:] = self._R.T

    def solve(self, r: Floats, s: Floats) -> tuple[Floats, Floats]:
        """Solution for the present place."""
        if not self._turned:
            return self.linear.solve(r, s)
        x, y = self.linear.solve(self._back_to_old(r), s)
        return self._to_new(x), y

    def solve_each(self, rights: Sequence[tuple[Floats, Floats]]) -> list[tuple[Floats, Floats]]:
        """Several solutions for the present place."""
        if not self._turned:
            return self.linear.solve_each(rights)
        found = self.linear.solve_each([(self._back_to_old(r), s) for r, s in rights])
        return [(self._to_new(x), y) for x, y in found]

    def _back_to_old(self, r: Floats) -> Floats:
        """Q^T r."""
        there = np.empty_like(r)
        _rotate(self._back, self._vectors.rows, r, there)
        return there

    def _to_new(self, x: Floats) -> Floats:
        """Q x."""
        there = np.empty_like(x)
        _rotate(self._R, self._vectors.rows, x, there)
        return there


@kernel
def _rotate(R: Floats, rows: Ints, x: Floats, y: Floats) -> None:
    """y = Q x; components that are left out count as zero."""
    for i in range(len(x)):
        y[i] = x[i]
    for k in range(len(rows)):
        for c in range(3):
            if rows[k, c] >= 0:
                total = 0.0
                for d in range(3):
                    if rows[k, d] >= 0:
                        total += R[c, d] * x[rows[k, d]]
                y[rows[k, c]] = total


@kernel
def _fit(slopes: Ints, old: Floats, new: Floats, R: Floats) -> bool:
    """R <- the rotation that minimises sum |b - R a|^2 over the slopes a of ``old`` and b of ``new``, by Gauss and Newton:

        R <- exp(w) R,    sum (|R a|^2 1 - R a (R a)^T) w = sum R a x b

    Returns:
        Whether the slopes have changed, and what the rotation leaves is small beside that.
    """
    for c in range(3):
        for d in range(3):
            R[c, d] = 1.0 if c == d else 0.0
    moved = 0.0
    for turn in range(PASSES):
        xx = xy = xz = yy = yz = zz = mx = my = mz = left = 0.0
        for k in range(len(slopes)):
            i, j, m = slopes[k, 0], slopes[k, 1], slopes[k, 2]
            x = R[0, 0] * old[i] + R[0, 1] * old[j] + R[0, 2] * old[m]
            y = R[1, 0] * old[i] + R[1, 1] * old[j] + R[1, 2] * old[m]
            z = R[2, 0] * old[i] + R[2, 1] * old[j] + R[2, 2] * old[m]
            left += (new[i] - x) ** 2 + (new[j] - y) ** 2 + (new[m] - z) ** 2
            xx += y * y + z * z
            yy += x * x + z * z
            zz += x * x + y * y
            xy -= x * y
            xz -= x * z
            yz -= y * z
            mx += y * new[m] - z * new[j]
            my += z * new[i] - x * new[m]
            mz += x * new[j] - y * new[i]
        if turn == 0:
            moved = left
        elif not left <= MOST_LEFT * moved:
            return False
        cx, cy, cz = yy * zz - yz * yz, xz * yz - xy * zz, xy * yz - xz * yy
        det = xx * cx + xy * cy + xz * cz
        if not det > 1e-12 * xx * yy * zz:  # slopes along one line do not tell how it turns about itself
            return False
        wx = (cx * mx + cy * my + cz * mz) / det
        wy = (cy * mx + (xx * zz - xz * xz) * my + (xy * xz - xx * yz) * mz) / det
        wz = (cz * mx + (xy * xz - xx * yz) * my + (xx * yy - xy * xy) * mz) / det
        angle = sqrt(wx * wx + wy * wy + wz * wz)
        if angle > 0.0:
            wx, wy, wz = wx / angle, wy / angle, wz / angle
        s, c1 = sin(angle), 1.0 - cos(angle)
        for d in range(3):  # each column v <- v + sin w x v + (1 - cos) w x (w x v)
            x, y, z = R[0, d], R[1, d], R[2, d]
            along = wx * x + wy * y + wz * z
            R[0, d] = x + s * (wy * z - wz * y) + c1 * (wx * along - x)
            R[1, d] = y + s * (wz * x - wx * z) + c1 * (wy * along - y)
            R[2, d] = z + s * (wx * y - wy * x) + c1 * (wz * along - z)
        if turn > 0 and angle < SETTLED:
            return True
    return False
