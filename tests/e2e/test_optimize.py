"""Optimisations as a user runs them: files, failures, interruptions, tables and pages."""

from __future__ import annotations

import csv
import subprocess
from collections.abc import Callable
from pathlib import Path

import pytest

import lamella as lm
import lamella.optimisation.run
from lamella.errors import DeclarationError

Command = Callable[..., subprocess.CompletedProcess[str]]

MODEL = """\
lamella: 1
system:
  strip:
    type: plate
    size: [0.5 m, 0.1 m]
    mesh: [3, 1]
    laminate: {ply: {type: isotropic, E: 70 GPa, nu: 0.0, rho: 2700}, thickness: 2 mm}
    markers: {tip: [0.5 m, 0.05 m]}
  root: {type: clamp, on: strip.x-}
  load: {type: point_force, on: strip.tip, force: [0, 0, -0.1 N]}
analysis:
  still: {type: statics}
  modes: {type: natural_modes, count: 1}
"""
OPTIMIZE = """\
optimize: 1
title: The lightest strip
model: strip.yaml
parameters:
  thickness: {path: system.strip.laminate.thickness, range: [1 mm, 5 mm]}
start: {thickness: 4 mm}
outputs:
  sag: {kind: signal, signal: tip.position, component: z}
  frequency: {kind: shape}
  mass: {kind: mass}
objective: {output: mass}
constraints:
  sag: {min: -1 mm}
"""


@pytest.fixture
def file(tmp_path: Path) -> Path:
    (tmp_path / "strip.yaml").write_text(MODEL)
    path = tmp_path / "lightest.yaml"
    path.write_text(OPTIMIZE)
    return path


def designs(folder: Path) -> list[dict[str, str]]:
    with (folder / "history.csv").open(newline="") as table:
        return list(csv.DictReader(table))


def test_the_lightest_strip_is_that_of_beam_theory(
    here: Command, file: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("LAMELLA_RENDERER", "matplotlib")
    done = here("optimize", file, "--out", "out")
    assert done.returncode == 0, done.stderr
    assert "converged after" in done.stdout
    best = (4 * 0.1 * 0.5**3 / (70e9 * 0.1 * 1e-3)) ** (1 / 3)  # F L^3 / (3 E b h^3 / 12) = 1 mm
    last = designs(tmp_path / "out")[-1]
    assert float(last["thickness [mm]"]) == pytest.approx(1e3 * best, rel=1e-4)  # a sag of 0.2 % of the length: its square
    assert float(last["mass [kg]"]) == pytest.approx(2700 * 0.05 * best, rel=1e-4)
    assert {path.name for path in (tmp_path / "out").iterdir()} >= {"history.parquet", "best.yaml", "best", "report.html"}
    assert (tmp_path / "out" / "pictures" / "search.png").stat().st_size > 1000
    page = (tmp_path / "out" / "report.html").read_text("utf-8")
    assert "The lightest strip" in page
    assert page.count("data:image/png") >= 2
    again = here("optimize", file, "--out", "out")
    assert again.returncode == 2
    assert "holds results already" in again.stderr


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("laminate.thickness", "laminat.thickness", "line 5"),
        ("signal: tip.position", "signal: top.position", "did you mean 'tip.position'"),
        ("signal: tip.position, component: z", "signal: work.loads", "sums over the steps"),
        ("[1 mm, 5 mm]", "[5 mm, 1 mm]", "a lower value before a higher one"),
        ("{thickness: 4 mm}", "{thickness: 6 mm}", "accepted is 1 to 5 mm"),
        ("{thickness: 4 mm}", "{thicknes: 4 mm}", "did you mean 'thickness'"),
        ("{output: mass}", "{output: mas}", "line 11, objective: there is no output 'mas'; did you mean 'mass'"),
        ("{output: mass}", "{output: mass, goal: target}", "a target with the goal"),
        ("{min: -1 mm}", "{min: -1 kg}", "does not convert to m"),
        ("{min: -1 mm}", "{min: 2 mm, max: 1 mm}", "a lower value before a higher one"),
        (
            "start: {thickness: 4 mm}",
            "  again: {path: system.strip.laminate.thickness, range: [1 mm, 2 mm]}",
            "again: the path system.strip.laminate.thickness is that of the parameter 'thickness' already",
        ),
        ("objective", "method: l-bfgs-b\nobjective", "knows no constraints"),
        ("optimize: 1\n", "", "'optimize: 1' is missing"),
        ("{kind: mass}", "{kind: mass, body: stirp}", "there is no body 'stirp' with mass; did you mean"),
        ("outputs:", "outputs:\n  mass [kg]: {signal: load.factor}", "outputs.mass: the table has a column 'mass [kg]' already"),
        ("parameters:\n  thickness", "parameters:\n  seconds", "the table has a column 'seconds' of its own"),
    ],
)
def test_errors_come_before_anything_is_run(here: Command, file: Path, tmp_path: Path, old: str, new: str, said: str) -> None:
    file.write_text(OPTIMIZE.replace(old, new, 1))
    done = here("optimize", file, "--out", "out")
    assert done.returncode == 2
    assert said in done.stderr
    assert not (tmp_path / "out").exists()


