"""New numbers for some of a model's vectors."""

from __future__ import annotations

import numpy as np

from lamella.roles import Ints


class Numbering:
    """Numbers vectors anew, in the order in which they are asked for.

    Args:
        n_vectors: number of all vectors.

    Attributes:
        vectors: the old number of each vector that has a new one, shape (n,).
    """

    def __init__(self, n_vectors: int) -> None:
        self.vectors: Ints = np.zeros(0, np.int64)
        self._places = np.full(n_vectors, -1)

    def add(self, vectors: Ints) -> None:
        """Give numbers to vectors that have none."""
        new = np.unique(vectors[self._places[vectors] < 0])
        self._places[new] = len(self.vectors) + np.arange(len(new))
        self.vectors = np.concatenate([self.vectors, new])

    def coordinates(self, coords: Ints) -> Ints:
        """New numbers of coordinates, whose vectors are given numbers if they have none."""
        vectors, components = np.divmod(coords, 3)
        self.add(vectors.reshape(-1))
        return 3 * self._places[vectors] + components
