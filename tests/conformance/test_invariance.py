"""Motions do not depend on how a system lies, in which units it is given, and in which order its parts are named."""

from __future__ import annotations

import numpy as np
import pytest
from random_systems import World, ended, random_system
from scipy.spatial.transform import Rotation

from lamella.body.base import Body
from lamella.roles import Declaration
from lamella.system import System

SEEDS = range(20)
CLOSE = 1e-6
"""Of sizes near 1 m: rounding, 1e-16, times the condition of a thin plate, 12 (L/h)^2 or 1e7, times what steps make of it."""


def check(found: tuple[np.ndarray, np.ndarray], expected: tuple[np.ndarray, np.ndarray]) -> None:
    np.testing.assert_allclose(found[0], expected[0], rtol=0, atol=CLOSE)
    np.testing.assert_allclose(found[1], expected[1], rtol=0, atol=CLOSE * np.abs(expected[1]).max(initial=0.0))


@pytest.mark.parametrize("seed", SEEDS)
def test_turned_and_moved_in_space(seed: int) -> None:
    world = World(turn=Rotation.random(random_state=seed), place=(2.0, -3.0, 1.0))
    check(ended(random_system(seed, world), world), ended(random_system(seed, World()), World()))


@pytest.mark.parametrize("seed", SEEDS)
def test_in_other_units(seed: int) -> None:
    """Millimetres, minutes and tonnes and the like: no tolerance is an absolute one."""
    m, s, kg = 10.0 ** np.random.default_rng(seed).uniform((-3, -2, -3), (3, 2, 3))
    world = World(m, s, kg)
    check(ended(random_system(seed, world), world), ended(random_system(seed, World()), World()))


def shuffled(system: System, seed: int) -> System:
    """The same parts in another order, what is referred to before what refers to it."""
    left, added, order = list(system.declarations), System("drop"), np.random.default_rng(seed)
    while left:
        names = {id(item) for item in left}
        ready = [item for item in left if not any(id(part) in names for part in referred(item))]
        item = ready[order.integers(len(ready))]
        added.add(item)
        left.remove(item)
    return added


def referred(item: Declaration) -> list[object]:
    found = []
    for value in vars(item).values():
        for part in (value, getattr(value, "body", None)):
            if isinstance(part, Declaration | Body) and part is not item:
                found += [part, *referred(part)]
    return found


@pytest.mark.parametrize("seed", SEEDS)
def test_named_in_another_order(seed: int) -> None:
    world = World()
    one = random_system(seed, world)
    other = shuffled(one, seed)
    assert len(other.declarations) == len(one.declarations)
    (positions, heat), (found, found_heat) = ended(one, world), ended(other, world)
    check((np.sort(found, axis=0), found_heat), (np.sort(positions, axis=0), heat))