def test_a_design_that_fails_is_told_and_the_others_are_kept(here: Command, file: Path, tmp_path: Path) -> None:
    """A search for a low frequency leads to a thickness that no laminate may have."""
    text = OPTIMIZE.replace("[1 mm, 5 mm]", "[-1 mm, 5 mm]").replace("{output: mass}", "{output: mass, goal: minimize}")
    file.write_text(text.replace("constraints:\n  sag: {min: -1 mm}\n", ""))
    done = here("optimize", file, "--out", "out", "--no-pictures")
    assert done.returncode == 2
    assert "the model fails at thickness = -1 mm" in done.stderr
    assert "the best at thickness = " in done.stderr
    assert [row["status"] for row in designs(tmp_path / "out")] == ["ok", "failed"]


def test_limits_that_no_design_meets_are_told(here: Command, file: Path) -> None:
    file.write_text(OPTIMIZE.replace("{min: -1 mm}", "{min: -1 um}"))
    done = here("optimize", file, "--out", "out", "--no-pictures", "--quiet")
    assert done.returncode == 2
    assert "no design that meets the constraints was found" in done.stderr


@pytest.mark.parametrize("method", ["l-bfgs-b", "trust-constr"])
def test_other_methods_and_a_target(file: Path, tmp_path: Path, method: str) -> None:
    problem = lm.Optimisation(
        model=str(tmp_path / "strip.yaml"),
        parameters={"thickness": lm.Parameter("system.strip.laminate.thickness", range=("1 mm", "5 mm"), scale="log")},
        outputs={"frequency": lm.ShapeOutput(1)},
        objective=lm.Objective("frequency", goal="target", target="10 Hz"),
        method=method,  # type: ignore[arg-type]
        tolerance=1e-9,
    )
    found = lm.run_optimisation(problem, tmp_path / "out", pictures=False)
    assert found.converged
    assert found.best.outputs["frequency"] == pytest.approx(10.0, rel=1e-3)  # the square of the distance is flat there
    assert found["thickness"][-1] == pytest.approx(found.best.values["thickness"], rel=1e-3)
    with pytest.raises(DeclarationError, match="no output or parameter"):
        found["sag"]


def test_a_wide_range_may_begin_at_a_small_value(file: Path, tmp_path: Path) -> None:
    """The models beside it are so by a share of the value: one of the range would make the density negative."""
    density = lm.Parameter("system.strip.laminate.ply.rho", range=(1e-2, 1e5), scale="log")
    problem = lm.Optimisation(
        model=str(tmp_path / "strip.yaml"),
        parameters={"density": density},
        outputs={"mass": lm.MassOutput()},
        objective=lm.Objective("mass", goal="target", target="100 g"),
        start={"density": 1.0},
        tolerance=1e-12,
    )
    found = lm.run_optimisation(problem, tmp_path / "out", pictures=False)
    assert found.best.values["density"] == pytest.approx(1000.0, rel=1e-3)  # 0.1 kg in 0.5 m by 0.1 m by 2 mm


def test_an_interruption_keeps_the_designs(file: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    real, calls = lamella.optimisation.run.differentiated, []

    def interrupted(*arguments: object) -> object:
        calls.append(1)
        if len(calls) == 3:
            raise KeyboardInterrupt
        return real(*arguments)  # type: ignore[arg-type]

    monkeypatch.setattr(lamella.optimisation.run, "differentiated", interrupted)
    from lamella.optimisation.problem import read_optimisation

    with pytest.raises(KeyboardInterrupt, match="2 designs are kept"):
        lm.run_optimisation(read_optimisation(file), tmp_path / "out")
    assert len(designs(tmp_path / "out")) == 2
