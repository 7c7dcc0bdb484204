"""The commands of ``lamella``, from end to end."""

from __future__ import annotations

import csv
import json
import signal
import subprocess
import sys
import time
from pathlib import Path

import h5py
import numpy as np
import pytest

from lamella import threads
from lamella.errors import ResultFileError
from lamella.io.results import read_result

HEAVY = (
    "numba",
    "numpy",
    "scipy",
    "matplotlib",
    "pint",
    "h5py",
    "xarray",
    "pyvista",
    "ruamel",
)  # typer itself may import pydantic
PENDULUM = """\
lamella: 1
title: Pendulum
redundant: drop
system:
  ground: {type: ground}
  bob:
    type: rigid_body
    shape: {kind: box, size: [0.2, 0.2, 0.2]}
    density: 1000
    position: [0.5, 0, 0]
    markers: {eye: [-0.5, 0, 0]}
  arm: {type: rigid_body, mass: 1, inertia: [0.1, 0.1, 0.1], markers: {end: [0.5, 0, 0]}}
  pin: {type: revolute_joint, a: ground.origin, b: arm.origin, axis: [0, 1, 0]}
  weld: {type: fixed_joint, a: arm.end, b: bob.origin}
  second: {type: revolute_joint, a: arm.origin, b: bob.eye, axis: [0, 1, 0]}
  weight: {type: gravity}
analysis:
  swing: {type: motion, t_end: 20 ms, integrator: {dt: 1 ms}}
output: {frames: 4, signals: [pin.force, pin.torque, pin.force_local, bob.rotation]}
"""
COMMANDS = ("run", "new", "examples", "info", "verify", "bench", "plot", "export", "doctor", "schema")


@pytest.mark.parametrize("words", [[], *([command] for command in COMMANDS), ["examples", "list"], ["examples", "copy"]])
def test_help_imports_nothing_heavy(words: list[str]) -> None:
    code = (
        "import sys; from lamella.cli.main import run_app; run_app([*sys.argv[1:], '--help']); "
        f"print('HEAVY', *(name for name in {HEAVY} if name in sys.modules))"
    )
    done = subprocess.run([sys.executable, "-c", code, *words], capture_output=True, text=True, timeout=60, check=True)
    assert "Usage:" in done.stdout
    assert done.stdout.splitlines()[-1].split() == ["HEAVY"]


def test_a_run_imports_nothing_it_does_not_need(model: Path, tmp_path: Path) -> None:
    """Benchmarks, studies over parameters and their libraries take a second to import, Pint half of one."""
    idle = (
        "pint",
        "lamella.bench",
        "lamella.sweep",
        "lamella.optimisation",
        "lamella.verification",
        "scipy.stats",
        "xarray",
        "dask.array",
    )
    code = (
        "import sys; from lamella.cli.main import run_app; run_app(['run', *sys.argv[1:], '--no-pictures', '-q']); "
        f"print('IDLE', *(name for name in {idle} if name in sys.modules))"
    )
    command = [sys.executable, "-c", code, str(model), "--overwrite", "--out", str(tmp_path / "out")]
    subprocess.run(command, capture_output=True, timeout=120, check=True)  # the first has Pint read the quantities
    done = subprocess.run(command, capture_output=True, text=True, timeout=120, check=True)
    assert done.stdout.splitlines()[-1].split() == ["IDLE"]


def test_help_names_every_command(lamella) -> None:
    text = lamella("--help").stdout
    for command in COMMANDS:
        assert f" {command} " in text


