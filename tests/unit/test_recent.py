"""What an object keeps of the values it evaluated last, and that it is freed with them."""

from __future__ import annotations

import gc
import weakref

import numpy as np

import lamella as lm
from lamella.assembly.equations import Equations
from lamella.assembly.recent import Recent


def test_the_last_values_are_kept_and_the_oldest_goes_first():
    asked = []

    def value(x: float):
        asked.append(x)
        return np.array([x])

    recent = Recent(2)
    for x in (1.0, 2.0, 1.0, 3.0, 2.0, 1.0):
        assert recent.get(x, lambda x=x: value(x)) == [x]
    assert asked == [1.0, 2.0, 3.0, 1.0]
    recent.clear()
    recent.get(2.0, lambda: value(2.0))
    assert asked[-1] == 2.0


def test_what_was_solved_is_freed_without_the_garbage_collector():
    system = lm.System()
    plate = system.add(lm.Plate("plate", (1.0, 0.5), (2, 1), lm.Laminate(lm.Isotropic(E=70e9, nu=0.3, rho=2700), thickness=2e-3)))
    system.add(lm.Clamp("root", plate.edge("x-"), motion={"z": lm.Ramp(t_end=1.0, end=0.01)}))
    gc.disable()
    try:
        equations = Equations(system.compile())
        watched = weakref.ref(equations)
        result = lm.equilibrium(equations, t=0.5)
        assert result["root.force"].shape == (3,)
        del equations, result
        assert watched() is None
    finally:
        gc.enable()
