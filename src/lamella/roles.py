"""The contracts between physics and solution: what a body, joint or load must provide, and nothing else.

The equations of motion of every system are

    M a + f(t, q, v) + Phi_q(t, q)^T lam = 0,      Phi(t, q) = 0

with one vector of absolute coordinates q, one constant mass matrix M and the residual force f = f_int - f_ext. A *block* is all
items of one kind, held as arrays; it writes its part of f and of the tangent into a buffer of its own, and tells once, at
compilation, to which coordinate each entry of the buffer belongs. The assembly sums the buffers through one precomputed sparse
operator, which also eliminates constrained coordinates, so no block knows of numbering, sparsity or constraints.

All coordinates are components of vectors in the inertial frame (positions, slopes, directors), three to a vector: coordinate
``3 k + c`` is component c of vector k. A rigid translation changes the vectors that are positions, a rotation turns all of them.
Behind the vectors lie the values of scalar fields (temperatures). They have no inertia: their rows of f are first-order equations
of the fields and their rates.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from typing import TYPE_CHECKING, ClassVar, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from lamella.memory import Memory

if TYPE_CHECKING:
    from lamella.dofs import Build
    from lamella.numbering import Numbering

Floats = NDArray[np.float64]
Singles = NDArray[np.float32]
Reals = Floats | Singles
Ints = NDArray[np.int64]
Bools = NDArray[np.bool_]
Indices = NDArray[np.int32]
"""Places in long arrays, kept short because reading them takes as long as what is done there."""

Symmetry = Literal["symmetric", "nearly", "none"]
"""Tangent of a block: ``symmetric`` (the block lists its upper triangle only), ``nearly`` (all entries listed; Newton may use a
symmetric matrix instead) or ``none`` (all entries listed; an unsymmetric solver is needed)."""


class Declaration(ABC):
    """Something a user adds to a system.

    1. It is frozen data with a ``name`` that is unique in its system.
    2. ``contribute`` is called once at compilation, bodies first, then the others in the order they were added.
    3. ``contribute`` changes nothing but the build it is given; compiling twice gives the same model.
    4. Errors name the declaration, the value and what would be accepted.
    """

    name: str
    order: ClassVar[int] = 1
    """Declarations contribute in ascending order: 0 bodies, 1 everything that refers to bodies."""
    python_only: ClassVar[bool] = False
    """Whether it holds Python functions, which no model file can: nothing in a model file is executed."""

    @abstractmethod
    def contribute(self, build: Build) -> None:
        """Add coordinates, blocks, constraints and signals to the build."""


class TangentTables(NamedTuple):
    """Tangent entries of elements that are all alike, ``WIDTH`` at a time: entry e of an element couples its coordinates
    ``rows[e]`` and ``columns[e]``; the buffer is (block, entry, WIDTH), flat.

    Args:
        coords: global coordinates of the elements, -1 for those that only fill up, (block, coordinate, WIDTH), flat.
        scale: their factors, as ``coords``.
        rows, columns: shapes (n_entry,).
        n: coordinates of an element.
    """

    coords: Ints
    scale: Floats
    rows: Ints
    columns: Ints
    n: int


class Force(ABC):
    """What writes forces at the coordinates ``f_coords`` (n_f,), -1 for padding, with the factors ``f_scale`` (n_f,) in a sum."""

    f_coords: Ints
    f_scale: Floats

    @abstractmethod
    def force(self, t: float, q: Floats, v: Floats, f: Floats) -> None:
        """Write the force buffer ``f`` (n_f,)."""

    @property
    def depends_on_time_alone(self) -> bool:
        """Whether it is the same for all states at one time, so that it is evaluated once for each time."""
        return False


class ForceChange(Force):
    """The derivative of a force f(t, q, v; p) by a parameter p, at the price of little more than the force."""

    @abstractmethod
    def along(
        self, t: float, q: Floats, v: Floats, dq: Floats, dv: Floats, f: Floats, looking: TangentOperator | None = None
    ) -> bool:
        """Write df/dp + df/dq dq + df/dv dv to the force buffer ``f`` (n_f,): coordinates and velocities follow the parameter.

        Args:
            t, q, v, dq, dv, f: see above.
            looking: an operator with the tangent of the block, if there is one that would look at (q, v) next, with alpha_q = 1.

        Returns:
            Whether it need not look any more.
        """

    @abstractmethod
    def energy(self, t: float, q: Floats, dq: Floats) -> tuple[float, float]:
        """The block's potential W [J], and dW/dp + dW/dq dq [J per unit of p]: coordinates follow the parameter."""