def test_run_leaves_results_pictures_and_report(lamella, model: Path, tmp_path: Path) -> None:
    done = lamella("run", model, "--out", "out", "--set", "system.strip.mesh=[3, 1]")
    assert done.returncode == 0, done.stderr
    out = tmp_path / "out"
    files = {path.relative_to(out).as_posix() for path in out.rglob("*") if path.is_file()}
    pictures = {"pictures/signals.png", "pictures/energy.png", "pictures/shape.png", "animation.gif", "report.html"}
    assert files == {"run.h5", "model.yaml", "signals.csv", "surface.vtkhdf"} | pictures
    for name in files:
        assert name in done.stdout
    assert "completed at 0.02" in done.stdout
    assert "swing: completed" in done.stderr
    result = read_result(out / "run.h5")
    assert result.title == "Small strip"
    assert result.model.plates[0].nx == 3  # the stored model is the one with the override
    assert len(result.at) == 21
    with (out / "signals.csv").open() as file:
        rows = list(csv.reader(file))
    column = rows[0].index("tip.position.z [m]")
    assert np.allclose([float(row[column]) for row in rows[1:]], result.history("tip.position").values[:, 2], rtol=1e-12)
    report = (out / "report.html").read_text()
    assert "Small strip" in report
    assert 'src="http' not in report


THROWN = """\
lamella: 1
system:
  ground: {type: ground, markers: {peg: [0, 0, 1 m]}}
  ball: {type: rigid_body, mass: 1 kg, inertia: [0.1, 0.1, 0.1], velocity: [0.3, 0, 1], markers: {eye: [0, 0, 0]}}
  rod: {type: distance_joint, a: ground.peg, b: ball.eye}
  far: {type: event, watch: ball.position, component: x, value: 0.001, action: stop}
analysis:
  swing: {type: motion, t_end: 5 ms}
output: {pictures: false, animation: false, report: false, paraview: false, csv: false}
"""


def test_a_start_that_had_to_be_changed_and_events_are_told(here, tmp_path: Path) -> None:
    (tmp_path / "thrown.yaml").write_text(THROWN)
    event = "0.00333333 s: far: stop: x of ball.position passes 0.001"  # 1 mm at 0.3 m/s
    note = "the initial velocities were changed to obey supports and joints, by up to 1 m/s (the position of rigid body 'ball')"
    said = here("run", "thrown.yaml", "--out", "out").stdout
    assert f"swing: {note}" in said
    assert f"swing: {event}" in said
    said = here("info", "out").stdout
    assert note in said
    assert event in said


def test_several_analyses_have_folders_of_their_own(here, tmp_path: Path) -> None:
    assert here("new", "bent", "--template", "statics").returncode == 0
    done = here("run", "bent.yaml", "--out", "out", "--no-pictures", "--quiet")
    assert done.returncode == 0, done.stderr
    assert done.stdout == done.stderr == ""
    assert (tmp_path / "out/still/run.h5").is_file()
    rows = list(csv.reader((tmp_path / "out/modes/modes.csv").open()))
    frequencies = [float(row[1]) for row in rows[1:]]
    assert len(frequencies) == 6
    assert frequencies == sorted(frequencies)
    assert not list(tmp_path.rglob("*.png"))


def test_a_second_run_does_not_replace_results_unasked(here, model: Path, tmp_path: Path) -> None:
    assert here("run", model, "--out", "out", "--no-pictures").returncode == 0
    (tmp_path / "out/notes.txt").write_text("mine")
    before = (tmp_path / "out/run.h5").stat().st_mtime_ns
    done = here("run", model, "--out", "out", "--no-pictures")
    assert done.returncode == 2
    assert "'out' holds results already; give --overwrite" in done.stderr
    assert (tmp_path / "out/run.h5").stat().st_mtime_ns == before
    assert here("run", model, "--out", "out", "--no-pictures", "--overwrite").returncode == 0
    assert (tmp_path / "out/run.h5").stat().st_mtime_ns != before
    assert (tmp_path / "out/notes.txt").read_text() == "mine"


