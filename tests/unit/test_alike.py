"""What counts as doing the same."""

from __future__ import annotations

from functools import partial
from operator import mul

import numpy as np
import pytest
from scipy import sparse

import lamella as lm
from lamella.differentiation.alike import alike
from lamella.joint.motion_signals import TurnCounter
from lamella.load.dead import DeadLoadBlock
from lamella.threads import Workspace


def times(factor):
    def product(x):
        return factor * x

    return product


def other_times(factor):
    def product(x):
        return factor * x

    return product


def load(value, profile=None):
    return DeadLoadBlock("load", np.arange(3), np.full(3, value), profile or lm.Constant(1.0))


EQUAL = [
    (2, 2),
    (np.arange(3.0), np.arange(3.0)),
    ([1, (2.0, "a")], [1, (2.0, "a")]),
    ({"a": np.ones(2)}, {"a": np.ones(2)}),
    (times(2.0), times(2.0)),
    (partial(mul, 2.0), partial(mul, 2.0)),
    (load(1.0), load(1.0)),
    (load(1.0).energy, load(1.0).energy),
    (sparse.csr_array(np.eye(2)), sparse.csr_array(np.eye(2))),
    (Workspace(8), Workspace(8)),
]
DIFFERENT = [
    (2, 2.0),
    (np.arange(3.0), np.arange(4.0)),
    (np.arange(3.0), np.arange(3)),
    ([1, 2], [1, 3]),
    ({"a": 1}, {"b": 1}),
    (times(2.0), times(3.0)),
    (times(2.0), other_times(2.0)),
    (partial(mul, 2.0), partial(mul, 3.0)),
    (load(1.0), load(2.0)),
    (load(1.0, lm.Step(at=1.0)), load(1.0, lm.Step(at=2.0))),
    (sparse.csr_array(np.eye(2)), sparse.csr_array(2.0 * np.eye(2))),
    (TurnCounter(), TurnCounter()),  # with a memory
    (np.random.default_rng(1), np.random.default_rng(1)),  # of unknown kind
]


@pytest.mark.parametrize(("a", "b"), EQUAL)
def test_equal_things_are_alike(a, b):
    assert alike(a, b)


@pytest.mark.parametrize(("a", "b"), DIFFERENT)
def test_others_are_not(a, b):
    assert not alike(a, b)
    assert alike(a, a)


def test_what_refers_to_itself_is_compared_once():
    a, b, c = [1.0], [1.0], [2.0]
    for each in (a, b, c):
        each.append(each)
    assert alike(a, b)
    assert not alike(a, c)
