"""Measures for tests: each kind with shared vectors, constants and large angles, and an oracle that is written another way."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from lamella.kinematics import VectorRows
from lamella.measure.kernels import ANGLE, LENGTH
from lamella.measure.measure import Measure, angle, length, slide

N_VECTORS = 5
N = 3 * N_VECTORS


def rows(vectors, weights, constant=(0.0, 0.0, 0.0)):
    return VectorRows(np.array(vectors, dtype=np.int64), np.array(weights, float), np.array(constant, float))


U, W, T = rows([0, 3], [1.0, -0.4], (0.1, 0.0, 0.2)), rows([3, 1], [0.7, 1.2]), rows([2, 0], [2.5, 0.3], (0.0, 0.0, 1.5))
FIXED_AXIS = VectorRows.fixed(np.array([0.0, 0.3, 2.0]))

MEASURES: dict[str, Measure] = {
    "length": (length(rows([4, 0, 2], [1.0, -0.5, -0.5], (0.3, 0.1, -0.2))),),
    "length from a point in space": (length(rows([1], [1.0], (1.0, 2.0, -1.0))),),
    "slide": (slide(rows([1, 0], [1.0, -1.0]), rows([0, 2], [0.3, 0.8], (0.0, 1.0, 0.0))),),
    "angle": (angle(U, W, T),),
    "angle about a fixed axis": (angle(rows([0], [1.0]), rows([1], [1.0]), FIXED_AXIS),),
    "angle from a fixed direction": (angle(VectorRows.fixed(np.array([1.0, 2.0, 0.0])), rows([1], [1.0]), T),),
    "angle about its own vectors": (angle(rows([0], [1.0]), rows([1], [1.0]), rows([0, 1], [0.2, 0.5], (0, 0, 1.0))),),
    "cable": (length(rows([0, 1], [1.0, -1.0])), length(rows([1, 2], [1.0, -1.0])), length(rows([2], [1.0], (0, 0, 3.0)))),
    "coupling": (angle(U, W, T, 2.0), angle(W, rows([4], [1.0]), T, -0.5)),
    "all kinds": (length(rows([0, 1], [1.0, -1.0]), -1.5), angle(U, W, T, 0.3), slide(rows([2], [1.0]), rows([3], [1.0]), 0.7)),
}


def configuration(seed: int) -> np.ndarray:
    return np.random.default_rng(seed).uniform(-1.0, 1.0, N)


def at(part: VectorRows, q: np.ndarray) -> np.ndarray:
    return part.weights @ q.reshape(-1, 3)[part.vectors] + part.constant


def arc(s: complex, c: complex) -> complex:
    """The angle of the point (c, s), also for complex steps, by the quotient that stays small."""
    s, c = complex(s), complex(c)
    if abs(c.real) > abs(s.real):
        return np.arctan(s / c) + (0.0 if c.real > 0 else np.copysign(np.pi, s.real))
    return np.copysign(np.pi / 2, s.real) - np.arctan(c / s)


def oracle(measure: Measure, q: np.ndarray) -> complex:
    """The measure by projection on the plane across the axis; ``q`` may be complex."""
    total = 0.0
    for term in measure:
        parts = [at(part, q) for part in term.vectors]
        if term.kind == LENGTH:
            found = np.sqrt(parts[0] @ parts[0])
        elif term.kind == ANGLE:
            u, w, t = parts
            e = t / np.sqrt(t @ t)
            first = u - (u @ e) * e
            second = np.cross(e, first)
            found = arc((w @ second) / np.sqrt(second @ second), (w @ first) / np.sqrt(first @ first))
        else:
            found = parts[0] @ parts[1]
        total = total + term.factor * found
    return total


def complex_gradient(measure: Measure, q: np.ndarray) -> np.ndarray:
    step = 1e-30
    return np.array([np.imag(oracle(measure, q + 1j * step * unit)) / step for unit in np.eye(len(q))])


def derivative(function: Callable[[float], np.ndarray], h: float = 1e-3) -> np.ndarray:
    """Of fourth order, at 0."""
    return (8.0 * (function(h) - function(-h)) - (function(2 * h) - function(-2 * h))) / (12.0 * h)


def second_derivative(function: Callable[[float], np.ndarray], h: float = 2e-3) -> np.ndarray:
    """Of fourth order, at 0."""
    return (16.0 * (function(h) + function(-h)) - (function(2 * h) + function(-2 * h)) - 30.0 * function(0.0)) / (12.0 * h**2)