def test_interrupted_run_leaves_a_valid_file(model: Path, tmp_path: Path, environment: dict[str, str]) -> None:
    words = ["run", model, "--out", "out", "--no-pictures", "--set", "analysis.swing.t_end=1000 s"]
    process = subprocess.Popen(
        [sys.executable, "-m", "lamella", *words], cwd=tmp_path, env=environment, stderr=subprocess.PIPE, text=True
    )
    deadline = time.monotonic() + 300
    file = tmp_path / "out/run.h5"
    while time.monotonic() < deadline and not _samples(file):
        time.sleep(0.2)
    process.send_signal(signal.SIGINT)
    _, errors = process.communicate(timeout=60)
    assert process.returncode == 130, errors
    assert "analysis 'swing' stopped at" in errors
    assert "of 1000: interrupted by the user" in errors
    result = read_result(file)
    assert result.outcome.cause.name == "INTERRUPTED"
    assert result.outcome.reached == result.at[-1] > 0
    assert result.outcome.target == 1000
    assert (tmp_path / "out/signals.csv").is_file()
    with h5py.File(file) as stored:
        assert len(stored["signals/tip.position"]) == len(stored["signals/time"])


def _samples(path: Path) -> int:
    """Samples flushed to a file that may still be written."""
    try:
        return len(read_result(path).at)
    except ResultFileError:  # not there yet, or in the middle of a flush
        return 0


def test_new_writes_a_file_that_runs_and_a_schema(here, tmp_path: Path) -> None:
    assert "cantilever" in here("new", "--list").stdout
    done = here("new", "wing")
    assert done.returncode == 0
    text = (tmp_path / "wing.yaml").read_text()
    assert text.startswith("# yaml-language-server: $schema=lamella.schema.json\n")
    assert json.loads((tmp_path / "lamella.schema.json").read_text()) == json.loads(here("schema").stdout)
    assert here("info", "wing.yaml").returncode == 0
    again = here("new", "wing")
    assert again.returncode == 2
    assert "'wing.yaml' exists already" in again.stderr
    assert "did you mean 'cantilever'" in here("new", "x", "--template", "cantilver").stderr


def test_result_can_be_looked_at_plotted_and_exported(here, model: Path, tmp_path: Path) -> None:
    assert here("run", model, "--out", "out", "--no-pictures").returncode == 0
    shown = here("info", "out").stdout
    assert "completed at 0.02; 21 samples over time" in shown
    assert "tip.position.z" in shown
    assert "point_force" in shown
    assert here("plot", "out", "tip.position.z", "--out", "tip.svg").returncode == 0
    assert (tmp_path / "tip.svg").read_text().lstrip().startswith("<?xml")
    (tmp_path / "out/signals.csv").unlink()
    for form, name in {"vtkhdf": "surface.vtkhdf", "csv": "signals.csv", "yaml": "model.yaml", "html": "report.html"}.items():
        done = here("export", "out", "--to", form)
        assert done.returncode == 0, done.stderr
        assert name in done.stdout
        assert (tmp_path / "out" / name).is_file()
    wrong = here("export", "out", "--to", "vtkhfd")
    assert wrong.returncode == 2
    assert "did you mean 'vtkhdf'" in wrong.stderr
    missing = here("plot", "out", "tip.positon")
    assert missing.returncode == 2
    assert "tip.positon" in missing.stderr


def test_multibody_template_runs_and_its_bodies_are_shown(here, tmp_path: Path) -> None:
    assert here("new", "swing", "--template", "multibody").returncode == 0
    done = here("run", "swing.yaml", "--out", "out", "--set", "analysis.swing.t_end=0.05 s", "--set", "output.frames=4")
    assert done.returncode == 0, done.stderr
    result = read_result(tmp_path / "out/run.h5")
    angle = result.history("pin.angle").values
    assert angle[0] == 0
    assert angle[-1] > 0.001  # it swings down, right-handed about y
    np.testing.assert_allclose(result.history("root.force").values[0] * [1, 1, 0], 0.0, atol=1e-6)  # released at rest
    with h5py.File(tmp_path / "out/surface.vtkhdf") as file:
        assert set(file["VTKHDF/CellData/rigid_body"][()]) == {-1, 0}
        assert set(file["VTKHDF/CellData/plate"][()]) == {-1, 0}
    report = (tmp_path / "out/report.html").read_text()
    for words in ("Recorded signals", "rigid bodies", "degrees of freedom", "revolute_joint"):
        assert words in report
    shown = here("info", "out").stdout
    assert "root.torque_local.z" in shown
    assert "plates 1, rigid bodies 1, joints and supports 2, loads 1, coordinates 264, " in shown
    assert "multipliers 6, degrees of freedom 217" in shown


