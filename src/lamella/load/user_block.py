"""The block of forces written in Python."""

from __future__ import annotations

import reprlib
from collections.abc import Callable, Sequence

import numpy as np

from lamella.errors import DeclarationError, FunctionError
from lamella.kinematics import VectorRows, vectors_of
from lamella.roles import Floats, ForceBlock

STEP = 6e-6
"""Step of central differences, relative to the size of the body: the cube root of the rounding unit."""
AGREEMENT = 1e-4
"""Share of the largest derivative by which a given tangent may differ from differences."""

Pair = tuple[Floats, Floats]


class UserForceBlock(ForceBlock):
    """f = -W^T F(t, r, v) with the points r = W x + c and their velocities v = W x'.

    A tangent that is given is compared with central differences at the first linearisation of a run. The comparison is made a
    little beside the configuration and with some velocity, because at rest many laws have a corner or vanish.

    Args:
        name: the load's name.
        points: the points, n of them.
        labels: their names, for messages.
        size: size of the bodies [m].
        function: F, (n, 3).
        tangent: dF/dr and dF/dv, each (3 n, 3 n); central differences when None.
        potential: whether F is -dV/dr.
    """

    def __init__(
        self,
        name: str,
        points: Sequence[VectorRows],
        labels: Sequence[str],
        size: float,
        function: Callable[[float, Floats, Floats], Floats],
        tangent: Callable[[float, Floats, Floats], Pair] | None,
        *,
        potential: bool,
    ) -> None:
        self.name, self.labels, self.size, self.n = name, tuple(labels), size, len(points)
        self.function, self.tangent, self.potential = function, tangent, potential
        self.symmetry, self.depends_on_velocity = "symmetric" if potential else "none", not potential
        self._vectors = np.unique(np.concatenate([point.vectors for point in points]))
        self._constants = np.stack([point.constant for point in points])
        self._weights = np.zeros((self.n, len(self._vectors)))
        for row, point in zip(self._weights, points, strict=True):
            row[np.searchsorted(self._vectors, point.vectors)] = point.weights
        self._spread = np.kron(self._weights, np.eye(3))
        self.f_coords = (3 * self._vectors[:, None] + np.arange(3)).reshape(-1)
        self.f_scale = np.ones(len(self.f_coords))
        whole = np.ones((len(self.f_coords),) * 2, dtype=bool)
        self._i, self._j = np.nonzero(np.triu(whole) if potential else whole)
        self.k_rows, self.k_cols = self.f_coords[self._i], self.f_coords[self._j]
        self.k_scale = np.ones(len(self._i))
        self._checked = False

    def forces(self, t: float, q: Floats, v: Floats) -> Floats:
        """F at a state [N], shape (n, 3)."""
        return self._called(t, *self._motion(q, v))

    def force(self, t: float, q: Floats, v: Floats, f: Floats) -> None:
        np.matmul(self._weights.T, -self.forces(t, q, v), out=f.reshape(-1, 3))

    def force_tangent(
        self, t: float, q: Floats, v: Floats, alpha_q: float, alpha_v: float, q_previous: Floats, f: Floats, k: Floats
    ) -> None:
        self.force(t, q, v, f)
        r, rate = self._motion(q, v)
        if not self._checked:
            self._check(t, r, rate)
        F_r, F_v = self._given(t, r, rate) if self.tangent else self._differences(t, r, rate, by_velocity=alpha_v != 0.0)
        local = alpha_q * F_r + alpha_v * F_v
        if self.potential:
            local = 0.5 * (local + local.T)
        k[:] = -(self._spread.T @ local @ self._spread)[self._i, self._j]

    def energy(self, t: float, q: Floats) -> float:
        return 0.0

    def reset(self) -> None:
        self._checked = False

    def _motion(self, q: Floats, v: Floats) -> Pair:
        """Positions and velocities of the points, in arrays that the function may change."""
        return self._weights @ vectors_of(q)[self._vectors] + self._constants, self._weights @ vectors_of(v)[self._vectors]

    def _called(self, t: float, r: Floats, v: Floats) -> Floats:
        F = self._array("function", self._answer("function", self.function, t, r, v))
        if F.shape != (self.n, 3):
            raise self._refused(f"'function' gave an array of shape {F.shape}", f"accepted are forces of shape ({self.n}, 3)")
        return F

    def _answer(self, which: str, function: Callable[..., object], t: float, r: Floats, v: Floats) -> object:
        """What one of the functions gives.

        Raises:
            FunctionError: it raised an error.
        """
        try:
            return function(t, r.copy(), v.copy())
        except Exception as error:
            said = f"'{which}' raised {type(error).__name__}: {error}"
            raise FunctionError(f"UserForce '{self.name}' at t = {t:g} s: {said}") from error

    def _array(self, which: str, given: object) -> Floats:
        """Numbers that one of the functions gave."""
        try:
            return np.asarray(given).astype(float, casting="safe", copy=False)  # complex numbers and texts are none
        except (TypeError, ValueError) as error:
            raise self._refused(f"'{which}' gave {reprlib.repr(given)}", "accepted are real numbers") from error

    def _given(self, t: float, r: Floats, v: Floats) -> Pair:
        assert self.tangent is not None
        found: object = self._answer("tangent", self.tangent, t, r, v)
        if not isinstance(found, (tuple, list, np.ndarray)) or len(found) != 2:
            raise self._refused(f"'tangent' gave {reprlib.repr(found)}", "accepted is the pair dF/dr and dF/dv")
        F_r, F_v = (self._array("tangent", part) for part in found)
        if F_r.shape != F_v.shape or F_r.shape != (3 * self.n, 3 * self.n):
            wanted = f"accepted are dF/dr and dF/dv, each of shape ({3 * self.n}, {3 * self.n})"
            raise self._refused(f"'tangent' gave arrays of shapes {F_r.shape} and {F_v.shape}", wanted)
        return F_r, F_v

    def _differences(self, t: float, r: Floats, v: Floats, *, by_velocity: bool = True) -> Pair:
        """dF/dr and dF/dv by central differences; the latter zero when it is not wanted or the forces have a potential."""
        fast = max(float(np.abs(v).max()), self.size)  # one size of the body in a second where all is at rest
        F_r, F_v = np.zeros((2, 3 * self.n, 3 * self.n))
        for place in range(3 * self.n):
            step = np.zeros(3 * self.n)
            step[place] = STEP
            d = step.reshape(-1, 3)
            near = self._called(t, r + self.size * d, v) - self._called(t, r - self.size * d, v)
            F_r[:, place] = near.reshape(-1) / (2.0 * STEP * self.size)
            if by_velocity and not self.potential:
                quick = self._called(t, r, v + fast * d) - self._called(t, r, v - fast * d)
                F_v[:, place] = quick.reshape(-1) / (2.0 * STEP * fast)
        return F_r, F_v

    def _check(self, t: float, r: Floats, v: Floats) -> None:
        """Refuse forces that are none, and compare a given tangent with differences, that of a potential with its transpose."""
        self._checked = True
        start = self._called(t, r, v)
        if not np.isfinite(start).all():
            problem = f"'function' gave {reprlib.repr(start.tolist())} at t = {t:g} s, where the computation begins"
            raise self._refused(problem, "accepted are finite numbers [N]")
        aside = 0.5 + 0.5 * np.modf(0.6180339887 * np.arange(1, 3 * self.n + 1))[0].reshape(-1, 3)  # all different, 0.5 to 1
        r, v = r + 1e-3 * self.size * aside, v + self.size * aside
        found = self._differences(t, r, v)
        # a constant force has no derivatives, but its differences round
        rounding = 1e-9 * float(np.abs(self._called(t, r, v)).max()) / self.size
        if self.tangent is not None:
            accepted = "accepted are the derivatives of 'function'"
            for part, given, wanted in zip(("dF/dr", "dF/dv"), self._given(t, r, v), found, strict=True):
                self._compare(t, part, given, wanted, rounding, "differences give", accepted)
        if self.potential:
            accepted = "accepted with potential=True is a symmetric one"
            self._compare(t, "dF/dr", found[0], found[0].T, rounding, "its transpose is", accepted)

    def _compare(self, t: float, part: str, given: Floats, wanted: Floats, rounding: float, other: str, accepted: str) -> None:
        error = np.abs(given - wanted)
        error[~np.isfinite(error)] = np.inf
        if error.max() <= AGREEMENT * max(np.abs(given).max(), np.abs(wanted).max()) + rounding:
            return
        i, j = np.unravel_index(int(np.argmax(error)), error.shape)
        of, by = (f"{'xyz'[k % 3]} of {self.labels[k // 3]}" for k in (int(i), int(j)))
        problem = f"{part} at t = {t:g} s, entry [{i}, {j}] (force along {of}, by {by}), is {given[i, j]:.6g}"
        raise self._refused(f"{problem}, {other} {wanted[i, j]:.6g}", accepted)

    def _refused(self, problem: str, accepted: str) -> DeclarationError:
        return DeclarationError(f"UserForce '{self.name}'", problem, accepted)
