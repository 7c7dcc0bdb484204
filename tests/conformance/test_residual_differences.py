"""Differences of residuals by the parts that differ, against those of whole residuals."""

from __future__ import annotations

from functools import partial

import numpy as np
import pytest

import lamella as lm
from lamella.assembly.equations import Equations
from lamella.differentiation.difference import PartDifference, WholeDifference
from lamella.differentiation.neighbours import neighbours_of
from lamella.element.plate48.exact import ShellBlock


def plate(E=7e10, rho=2700.0, thickness=4e-3, force=-10.0, damping=0.0, length=0.6):
    """A plate that is pushed at its tip."""
    layup = lm.Laminate(lm.Isotropic(E, 0.3, rho), thickness=thickness)
    how = {"damping": damping} if damping else {}
    system = lm.System()
    panel = system.add(lm.Plate("panel", (length, 0.3), (2, 2), layup, **how))
    tip = panel.marker("tip", length, 0.1)
    system.add(lm.Clamp("root", panel.edge("x-")))
    system.add(lm.PointForce("push", tip, (0.0, 0.0, force)))
    return system


ROUNDING = 1e-8
"""Of differences of whole residuals over 4e-4 of the parameter, beside the residual: their parts are larger than their sum."""
AT = {"E": 7e10, "rho": 2700.0, "thickness": 4e-3, "force": -10.0, "length": 0.6}


def neighbours(name, **more):
    made = partial(plate, **more)
    base = Equations(made().compile())
    value = AT.get(name, more.get(name))
    return base, neighbours_of(name, base, value, abs(value), lambda x: made(**{name: x}))


def moved(base):
    n = np.arange(base.n_u)
    point = base.start()
    point.u += 1e-3 * np.sin(n) * base.magnitude
    point.ud, point.udd = np.cos(n) * base.magnitude, 10.0 * np.sin(2.0 * n) * base.magnitude
    return point, np.sin(3.0 * n) * base.magnitude, np.cos(5.0 * n) * base.magnitude


@pytest.mark.parametrize("damping", [0.0, 2e-3])
@pytest.mark.parametrize("name", AT)
def test_parts_are_as_good_as_the_whole(name, damping):
    base, beside = neighbours(name, damping=damping)
    assert isinstance(beside.residual, PartDifference)
    whole = WholeDifference(beside.sides)
    point, dud, dudd = moved(base)
    scale, still = 1.0 / AT[name], base.start(at_rest=True)
    still.u, still.factor = point.u, 0.7
    for at, rates in ((still, (None, None)), (point, (None, None)), (point, (scale * dud, scale * dudd))):
        expected, found = (each(at, *rates)[0] for each in (whole, beside.residual))
        largest = np.abs(base.residual(at)[0]).max() * abs(scale)
        np.testing.assert_allclose(found, expected, atol=ROUNDING * largest)


def test_forces_that_a_parameter_leaves_alone_are_not_evaluated(monkeypatch):
    base, beside = neighbours("force")
    point, dud, dudd = moved(base)
    expected = WholeDifference(beside.sides)(point, dud, dudd)[0]

    def refuse(*_):
        raise AssertionError("evaluated")

    monkeypatch.setattr(ShellBlock, "force", refuse)
    np.testing.assert_allclose(beside.residual(point, dud, dudd)[0], expected, atol=1e-6 * np.abs(expected).max())


@pytest.mark.parametrize(("name", "times"), [("force", 0), ("rho", 0), ("E", 1), ("thickness", 1), ("length", 4)])
def test_a_stiffness_takes_one_force_for_all_sides(name, times, monkeypatch):
    """Forces are linear in the stiffness of a section: their difference is the force with the difference of the stiffness."""
    base, beside = neighbours(name)
    evaluated, force = [], ShellBlock.force

    def counted(*arguments):
        evaluated.append(1)
        force(*arguments)

    monkeypatch.setattr(ShellBlock, "force", counted)
    beside.residual(*moved(base))
    assert len(evaluated) == times


def test_blocks_of_other_elements_or_times_have_no_sum():
    first, longer = (plate(length=length).compile().forces[0] for length in (0.6, 0.7))
    assert first.weighed([first], [0.5, 0.5]) is not None
    assert first.weighed([longer], [0.5, 0.5]) is None
    slow, fast = (plate(damping=damping).compile().forces[0].symmetric_form for damping in (1e-3, 2e-3))
    assert slow.weighed([slow], [0.5, 0.5]) is not None
    assert slow.weighed([fast], [0.5, 0.5]) is None
    assert first.weighed([slow], [0.5, 0.5]) is None
