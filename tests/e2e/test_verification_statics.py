"""The verification cases of statics pass, and notice a formulation that is wrong."""

from __future__ import annotations

import numpy as np
import pytest

from lamella.material.laminate import Laminate
from lamella.verification.runner import find_cases, run_case
from lamella.viz.case_pictures import drawn

CASES = (
    "belt-two-rollers",
    "hinged-roofs",
    "liu-laminates",
    "membrane-locking",
    "p1-static",
    "p2-static",
    "pagano-laminate",
    "patch",
    "pinched-cylinder",
    "plate36",
    "plate-closed-forms",
    "ring",
    "spinning-ring",
    "curved-shells",
    "shell-sections",
    "buckling",
    "scordelis-lo",
    "spin-stiffening",
    "strain-models",
    "sze-cantilever",
    "sze-roll-up",
    "sze-slit-annulus",
    "thermal-strain",
    "unsymmetric-laminate",
)


@pytest.mark.parametrize(
    "case", [pytest.param(case, marks=pytest.mark.slow if case.slow else (), id=case.name) for case in find_cases(CASES)]
)
def test_case_passes(case):
    outcome = run_case(case)
    failed = [
        f"{c.quantity}: {c.value} against {c.reference}, error {c.error} > {c.tolerance}" for c in outcome.checks if not c.passed
    ]
    assert not outcome.failure
    assert outcome.checks
    assert not failed
    assert all(drawn(picture).startswith("data:image/") for picture in outcome.pictures)


def test_the_other_sign_of_coupling_is_noticed(monkeypatch):
    flipped = property(lambda self: np.block([[self.A, self.B], [self.B, self.D]]))
    monkeypatch.setattr(Laminate, "stiffness", flipped)
    (case,) = find_cases(["unsymmetric-laminate"])
    failed = {check.quantity for check in run_case(case).checks if not check.passed}
    assert {
        "kap_x under pull, strain = exact",
        "kap_x under pull, strain = linear",
        "eps_x under moment, strain = linear",
    } <= failed


def test_the_other_sign_of_thermal_bending_is_noticed(monkeypatch):
    exact = Laminate.thermal_moments.func
    monkeypatch.setattr(Laminate, "thermal_moments", property(lambda self: exact(self) * [[1.0], [-1.0], [-1.0]]))
    (case,) = find_cases(["thermal-strain"])
    failed = {check.quantity for check in run_case(case).checks if not check.passed}
    assert {"kap_x for T_M = 1", "z of the tip of the quarter circle", "curvature of the bimetal, nu = 0"} <= failed


def test_a_softer_section_is_noticed(monkeypatch):
    exact = Laminate.stiffness.func
    monkeypatch.setattr(Laminate, "stiffness", property(lambda self: 0.99 * exact(self)))
    (case,) = find_cases(["sze-cantilever"])
    assert not run_case(case).passed
