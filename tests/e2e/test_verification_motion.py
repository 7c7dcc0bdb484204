"""The verification cases of modes and motion pass; the long ones run with the slow tests."""

from __future__ import annotations

import pytest

from lamella.verification import find_cases, run_cases
from lamella.viz.case_pictures import drawn

CASES = (
    "belt-running",
    "block-on-plane",
    "capstan",
    "damping",
    "distance-joint",
    "energy-balance",
    "flexible-slider-crank",
    "free-flight",
    "free-plate-modes",
    "frequencies",
    "integrator-order",
    "invariance",
    "p1-motion",
    "p2-motion",
    "drive-work",
    "four-bar",
    "heat-conduction",
    "joint-order",
    "linear-step-response",
    "pendulums",
    "plate-pendulum",
    "rigid-array",
    "rolling",
    "slider-crank",
    "spinning-top",
    "sunlight",
    "thermal-panel",
    "torque-free-spin",
)


@pytest.mark.parametrize(
    "case",
    [pytest.param(case, marks=pytest.mark.slow if case.slow else (), id=case.name) for case in find_cases(CASES)],
)
def test_case_passes(case):
    (outcome,) = run_cases([case])
    assert not outcome.failure
    missed = [f"{c.quantity}: {c.value:.7g} instead of {c.reference:.7g}" for c in outcome.checks if not c.passed]
    assert not missed
    assert outcome.passed
    assert all(drawn(picture).startswith("data:image/") for picture in outcome.pictures)


@pytest.mark.parametrize("case", find_cases(CASES), ids=lambda case: case.name)
def test_case_has_a_title(case):
    assert case.title != case.name
