"""The study file of the example corrugator-study, and its findings on tables that are made up."""

from __future__ import annotations

import numpy as np
import pytest

from lamella.examples import examples
from lamella.examples.corrugator_study import study
from lamella.io.model_file import read_model
from lamella.sweep.study import read_study
from lamella.sweep.table import StudyResult
from lamella.sweep.task import Row

SOURCE = read_study(examples()["corrugator-study"].folder / "study.yaml")
UNITS = {"drift": "m/s", "tilt": "1", "edge_a": "N/m", "edge_b": "N/m", "driven": "rad/s"}


def made_up(failed: int = 0) -> StudyResult:
    """A machine whose drift goes with d + 0.1 d^3 of the force, with speed over root of friction, and by 0.1 mm/s for a mrad."""
    rows = []
    for number, row in enumerate(SOURCE.study.rows(), start=1):
        d = float(str(row["difference"]).split()[0]) / 1000.0
        drift = 1e-4 * d * (1.0 + 0.1 * d**2) * row["speed"] / np.sqrt(row["friction"]) + 1e-4 * row["misalignment"]
        values = {
            "drift": drift,
            "tilt": -3e-3 * d * (1.1 - row["friction"]) + 1e-3 * row["misalignment"],
            "edge_a": 6e3,
            "edge_b": 3e3,
            "driven": 10.0,
        }
        rows.append(Row(number, "failed", message="no") if number == failed else Row(number, "ok", values))
    return StudyResult(SOURCE.study, UNITS, rows)


def test_the_study_goes_with_its_model() -> None:
    assert SOURCE.checked().units == UNITS


def test_the_base_point_is_the_example_corrugator() -> None:
    own = read_model(examples()["corrugator-study"].model, SOURCE.study.settings(SOURCE.study.rows()[0])).system
    other = read_model(examples()["corrugator"].model).system
    mine, theirs = ({item.name: item for item in system.declarations} for system in (own, other))
    for end in "ab":
        pull = np.add(mine[f"pull_{end}"].force, mine[f"more_{end}"].force)
        np.testing.assert_allclose(pull, theirs[f"pull_{end}"].force)
    for name in ("roller1", "roller2", "roller3", "bearing1", "damper_a"):
        assert mine[name] == theirs[name]
    for k in (1, 2, 3):
        assert (mine[f"touch{k}"].mu, mine[f"touch{k}"].stiffness) == (theirs[f"touch{k}"].mu, theirs[f"touch{k}"].stiffness)
    assert mine["drive3"].speed.end == pytest.approx(theirs["drive3"].speed.end, rel=1e-4)
    assert mine["belt"].laminate == theirs["belt"].laminate


def test_roller_and_bearing_are_misaligned_together() -> None:
    row = next(row for row in SOURCE.study.rows() if row["misalignment"] == 2)
    items = {item.name: item for item in read_model(SOURCE.study.model, SOURCE.study.settings(row)).system.declarations}
    assert items["roller1"].rotation == pytest.approx((0.0, 2e-3, 0.0))
    axis = np.array(items["bearing1"].axis)
    np.testing.assert_allclose(axis / np.linalg.norm(axis), [np.sin(2e-3), 0.0, np.cos(2e-3)], atol=1e-8)


def test_findings_tell_what_the_table_says() -> None:
    result = made_up()
    forces, speeds, frictions, skew, runs = (
        study.forces(result),
        study.speeds(result),
        study.frictions(result),
        study.misalignments(result),
        study.runs(result),
    )
    assert [forces.agrees, speeds.agrees, frictions.agrees, skew.agrees, runs.agrees] == [True] * 5
    assert forces.numbers["drift for 2000 N over drift for 1000 N"] == pytest.approx(2.8 / 1.1, rel=1e-3)
    assert speeds.numbers["largest over smallest drift per metre"] == pytest.approx(1.0)
    assert frictions.numbers["largest over smallest drift"] == pytest.approx(np.sqrt(5.0), rel=1e-3)
    assert skew.numbers["drift for each mrad [mm/s]"] == pytest.approx(0.1)
    assert skew.numbers["tilt of roller 2 for each mrad of roller 1"] == pytest.approx(1.0)


def test_a_failed_run_is_told() -> None:
    result = made_up(failed=6)  # at 3 m/s
    assert not study.runs(result).agrees
    assert study.runs(result).numbers["failure 1"] == "run 6: no"
    assert "failed" in study.speeds(result).numbers.values()
    assert not study.speeds(result).agrees
