"""The mass matrix as operators on vectors of coordinates."""

from __future__ import annotations

from functools import cached_property

from scipy import sparse

from lamella.assembly.operator import VectorOperator
from lamella.model import Model


class Mass:
    """M in all coordinates and T^T M T in the independent ones; each is made when first needed, since statics needs neither.

    Args:
        model: the compiled model.
        T: map from independent to all coordinates, (n_q, n_u).
        like: that of another model with the same ``T``, whose operators serve here as well where the masses are equal.
    """

    def __init__(self, model: Model, T: sparse.csr_array, like: Mass | None = None) -> None:
        self._model, self._T, self._like = model, T, like

    @cached_property
    def _same(self) -> Mass | None:
        if self._like is None:
            return None
        mine, theirs = self._model.vector_mass, self._like._model.vector_mass
        return self._like if mine.nnz == theirs.nnz and abs(mine - theirs).max() == 0.0 else None

    @property
    def as_like(self) -> bool:
        """Whether the masses are those of the other model."""
        return self._same is not None

    @cached_property
    def in_all(self) -> VectorOperator:
        """M, for all coordinates (n_q,)."""
        return self._same.in_all if self._same else VectorOperator(self._model.vector_mass)

    @cached_property
    def in_independent(self) -> VectorOperator | None:
        """T^T M T; None where it does not go by vectors, since three products are faster then."""
        if self._same:
            return self._same.in_independent
        return in_independent(self._model.mass, self._T)


def in_independent(M: sparse.csr_array, T: sparse.csr_array) -> VectorOperator | None:
    """T^T M T; None where it does not go by vectors."""
    return VectorOperator.within(sparse.csr_array(T.T @ M @ T))
