"""Checks, references and the runner of the verification cases."""

from __future__ import annotations

import math
import sys
from pathlib import Path

import numpy as np
import pytest

from lamella.errors import DeclarationError, ModelError
from lamella.verification import Check, References, find_cases, run_cases

TOML = """\
title = "Two numbers"
source = "Somebody (1999), table 1"
[quantities."sag"]
value = 2.0
unit = "m"
tolerance = 0.01
reason = "three digits"
[quantities."path"]
at = [0.5, 1.0]
value = [1.0, 2.0]
tolerance = 0.1
kind = "absolute"
reason = "read from a figure"
"""


@pytest.mark.parametrize(
    ("value", "reference", "tolerance", "kind", "error", "passed"),
    [
        (1.01, 1.0, 0.02, "relative", 0.01, True),
        (-1.03, -1.0, 0.02, "relative", 0.03, False),
        (1e-3, 0.0, 1e-2, "absolute", 1e-3, True),
        (3.0, 2.5, 0.0, "at most", 0.5, False),
        (2.0, 2.5, 0.0, "at most", 0.0, True),
        (1.9, 2.0, 0.2, "at least", 0.1, True),
        (math.nan, 1.0, 1.0, "relative", math.inf, False),
        (math.inf, 1.0, 1.0, "at least", math.inf, False),
    ],
)
def test_error_and_verdict(value, reference, tolerance, kind, error, passed) -> None:
    check = Check("q", value, reference, tolerance, kind)
    assert check.error == pytest.approx(error, abs=1e-15)
    assert check.passed is passed


def test_numbers_of_numpy_become_plain_ones() -> None:
    check = Check("q", np.float64(1.0), np.float64(2.0), np.float64(0.1))
    assert type(check.value) is float
    assert type(check.passed) is bool


def test_impossible_checks_are_refused() -> None:
    with pytest.raises(DeclarationError, match="accepted is kind='absolute'"):
        Check("q", 1.0, 0.0, 0.1)
    with pytest.raises(DeclarationError, match="tolerance = nan"):
        Check("q", 1.0, 1.0, math.nan)
    with pytest.raises(DeclarationError, match="kind = 'about'"):
        Check("q", 1.0, 1.0, 0.1, "about")  # type: ignore[arg-type]


@pytest.fixture
def cases(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A package of three cases: one that passes, one that breaks, one that is slow and checks nothing."""
    folder = tmp_path / "some_cases"
    texts = {
        "good_one": "    refs = References.beside(__file__)\n"
        "    yield refs.check('sag', 2.01)\n"
        "    yield from refs.checks('path', [1.0, 2.05])\n",
        "broken": "    yield Check('first', 1.0, 1.0, 0.1)\n    raise ValueError('no convergence')\n",
        "slow_one": "    return []\nslow = True\n",
    }
    for name, body in texts.items():
        (folder / name).mkdir(parents=True)
        (folder / name / "case.py").write_text(f"from lamella.verification import Check, References\ndef run():\n{body}")
        (folder / name / "reference.toml").write_text(TOML)
        (folder / name / "README.md").write_text(f"# Title of {name}\n")
    monkeypatch.syspath_prepend(tmp_path)
    yield folder
    for module in [name for name in sys.modules if name.startswith("some_cases")]:
        del sys.modules[module]


def test_cases_are_found_and_run(cases: Path) -> None:
    found = find_cases(folder=cases, package="some_cases")
    assert [(case.name, case.title, case.slow) for case in found] == [
        ("broken", "Title of broken", False),
        ("good-one", "Title of good_one", False),
        ("slow-one", "Title of slow_one", True),
    ]
    broken, good, empty = run_cases(found)
    assert [check.quantity for check in good.checks] == ["sag", "path at 0.5", "path at 1"]
    assert good.passed
    assert good.checks[0].source == "Somebody (1999), table 1"
    assert [row["passed"] for row in broken.rows()] == [True, False]  # what came before the error is kept
    assert "stopped by ValueError: no convergence (case.py, line 4)" in broken.rows()[1]["quantity"]
    assert not empty.passed
    assert empty.rows()[0]["quantity"] == "the case made no check"


def test_names_are_taken_with_either_dash(cases: Path) -> None:
    assert [case.name for case in find_cases(["slow_one", "good-one"], cases, "some_cases")] == ["slow-one", "good-one"]
    with pytest.raises(
        ModelError, match=r"no verification case 'god-one'; did you mean 'good-one'\? There are: broken, good-one, slow-one"
    ):
        find_cases(["god-one"], cases, "some_cases")


def test_wrong_reference_files_are_refused(tmp_path: Path) -> None:
    file = tmp_path / "reference.toml"
    file.write_text('[quantities."sag"]\nvalue = 1.0\ntolerance = 0.1\n')
    with pytest.raises(DeclarationError, match=r"missing \['reason'\]"):
        References.beside(str(tmp_path / "case.py"))
    file.write_text(TOML)
    with pytest.raises(DeclarationError, match="no quantity 'sgg'; there are sag, path"):
        References.beside(str(tmp_path / "case.py")).check("sgg", 1.0)
