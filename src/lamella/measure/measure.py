"""Measures: sums of lengths, angles and slides as functions of the coordinates."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from lamella.kinematics import VectorRows
from lamella.measure.kernels import ANGLE, LENGTH, SLIDE, evaluate, rates
from lamella.memory import Memory
from lamella.roles import Floats, Ints


@dataclass(frozen=True)
class Term:
    """A share of a measure: factor times a length, angle or slide of vectors.

    Args:
        kind: LENGTH, ANGLE or SLIDE of :mod:`lamella.measure.kernels`.
        vectors: d; or u, w, t; or d, z.
        factor: factor [-].
        centre: an angle is taken within pi of it at the start, and then of where it last was [rad].
    """

    kind: int
    vectors: tuple[VectorRows, ...]
    factor: float = 1.0
    centre: float = 0.0


Measure = tuple[Term, ...]
"""A scalar of a configuration, the sum of its terms."""


def length(d: VectorRows, factor: float = 1.0) -> Term:
    """|d|."""
    return Term(LENGTH, (d,), factor)


def angle(u: VectorRows, w: VectorRows, t: VectorRows, factor: float = 1.0, centre: float = 0.0) -> Term:
    """The angle that turns u into w about t, with u and w taken perpendicular to t; t has any length."""
    return Term(ANGLE, (u, w, t), factor, centre)


def slide(d: VectorRows, z: VectorRows, factor: float = 1.0) -> Term:
    """d . z, the component of d along a unit vector z."""
    return Term(SLIDE, (d, z), factor)


class MeasureSet(Memory):
    """Several measures with their arrays.

    An angle is known up to full turns. It is taken within pi of its centre, which ``follow`` moves to its last value, so that it
    may turn any number of times as long as it turns by less than pi between two calls.

    Args:
        measures: the measures.
    """

    remembered = ("centres",)

    def __init__(self, measures: Sequence[Measure]) -> None:
        self.n = len(measures)
        terms = [term for measure in measures for term in measure]
        self._first_term = np.cumsum([0, *(len(measure) for measure in measures)])
        self._kinds = np.array([term.kind for term in terms], dtype=np.int64)
        self._factors = np.array([term.factor for term in terms])
        self.centres = np.array([term.centre for term in terms])
        self._first_centres = self.centres.copy()
        self._angles = self._kinds == ANGLE
        self._constants = np.zeros((len(terms), 3, 3))
        vectors, weights = [], []
        for measure, first in zip(measures, self._first_term, strict=False):
            own = np.unique(np.concatenate([part.vectors for term in measure for part in term.vectors]))
            vectors.append(own)
            for number, term in enumerate(measure, start=int(first)):
                matrix = np.zeros((3, len(own)))
                for a, part in enumerate(term.vectors):
                    matrix[a, np.searchsorted(own, part.vectors)] = part.weights
                    self._constants[number, a] = part.constant
                weights.append(matrix.reshape(-1))
        self._first_vector = np.cumsum([0, *(len(own) for own in vectors)])
        self._vectors: Ints = 3 * np.concatenate([np.zeros(0, np.int64), *vectors])
        self._first_weight = np.cumsum([0, *(len(w) for w in weights)])
        self._weights = np.concatenate([np.zeros(0), *weights])
        self.coords: Ints = (self._vectors[:, None] + np.arange(3)).reshape(-1)
        """Coordinates of all gradients, one measure after the other."""
        self.counts = 3 * np.diff(self._first_vector)
        """Coordinates of each measure."""
        self.owner = np.repeat(np.arange(self.n), self.counts)
        """Measure of each entry of the gradients."""
        self.values, self.gradients = np.zeros(self.n), np.zeros(len(self.coords))
        self._terms = np.zeros(len(terms))
        self.hessians = np.zeros(int(np.sum(self.counts**2)))
        self._scratch = np.zeros((36, 9))
        self._place, self._has_second = b"", False
        self.rows, self.cols = self._pairs()

    def _pairs(self) -> tuple[Ints, Ints]:
        """Places of the Hessians' entries among the gradients' entries."""
        starts = np.concatenate([[0], np.cumsum(self.counts)])
        rows = [start + np.repeat(np.arange(n), n) for start, n in zip(starts, self.counts, strict=False)]
        cols = [start + np.tile(np.arange(n), n) for start, n in zip(starts, self.counts, strict=False)]
        empty = np.zeros(0, dtype=np.int64)
        return np.concatenate([empty, *rows]), np.concatenate([empty, *cols])

    def evaluate(self, q: Floats, *, second: bool = False) -> None:
        """Overwrite ``values``, ``gradients`` and, with ``second``, ``hessians`` by those at ``q`` (n_q,).

        Those at the place evaluated last are known: constraints are asked for value, gradient and curvature one by one.
        """
        place = q[self.coords].tobytes() + self.centres.tobytes()
        if place == self._place and (self._has_second or not second):
            return
        self._place, self._has_second = place, second
        evaluate(
            self._first_term,
            self._kinds,
            self._factors,
            self.centres,
            self._constants,
            self._weights,
            self._first_weight,
            self._vectors,
            self._first_vector,
            q,
            second,
            self._scratch,
            self._terms,
            self.values,
            self.gradients,
            self.hessians,
        )

    def follow(self) -> None:
        """Take angles within pi of their values at the last configuration evaluated from now on."""
        self.centres[self._angles] = self._terms[self._angles]

    def reset(self) -> None:
        """Take angles within pi of where they were at the start."""
        self.centres[:] = self._first_centres

    def rates(self, v: Floats) -> Floats:
        """Rates of the measures at the last configuration evaluated, for velocities ``v`` (n_q,)."""
        found = np.empty(self.n)
        rates(self.owner, self.gradients, self.coords, v, found)
        return found

    def times(self, v: Floats) -> Floats:
        """Each Hessian times the velocities, in the order of the gradients."""
        local = v[self.coords]
        return np.bincount(self.rows, self.hessians * local[self.cols], minlength=len(self.coords)).astype(float)