class ForceBlock(Memory, Force):
    """Forces that depend on time, position and velocity, with their tangent.

    1. ``f_coords`` (n_f,) holds the global coordinate of each entry of the force buffer, -1 for padding; ``f_scale`` (n_f,) the
       factor with which the entry enters the sum.
    2. ``k_rows, k_cols, k_scale`` (n_k,): the same for the tangent. A ``symmetric`` block lists each off-diagonal pair once.
       ``k_tables`` says the same of a block of elements in less memory; None for other blocks.
    3. ``force`` overwrites the force buffer with the block's part of f = f_int - f_ext. It allocates nothing per element.
    4. ``force_tangent`` also overwrites the tangent buffer with alpha_q df/dq + alpha_v df/dv, exact at (t, q, v) when
       ``q_previous`` is q. ``q_previous`` is Newton's previous iterate: a block may use it to take the stress of the geometric
       stiffness from a linear extrapolation, which saves iterations and changes no converged result.
    5. ``energy`` is the potential whose derivative is the conservative part of f, 0.0 when there is none.
    6. ``dissipation`` is the power [W] turned into heat, never negative, 0.0 when there is none.
    7. A block with discrete state (a latch that has engaged, the turns an angle has made) changes it only between steps:
       ``settle`` is called once with each accepted configuration. ``reset`` puts the state back to that of the start of a run.
       ``settled_heat`` is the energy that such changes have turned into heat since then. ``remembered`` names that state.
    8. A block most of whose tangent vanishes (contact) may divide the buffer: part i begins at ``k_parts[i]`` and ends at
       ``k_parts[i + 1]``. ``force_tangent`` then says in ``k_used`` (n_part,) which parts it has written; the others count as 0.
    """

    name: str
    symmetry: Symmetry = "symmetric"
    depends_on_velocity: bool = False
    linear_in_velocity: bool = False
    """Whether ``damping_force`` is linear in the velocities, and thus the product of the tangent df/dv with them."""
    first_order: bool = False
    """Whether it acts on the rows of scalar fields; ``alpha_v`` is then the weight of their rates."""
    varies: bool = False
    """Whether the potential depends on time or temperature as well, as that of an actuator or of a heated shell does."""
    k_rows: Ints
    k_cols: Ints
    k_scale: Floats
    k_tables: TangentTables | None = None
    k_parts: Ints | None = None
    k_used: Bools

    @abstractmethod
    def force_tangent(
        self, t: float, q: Floats, v: Floats, alpha_q: float, alpha_v: float, q_previous: Floats, f: Floats, k: Floats
    ) -> None:
        """Write the force buffer ``f`` (n_f,) and the tangent buffer ``k`` (n_k,)."""

    @abstractmethod
    def energy(self, t: float, q: Floats) -> float:
        """Potential energy [J]."""

    def acting_on(self, coordinates: Bools, numbering: Numbering | None) -> ForceBlock | None:
        """A block of those of its items alone that act on some coordinates (n_q,), numbered anew if there is a numbering.

        Items must read no coordinates but those that they act on. None where they cannot be told apart.
        """
        return None

    def repeated(self, n: int, n_q: int) -> ForceBlock | None:
        """A block of n times its items, of which those of state number k act on coordinates k n_q and more.

        None where they cannot be told apart, or depend on time.
        """
        return None

    def damping_force(self, t: float, q: Floats, v: Floats, f: Floats) -> None:
        """Write f(t, q, v) - f(t, q, 0) to the force buffer ``f`` (n_f,)."""
        still = np.empty_like(f)
        self.force(t, q, np.zeros_like(v), still)
        self.force(t, q, v, f)
        f -= still

    def dissipation(self, t: float, q: Floats, v: Floats) -> float:
        """Power turned into heat [W]."""
        return 0.0

    @property
    def depends_on_time_alone(self) -> bool:
        """Whether its force is the same for all states at one time, so that it is evaluated once for each time."""
        return not len(self.k_rows) and not self.depends_on_velocity

    @property
    def symmetric_form(self) -> MatrixFreeBlock | None:
        """The same force with a symmetric tangent near to that of a nearly symmetric block; None where there is none."""
        return None

    def force_change(self, beside: Sequence[ForceBlock], weights: Sequence[float]) -> Force | None:
        """What writes sum w_i f_i(t, q, v), the derivative of the force by a parameter, at less than the price of all f_i.

        A :class:`ForceChange` where coordinates may follow the parameter as well; None where there is nothing better than to
        evaluate all f_i.

        Args:
            beside: this block for values of the parameter beside its own.
            weights: of these, whose sum is 0.
        """
        return None

    def settle(self, t: float, q: Floats) -> None:
        """Take note of an accepted configuration (rule 7)."""

    def reset(self) -> None:
        """Forget what happened in an earlier run (rule 7)."""

    def settled_heat(self) -> float:
        """Energy that changes of discrete state have turned into heat since the start of a run [J] (rule 7)."""
        return 0.0


