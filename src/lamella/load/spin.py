"""A system described in a frame that rotates steadily."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

import numpy as np
from scipy import sparse

from lamella.declaration import declaration
from lamella.errors import DeclarationError
from lamella.inertia import vector_mass
from lamella.roles import Declaration, Floats, ForceBlock
from lamella.units import AngularVelocity, Length

if TYPE_CHECKING:
    from lamella.dofs import Build


@declaration
class SteadySpin(Declaration):
    """The whole system is described in a frame that rotates with a constant angular velocity about an axis.

    In that frame a resting system feels the centrifugal force -M (Omega x (Omega x r)), exactly: with absolute coordinates the
    mass matrix is m x 1 for vectors in space, and the force is linear in them. Supports, grounds and loads of fixed direction
    turn with the frame. Statics scales the force by the load factor, so that the speed grows with its square root; :func:`modes`
    about the spun state has the Coriolis force as well, and gives frequencies as seen from the frame. Motion is not available.

    Args:
        name: unique name.
        angular_velocity: Omega [rad/s].
        centre: a point of the axis [m].
    """

    order: ClassVar[int] = 2
    name: str
    angular_velocity: tuple[AngularVelocity, AngularVelocity, AngularVelocity]
    centre: tuple[Length, Length, Length] = (0.0, 0.0, 0.0)

    def __post_init__(self) -> None:
        if not np.isfinite(self.angular_velocity).all() or not np.any(self.angular_velocity):
            raise DeclarationError(
                f"SteadySpin '{self.name}'", f"angular_velocity = {self.angular_velocity} rad/s", "accepted is one other than 0"
            )

    def contribute(self, build: Build) -> None:
        """Add the centrifugal force on all bodies numbered in the build, and tell the build of the frame."""
        if build.spin is not None:
            raise DeclarationError(f"SteadySpin '{self.name}'", "the system spins already", "accepted is one steady spin")
        build.spin = np.asarray(self.angular_velocity)
        if not build.inertias:
            return
        square = np.outer(build.spin, build.spin) - (build.spin @ build.spin) * np.eye(3)  # Omega x (Omega x r) = square r
        stiffness = sparse.csr_array(sparse.kron(vector_mass(build.inertias, build.n_vectors), square))
        centre = np.outer(np.concatenate(build.is_position), self.centre).reshape(-1)
        build.loads.append(CentrifugalBlock(self.name, stiffness, stiffness @ centre))


class CentrifugalBlock(ForceBlock):
    """f = K q - f_0 with the constant symmetric matrix K = M (1 x Omega~ Omega~), negative semi-definite.

    Args:
        name: the declaration's name.
        stiffness: K, sparse (n, n).
        offset: f_0 = K c with the axis's point c in every position, shape (n,).
    """

    def __init__(self, name: str, stiffness: sparse.csr_array, offset: Floats) -> None:
        self.name, self._K, self._offset = name, stiffness, offset
        n = len(stiffness.indptr) - 1
        upper = sparse.coo_array(sparse.triu(stiffness))
        self._values = upper.data
        self.f_coords, self.f_scale = np.arange(n), np.ones(n)
        self.k_rows, self.k_cols = upper.row.astype(np.int64), upper.col.astype(np.int64)
        self.k_scale = np.ones(len(self._values))

    def force(self, t: float, q: Floats, v: Floats, f: Floats) -> None:
        f[:] = self._K @ q[: len(f)] - self._offset

    def force_tangent(
        self, t: float, q: Floats, v: Floats, alpha_q: float, alpha_v: float, q_previous: Floats, f: Floats, k: Floats
    ) -> None:
        self.force(t, q, v, f)
        np.multiply(self._values, alpha_q, out=k)

    def energy(self, t: float, q: Floats) -> float:
        """Centrifugal potential -1/2 int |Omega x r|^2 dm, less a constant [J]."""
        own = q[: len(self._offset)]
        moved = own @ (self._K @ own) - 2.0 * own @ self._offset
        return 0.5 * float(moved)
