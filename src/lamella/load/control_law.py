"""Control laws in discrete time: PID, state space, and functions of one's own."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from typing import Annotated

import numpy as np
from pydantic import Field

from lamella.declaration import declaration
from lamella.math.profile import Constant, Profile
from lamella.roles import Floats
from lamella.units import Number

Matrix = tuple[tuple[Number, ...], ...]


class ControlLaw(ABC):
    """What a controller does at each sample time: (u_k, x_k+1) = law(t_k, y_k, x_k).

    1. It is frozen data; its state is handed to it and given back.
    2. ``initial`` is the state at the start of a run, shape (n,), empty when it has none.
    3. ``sample`` gives the outputs, shape (m,), that are held until the next sample, and the next state.
    """

    @property
    def initial(self) -> Floats:
        """State at the start of a run."""
        return np.zeros(0)

    @abstractmethod
    def sample(self, t: float, y: Floats, x: Floats, period: float) -> tuple[Floats, Floats]:
        """Outputs and next state.

        Args:
            t: time [s].
            y: measured values, shape (p,).
            x: state, shape (n,).
            period: time until the next sample [s].
        """


@declaration
class PID(ControlLaw):
    """u = k_p e + k_i sum e T + k_d (e_k - e_k-1) / T with e = r(t) - y, one measured value and one output.

    The output is limited to +-limit; the sum then does not grow further that way. The first sample has no derivative.

    Args:
        proportional: k_p, output for each unit of the measured value.
        integral: k_i [1/s].
        derivative: k_d [s].
        reference: r as a function of time, in the unit of the measured value.
        limit: largest size of the output; none when left out.
    """

    proportional: Number = 0.0
    integral: Number = 0.0
    derivative: Number = 0.0
    reference: Profile = Constant(0.0)
    limit: Annotated[float, Field(gt=0)] | None = None

    @property
    def initial(self) -> Floats:
        """Sum of e T, last e, and 1 when there was one."""
        return np.zeros(3)

    def sample(self, t: float, y: Floats, x: Floats, period: float) -> tuple[Floats, Floats]:
        if y.shape != (1,):
            raise ValueError(f"a PID takes one measured value, {len(y)} are given")
        total, last, begun = x
        e = self.reference.value(t) - float(y[0])
        slope = (e - last) / period if begun else 0.0
        grown = total + period * e
        u = self.proportional * e + self.integral * grown + self.derivative * slope
        if self.limit is not None and abs(u) > self.limit:
            if u * self.integral * e > 0.0:
                grown = total
            u = float(np.clip(self.proportional * e + self.integral * grown + self.derivative * slope, -self.limit, self.limit))
        return np.array([u]), np.array([grown, e, 1.0])


@declaration
class StateSpaceLaw(ControlLaw):
    """u_k = C x_k + D y_k, x_k+1 = A x_k + B y_k: an observer with feedback, a filter, an H-infinity controller.

    Args:
        A, B, C, D: matrices of the sampled law, as rows; those of a continuous one are discretised first, for example by
            ``scipy.signal.cont2discrete``.
    """

    A: Matrix
    B: Matrix
    C: Matrix
    D: Matrix

    def __post_init__(self) -> None:
        try:
            A, B, C, D = (np.array(matrix, float) for matrix in (self.A, self.B, self.C, self.D))
            n, (m, p) = len(A), D.shape
            fit = (A.shape, B.shape, C.shape) == ((n, n), (n, p), (m, n))
        except ValueError:  # rows of unequal lengths
            fit = False
        if not fit:
            raise ValueError("the matrices do not fit; accepted are A (n, n), B (n, p), C (m, n), D (m, p)")

    @property
    def initial(self) -> Floats:
        return np.zeros(len(self.A))

    def sample(self, t: float, y: Floats, x: Floats, period: float) -> tuple[Floats, Floats]:
        A, B, C, D = (np.array(matrix, float) for matrix in (self.A, self.B, self.C, self.D))
        if len(y) != D.shape[1]:
            raise ValueError(f"D takes {D.shape[1]} measured values, {len(y)} are given")
        return C @ x + D @ y, A @ x + B @ y


@declaration
class FunctionLaw(ControlLaw):
    """A law written in Python.

    Args:
        function: gives u from (t, y); with a ``start`` the pair (u, x_next) from (t, y, x).
        start: state at the start.
    """

    function: Callable[..., object]
    start: tuple[Number, ...] = ()

    @property
    def initial(self) -> Floats:
        return np.array(self.start, float)

    def sample(self, t: float, y: Floats, x: Floats, period: float) -> tuple[Floats, Floats]:
        # what it gives is copied: a function may fill one array of its own again and again
        if not self.start:
            return np.atleast_1d(np.array(self.function(t, y.copy()), float)), x
        found: object = self.function(t, y.copy(), x.copy())
        if not isinstance(found, tuple) or len(found) != 2:
            raise ValueError("a law with a state gives the pair (u, x_next)")
        return np.atleast_1d(np.array(found[0], float)), np.atleast_1d(np.array(found[1], float))
