"""What makes the belt of a corrugating machine drift: a parameter study of one thing at a time, and what it tells."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from lamella.examples.corrugator_study import drawing
from lamella.examples.swing import Numbers, rounded
from lamella.examples.tables import run_study
from lamella.roles import Floats
from lamella.study.findings import Finding
from lamella.sweep.table import StudyResult

if TYPE_CHECKING:
    from lamella.study.study import Study

FILE = Path(__file__).parent / "study.yaml"
BASE = {"difference": 1000.0, "speed": 1.5, "friction": 0.3, "misalignment": 0.0}
UNITS = {"difference": "N", "speed": "m/s", "friction": "", "misalignment": "mrad"}
THICKNESS = 4e-3


def study(study: Study) -> Iterator[Finding]:
    """Run the parameter study, draw its outputs, and yield the findings."""
    result = run_study(study, FILE, "table")
    if study.draw:
        drawing.show_all(study, result)
    yield forces(result)
    yield speeds(result)
    yield frictions(result)
    yield misalignments(result)
    yield runs(result)


def along(result: StudyResult, name: str, output: str) -> tuple[Floats, Floats]:
    """A parameter in ascending order and an output over it, the others at the base point; NaN where a run failed."""
    others = [other for other in BASE if other != name]
    kept = np.all([np.isclose(result[other].astype(float), BASE[other]) for other in others], axis=0)
    x, y = result[name][kept].astype(float), result[output][kept]
    order = np.argsort(x, kind="stable")
    return x[order], y[order]


def at(result: StudyResult, name: str, output: str, value: float) -> float:
    """An output where one parameter has a value and the others are at the base point."""
    x, y = along(result, name, output)
    return float(y[np.argmin(np.abs(x - value))])


def listed(result: StudyResult, name: str) -> Numbers:
    """Drift, tilt and stresses of the edges over one parameter."""
    unit = UNITS[name]
    numbers: Numbers = {}
    for output, label, factor in (
        ("drift", "drift [mm/s]", 1e3),
        ("tilt", "tilt of roller 2, end b nearer [mrad]", -1e3),
        ("edge_a", "stress of edge a [MPa]", 1e-6 / THICKNESS),
        ("edge_b", "stress of edge b [MPa]", 1e-6 / THICKNESS),
    ):
        words, bracket = label.rsplit(" [", 1)
        for x, y in zip(*along(result, name, output), strict=True):
            numbers[f"{words}, {name} {x:g} {unit}".rstrip() + f" [{bracket}"] = factor * float(y) if np.isfinite(y) else "failed"
    return numbers


def forces(result: StudyResult) -> Finding:
    """Drift over the difference of the forces."""
    value = {x: at(result, "difference", "drift", x) for x in (-1000.0, 0.0, 1000.0, 2000.0)}
    tilt = {x: at(result, "difference", "tilt", x) for x in value}
    numbers = listed(result, "difference")
    numbers |= {
        "drift for -1000 N over drift for 1000 N": value[-1000.0] / value[1000.0],
        "drift for 2000 N over drift for 1000 N": value[2000.0] / value[1000.0],
        "tilt for 2000 N over tilt for 1000 N": tilt[2000.0] / tilt[1000.0],
    }
    return Finding(
        "The belt drifts towards the end that is pulled less: not at all with equal forces, oppositely with opposite ones, and "
        "with twice the difference by more than twice as much.",
        abs(value[0.0]) < 1e-3 * abs(value[1000.0])
        and abs(value[-1000.0] / value[1000.0] + 1.0) < 0.02
        and value[2000.0] > 2.0 * value[1000.0] > 0.0,
        rounded(numbers),
        "The machine is symmetric about its middle plane, so the drift is odd in the difference of the forces. Tilt and drift "
        "grow out of proportion as the edge that is pulled less comes near to being slack.",
    )


def speeds(result: StudyResult) -> Finding:
    """Drift over the speed."""
    x, y = along(result, "speed", "drift")
    per_metre = y / x
    numbers = listed(result, "speed")
    numbers |= {f"drift per metre of travel, {v:g} m/s [mm/m]": 1e3 * float(d) for v, d in zip(x, per_metre, strict=True)}
    numbers["largest over smallest drift per metre"] = float(per_metre.max() / per_metre.min())
    return Finding(
        "The drift grows with the speed.",
        bool(np.all(np.diff(y) > 0.0)),
        rounded(numbers),
        "A belt that sticks would drift by the same for each metre of travel, whatever the speed.",
    )


def frictions(result: StudyResult) -> Finding:
    """Drift over the coefficient of friction."""
    _, y = along(result, "friction", "drift")
    numbers = listed(result, "friction")
    numbers["largest over smallest drift"] = float(y.max() / y.min())
    tilts = along(result, "friction", "tilt")[1]
    numbers["largest over smallest tilt"] = float(tilts.min() / tilts.max())
    return Finding(
        "With more friction roller 2 tilts less and the belt drifts less.",
        bool(np.all(y > 0.0) and np.all(np.diff(y) < 0.0) and np.all(np.diff(tilts) > 0.0)),
        rounded(numbers),
        "What was found, not what was expected: balance of a belt that slides would give the same tilt for all. Friction along "
        "the rollers may carry a part of the difference of the forces.",
    )


def misalignments(result: StudyResult) -> Finding:
    """Drift over the misalignment of roller 1."""
    x, y = along(result, "misalignment", "drift")
    tilt = along(result, "misalignment", "tilt")[1]
    slope, offset = np.polyfit(x, y, 1)
    numbers = listed(result, "misalignment")
    numbers |= {
        "drift for each mrad [mm/s]": 1e3 * float(slope),
        "drift of an aligned machine by the straight line [mm/s]": 1e3 * float(offset),
        "largest distance from the straight line [mm/s]": 1e3 * float(np.abs(np.polyval([slope, offset], x) - y).max()),
        "tilt of roller 2 for each mrad of roller 1": float(np.polyfit(1e-3 * x, tilt, 1)[0]),
    }
    return Finding(
        "Roller 2, which is free to tilt, follows a misaligned roller 1 and so keeps the tensions of the edges.",
        abs(float(numbers["tilt of roller 2 for each mrad of roller 1"]) - 1.0) < 0.2,
        rounded(numbers),
        "What is left is the angle of roller 3 to both.",
    )


def runs(result: StudyResult) -> Finding:
    """Which runs gave something."""
    failed = [f"run {row.number}: {row.message}" for row in result.failures]
    numbers: Numbers = {"runs": float(len(result.rows)), "failed": float(len(failed))}
    numbers |= {f"failure {k}": text for k, text in enumerate(failed, start=1)}
    return Finding("Every run was computed to its end.", not failed, rounded(numbers), "")