def test_system_without_plates_leaves_a_report_with_reactions(here, tmp_path: Path) -> None:
    (tmp_path / "pendulum.yaml").write_text(PENDULUM)
    done = here("run", "pendulum.yaml", "--out", "out")
    assert done.returncode == 0, done.stderr
    out = tmp_path / "out"
    files = {path.relative_to(out).as_posix() for path in out.rglob("*") if path.is_file()}
    pictures = {"pictures/signals.png", "pictures/energy.png", "pictures/shape.png", "animation.gif", "report.html"}
    assert files == {"run.h5", "model.yaml", "signals.csv", "surface.vtkhdf"} | pictures
    report = (out / "report.html").read_text()
    assert report.count("<img") == 4
    left_out = (
        "left out as redundant: x of the distance of the points of second (follows from x of the distance of the points of weld)"
    )
    assert left_out in report
    assert left_out in here("info", "out").stdout
    with (out / "signals.csv").open() as file:
        heading = next(csv.reader(file))
    assert {"pin.force_local.x [N]", "bob.rotation.zz [1]", "pin.angle [rad]"} <= set(heading)
    assert here("export", "out", "--to", "vtkhdf").returncode == 0
    bare = ["--set", "system.bob.shape=null", "--set", "system.bob.mass=1", "--set", "system.bob.inertia=[0.1, 0.1, 0.1]"]
    done = here("run", "pendulum.yaml", "--out", "bare", *bare, "--set", "system.bob.density=null")
    assert done.returncode == 0, done.stderr  # nothing to draw, and a report all the same
    files = {path.name for path in (tmp_path / "bare").rglob("*") if path.is_file()}
    assert files == {"run.h5", "model.yaml", "signals.csv", "signals.png", "energy.png", "report.html"}


def test_verify_lists_runs_and_refuses_unknown_cases(here) -> None:
    names = [entry["case"] for entry in json.loads(here("verify", "--list", "--json").stdout)]
    assert names
    wrong = here("verify", "no-such-case")
    assert wrong.returncode == 2
    for name in names:
        assert name in wrong.stderr


def test_threads_of_a_run(here, tmp_path: Path, model: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    used: list[int] = []
    monkeypatch.setattr(threads, "use", lambda count, use=threads.use: (used.append(count), use(count)))
    try:
        done = here("run", model, "--out", "out", "--threads", "2", "--no-pictures", "--quiet")
        assert done.returncode == 0, done.stderr
        assert used[0] == 2
        for wrong in ("0", "-1", "two"):
            refused = here("run", model, "--out", "other", "--threads", wrong)
            assert refused.returncode == 2
            assert "Invalid value for '--threads'" in refused.stderr
            assert "greater than or equal to 1" in refused.stderr or "valid int" in refused.stderr
        monkeypatch.setenv("LAMELLA_THREADS", "none")
        refused = here("run", model, "--out", "other")
        assert refused.returncode == 2
        assert (
            refused.stderr == "lamella: LAMELLA_THREADS = 'none' is not accepted; choose a whole number from 1, or leave it out\n"
        )
        assert not (tmp_path / "other").exists()
    finally:
        monkeypatch.undo()
        threads.use(None)


def test_doctor_finds_this_installation_sound(lamella) -> None:
    done = lamella("doctor")
    assert done.returncode == 0, done.stdout
    assert "lamella is ready to run" in done.stdout
    for word in ("python", "numba", "kernel cache", "for large models", "OpenGL", "working folder", "small plate bends"):
        assert word in done.stdout


def test_version_and_wrong_commands(lamella) -> None:
    assert lamella("--version").stdout.startswith("lamella ")
    wrong = lamella("rnu")
    assert wrong.returncode == 2
    assert "No such command 'rnu'" in wrong.stderr
    assert "Traceback" not in wrong.stderr
