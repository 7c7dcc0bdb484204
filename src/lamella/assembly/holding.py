"""What acts on the coordinates that supports hold: all that their reactions need."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from itertools import chain
from typing import NamedTuple

import numpy as np
from scipy import sparse

from lamella.assembly.constraints import ConstraintStack
from lamella.assembly.forces import ForceSum
from lamella.assembly.operator import VectorOperator
from lamella.model import Model
from lamella.numbering import Numbering
from lamella.roles import Bools, Floats, ForceBlock, Ints

Forces = ForceSum[ForceBlock]


class Acting(NamedTuple):
    """What acts on held coordinates, in coordinates of its own.

    Args:
        forces, loads: sums of the blocks.
        numbering: the near vectors; None where these are all there are.
        numbers: of the blocks among all forces, and among all loads.
    """

    forces: Forces
    loads: Forces
    numbering: Numbering | None
    numbers: tuple[Sequence[int], ...]


class Holding:
    """The reaction R = M a + f + Phi_q^T lam where supports hold coordinates; elsewhere it vanishes.

    Of elements, those at supports suffice: 16 of 384 on a plate that is clamped at one edge. They have coordinates of their own,
    the near ones, if nothing acts there whose items cannot be told apart; else all coordinates are near.

    Args:
        model: the compiled model.
        held: the coordinates that supports hold, shape (n,).
        forces, loads: the sums of all blocks.
        constraints: those with multipliers.
    """

    def __init__(self, model: Model, held: Ints, forces: Forces, loads: Forces, constraints: ConstraintStack) -> None:
        self._model, self._forces, self._loads, self._constraints = model, forces, loads, constraints
        self._held = np.unique(held)
        self.n_states, self._stacks = 1, dict[int, "Holding | None"]()

    def stack(self, n: int) -> Holding | None:
        """The same for n states side by side, whose coordinates, forces and reactions have shape (n, n_q); itself for one.

        None where something acts that depends on time, or whose items cannot be told apart.
        """
        if n == 1:
            return self
        if n not in self._stacks:
            self._stacks[n] = self._stacked(n)
        return self._stacks[n]

    def _stacked(self, n: int) -> Holding | None:
        forces, loads, numbering, numbers = self.acting
        n_near = self.n_near
        parts = [[block.repeated(n, n_near) for block, _ in blocks.parts] for blocks in (forces, loads)]
        if numbering is None or None in chain(*parts):
            return None
        found = Holding(self._model, self._held, self._forces, self._loads, self._constraints)
        of_forces, of_loads = (ForceSum([block for block in part if block], n * n_near) for part in parts)
        found.n_states, found.acting, found.mass = n, Acting(of_forces, of_loads, numbering, numbers), self.mass
        return found

    def is_like(self, other: Holding) -> bool:
        """Whether the same blocks act, with the same near coordinates: a load that moves may come to act, or cease to."""
        mine, its = self.acting, other.acting
        if mine.numbers != its.numbers or (mine.numbering is None) != (its.numbering is None):
            return False
        return mine.numbering is None or np.array_equal(self.vectors, other.vectors)

    @property
    def knows_states(self) -> bool:
        """Whether blocks are given the arrays of a state themselves, by which contact knows one that was evaluated already."""
        return len(self._held) > 0 and self.acting.numbering is None

    @cached_property
    def unparted(self) -> Holding:
        """The same of all blocks as they are, in all coordinates."""
        found = Holding(self._model, self._held, self._forces, self._loads, self._constraints)
        numbers = tuple(range(len(blocks.parts)) for blocks in (self._forces, self._loads))
        found.acting = Acting(self._forces, self._loads, None, numbers)
        return found

    @cached_property
    def acting(self) -> Acting:
        """The blocks; made when first needed."""
        model, n_q = self._model, self._model.n_q
        held = np.zeros(n_q, bool)
        held[self._held] = True
        every = [[block for block, _ in blocks.parts] for blocks in (self._forces, self._loads)]
        numbers = tuple([k for k, block in enumerate(blocks) if _acts(block, held)] for blocks in every)
        forces, loads = ([blocks[k] for k in own] for blocks, own in zip(every, numbers, strict=True))
        mixed = self._constraints.n_all or held[model.n_motion :].any()
        numbering = Numbering(model.n_motion // 3)
        near = [[None if mixed else block.acting_on(held, numbering) for block in blocks] for blocks in (forces, loads)]
        if mixed or None in chain(*near):
            of_forces, of_loads = ([block.acting_on(held, None) or block for block in blocks] for blocks in (forces, loads))
            return Acting(ForceSum(of_forces, n_q), ForceSum(of_loads, n_q), None, numbers)
        numbering.add(self._held // 3)
        of_vectors = np.zeros(model.n_motion // 3, bool)
        of_vectors[self._held // 3] = True
        for inertia in model.inertias:
            numbering.add(inertia.coupled_with(of_vectors))
        n = 3 * len(numbering.vectors)
        of_forces, of_loads = (ForceSum([block for block in part if block], n) for part in near)
        return Acting(of_forces, of_loads, numbering, numbers)

    @property
    def vectors(self) -> Ints:
        """Numbers of the near vectors."""
        numbering = self.acting.numbering
        return np.arange(self._model.n_motion // 3) if numbering is None else numbering.vectors

    @cached_property
    def _coords(self) -> Ints | None:
        """The near coordinates."""
        numbering = self.acting.numbering
        return None if numbering is None else (3 * numbering.vectors[:, None] + np.arange(3)).reshape(-1)

    @cached_property
    def _places(self) -> Ints:
        """Where held coordinates are among the near ones."""
        numbering = self.acting.numbering
        return self._held if numbering is None else numbering.coordinates(self._held)

    @cached_property
    def mass(self) -> VectorOperator:
        """The rows of M that belong to held vectors, for near coordinates."""
        return VectorOperator(self.rows_of(self._model.vector_mass))

    def rows_of(self, m: sparse.csr_array) -> sparse.csr_array:
        """The rows of a mass matrix of vectors that reactions need, of near vectors."""
        vectors = None if self.acting.numbering is None else self.acting.numbering.vectors
        near = m if vectors is None else m[vectors][:, vectors]
        n = len(near.indptr) - 1
        needed = np.zeros(n, bool)
        of_held = self._places // 3
        needed[of_held[of_held < n]] = True  # scalar fields lie behind the vectors
        lengths = np.where(needed, np.diff(near.indptr), 0)
        chosen = np.repeat(needed, np.diff(near.indptr))
        return sparse.csr_array((near.data[chosen], near.indices[chosen], np.append(0, np.cumsum(lengths))), shape=(n, n))

    @cached_property
    def _still(self) -> Floats:
        return np.zeros(self.n_near)

    @property
    def n_near(self) -> int:
        """Number of near coordinates, of all states."""
        return self.n_states * (self._model.n_q if self._coords is None else len(self._coords))

    def near(self, coordinates: Floats) -> Floats:
        """Those of all coordinates, or changes of them, that are near, in one row, shape (n_near,)."""
        return coordinates if self._coords is None else coordinates.take(self._coords, -1).reshape(-1)

    def whole(self, forces: Floats) -> Floats:
        """Forces on held coordinates from those on near ones (n_near,), in all coordinates."""
        if self.n_states == 1:
            found = np.zeros(self._model.n_q)
            found[self._held] = forces.take(self._places)
            return found
        several = np.zeros((self.n_states, self._model.n_q))
        several[:, self._held] = forces.reshape(self.n_states, -1).take(self._places, 1)
        return several

    def add_product(self, mass: VectorOperator, a: Floats, forces: Floats) -> None:
        """Add the product of rows of a mass with near accelerations (n_near,) to near forces."""
        for one, out in zip(a.reshape(self.n_states, -1), forces.reshape(self.n_states, -1), strict=True):
            mass.onto(one, out)

    def reaction(self, t: float, factor: float, q: Floats, v: Floats | None, a: Floats | None, lam: Floats) -> Floats:
        """R in all coordinates.

        Args:
            t: time [s].
            factor: load factor.
            q, v, a: all coordinates, velocities, which may be left out where nothing depends on them, and accelerations; none
                at rest.
            lam: multipliers of the rows kept.
        """
        if not len(self._held):
            return np.zeros(q.shape)
        forces, loads, *_ = self.acting
        q_near, v_near = self.near(q), self._still if v is None else self.near(v)
        found = loads(t, q_near, v_near) * factor
        forces.evaluate(t, q_near, v_near)
        forces.onto_all(found)
        if a is not None:
            self.add_product(self.mass, self.near(a), found)
        return self.with_multipliers(self.whole(found), t, q, lam)

    def with_multipliers(self, forces: Floats, t: float, q: Floats, lam: Floats) -> Floats:
        """Add Phi_q^T lam where coordinates are held to forces (n_q,) there."""
        if len(lam):
            self._constraints.add_force(t, q, lam, forces)
            held = forces[self._held]
            forces[:] = 0.0
            forces[self._held] = held
        return forces

    def forget(self) -> None:
        """Evaluate everything anew, also at the same time: an input has changed."""
        if "acting" in vars(self):
            self.acting.forces.forget()
            self.acting.loads.forget()


def _acts(block: ForceBlock, coordinates: Bools) -> bool:
    """Whether a block acts on some coordinates; one without forces may have a part of another block's tangent."""
    coords = block.f_coords
    return not len(coords) or bool(coordinates[coords[coords >= 0]].any())