class MatrixFreeBlock(ForceBlock):
    """A force block that multiplies its tangent with vectors, at the cost of few forces.

    The product is with the exact tangent, also where ``force_tangent`` writes a symmetric matrix near it.
    """

    @abstractmethod
    def tangent(self) -> TangentOperator:
        """A new operator with the tangent."""


class TangentOperator(ABC):
    """The tangent of a block as an operator on changes of the coordinates, at a point of its own."""

    @abstractmethod
    def look(self, t: float, q: Floats, v: Floats, alpha_q: float, alpha_v: float) -> None:
        """Go to a point, and evaluate what all products with alpha_q df/dq + alpha_v df/dv there need."""

    @abstractmethod
    def weigh(self, alpha_q: float, alpha_v: float) -> None:
        """The same where a change of the force has looked already (:meth:`ForceChange.along`)."""

    @abstractmethod
    def multiply(self, x: Floats, f: Floats) -> None:
        """Write the product with x, in all coordinates (n_q,), to the force buffer ``f`` (n_f,) of the block."""


class InertiaBlock(ABC):
    """A constant, symmetric, positive semi-definite part of the mass matrix."""

    name: str

    @abstractmethod
    def mass(self) -> tuple[Ints, Ints, Floats]:
        """Vectors i, j and masses m_ij of all entries (both triangles) of M = m x 1_3; duplicates are summed.

        The coordinates are vectors whose three components move alike, so a mass matrix has one number for each pair of vectors.
        """

    def pairs(self) -> tuple[Ints, Ints]:
        """Vectors i, j of all entries, of which those of one triangle suffice."""
        return self.mass()[:2]

    def coupled_with(self, chosen: Bools) -> Ints:
        """Vectors that have an entry with some of all vectors, (n_vectors,), maybe several times, and maybe others."""
        i, j = self.pairs()
        coupled = chosen[i] | chosen[j]
        return np.concatenate([i[coupled], j[coupled]])


class ConstraintBlock(Memory, ABC):
    """Equations Phi(t, q) = 0 that take Lagrange multipliers.

    1. ``n_lam`` equations; ``j_rows`` (0 <= row < n_lam) and ``j_cols`` (coordinates) list the entries of Phi_q.
    2. ``k_rows, k_cols`` list each entry of the symmetric matrix (Phi_q^T lam)_q once (upper triangle).
    3. ``phi_t`` is the partial derivative by time; ``gamma`` = (Phi_q v)_q v + 2 Phi_qt v + Phi_tt, so that
       Phi_q a = -gamma on the constraint.
    4. Buffers are overwritten, nothing is allocated per item.
    5. ``labels`` says for each row in words what it holds.
    6. ``body`` is True for equations by which a body holds itself together: two bodies joined along a line may hold the same
       director at unit length, and then one of the two rows is left out without a word.
    7. Where a row is c(q) = p(t) with a prescribed p, ``prescribed`` gives p: the work of the row's force is -lam dp.
    8. Discrete state obeys rule 7 of :class:`ForceBlock`.
    """

    name: str
    n_lam: int
    body: bool = False
    moves: bool = False
    """Whether time enters."""
    breakpoints: tuple[float, ...] = ()
    """Times [s] at which a prescribed value or one of its derivatives jumps."""
    first: int = 0
    """Number of the block's first multiplier in a state; set when a model is made."""
    j_rows: Ints
    j_cols: Ints
    k_rows: Ints
    k_cols: Ints

    @property
    def labels(self) -> tuple[str, ...]:
        """What each row holds, in words."""
        return (f"'{self.name}'",) * self.n_lam

    def prescribed(self, t: float) -> Floats:
        """Prescribed values p(t) of the rows, shape (n_lam,)."""
        return np.zeros(self.n_lam)

    @abstractmethod
    def phi(self, t: float, q: Floats, out: Floats) -> None:
        """Write Phi (n_lam,)."""

    @abstractmethod
    def jacobian(self, t: float, q: Floats, out: Floats) -> None:
        """Write the entries of Phi_q."""

    @abstractmethod
    def curvature(self, t: float, q: Floats, lam: Floats, out: Floats) -> None:
        """Write the entries of (Phi_q^T lam)_q."""

    @abstractmethod
    def phi_t(self, t: float, q: Floats, out: Floats) -> None:
        """Write the partial derivative of Phi by time (n_lam,)."""

    @abstractmethod
    def gamma(self, t: float, q: Floats, v: Floats, out: Floats) -> None:
        """Write (Phi_q v)_q v + 2 Phi_qt v + Phi_tt (n_lam,)."""

    def settle(self, t: float, q: Floats) -> None:
        """Take note of an accepted configuration (rule 8)."""

    def reset(self) -> None:
        """Forget what happened in an earlier run (rule 8)."""


def remembers(block: ForceBlock | ConstraintBlock) -> bool:
    """Whether a block has a discrete state."""
    return type(block).settle not in (ForceBlock.settle, ConstraintBlock.settle)
