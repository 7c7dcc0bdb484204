"""Bad input to ``lamella run``: one clear message, exit code 2, nothing written."""

from __future__ import annotations

import os
import resource
import subprocess
import sys
from pathlib import Path

import pytest

OVERRIDES = [
    ("system.strip.laminate.thickness=0", "accepted is a value greater than 0"),
    ("system.strip.laminate.thickness=-2 mm", "accepted is a value greater than 0"),
    ("system.strip.size=[1 kg, 1]", "does not convert to m"),
    ("system.strip.laminate.ply.E=.nan", "nan is not finite"),
    ("system.strip.mesh=[0, 1]", "accepted is a value at least 1"),
    ("system.strip.markers.tip=[1.5, 0]", "marker 'tip' lies outside the plate"),
    ("system.strip.colour=red", "plate has no key 'colour'"),
    ("system.strip.laminate.ply.nu=0.9", "nu = 0.9"),
    ("system.load.on=strip.top", "no marker or edge 'top'"),
    ("analysis.swing.t_end=-1", "accepted is a time later than t_start"),
    ("analysis.swing.integrator.dt=0", "accepted is a value greater than 0"),
    ("analysis={}", "asks for no analysis"),
    ("system={}", "no body, joint or load is given"),
    (
        "analysis={still: {type: statics}, swing: {type: motion, t_end: 1, start: stil}}",
        "'stil' is no earlier analysis with a state; did you mean 'still'?",
    ),
    (
        "analysis={swing: {type: motion, t_end: 1, start: still}, still: {type: statics}}",
        "'still' is no earlier analysis with a state; there is none to choose from",
    ),
    ("analysis={m: {type: natural_modes, count: 2}, n: {type: natural_modes, count: 2, about: m}}", "with a state"),
    (
        "analysis={a: {type: statics}, b: {type: path, imperfection: {of: c, amplitude: 1 mm}}}",
        "'c' is no earlier analysis; accepted are a",
    ),
]


def one_message(done: subprocess.CompletedProcess[str]) -> str:
    """The message of a refused call, which is one and no traceback."""
    assert done.returncode == 2, done.stderr
    assert done.stdout == ""
    assert "Traceback" not in done.stderr
    messages = [line for line in done.stderr.splitlines() if line.startswith("lamella: ")]
    assert len(messages) == 1, done.stderr
    return done.stderr


@pytest.mark.parametrize(("override", "said"), OVERRIDES)
def test_impossible_value_is_refused(here, model: Path, override: str, said: str) -> None:
    message = one_message(here("run", model, "--out", "out", "--no-pictures", "--set", override))
    assert said in message


def test_refused_model_writes_nothing(here, model: Path, tmp_path: Path) -> None:
    one_message(here("run", model, "--out", "out", "--set", "system.strip.mesh=[0, 1]"))
    assert not (tmp_path / "out").exists()


def test_refused_system_leaves_results_as_they_are(here, model: Path, tmp_path: Path) -> None:
    """What is wrong with the system as a whole is found before the folder is made, or cleared."""
    apart = "system.pin={type: spherical_joint, a: ground.post, b: strip.tip}"
    words = ("--set", "system.ground={type: ground, markers: {post: [0, 0, 9]}}", "--set", apart)
    assert "9.0" in one_message(here("run", model, "--out", "out/of", "--no-pictures", *words))
    assert not (tmp_path / "out").exists()
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "report.html").write_text("of an earlier run")
    one_message(here("run", model, "--out", "out", "--no-pictures", "--overwrite", *words))
    assert (tmp_path / "out" / "report.html").read_text() == "of an earlier run"


def test_analysis_that_is_refused_leaves_no_empty_folder(here, model: Path, tmp_path: Path) -> None:
    plant = "plant: {type: linear, about: still, inputs: [load], outputs: [tip.position.z], order: 4000}"
    linear = f"analysis={{still: {{type: statics}}, {plant}}}"
    assert "order = 4000; accepted is 1 to " in one_message(
        here("run", model, "--out", "out", "--no-pictures", "-q", "--set", linear)
    )
    assert [path.name for path in (tmp_path / "out").iterdir()] == ["still"]
    free = "system.root={type: point_force, on: strip.tip, force: [1, 0, 0]}"
    words = ("--set", "analysis={still: {type: statics}}", "--set", free)
    one_message(here("run", model, "--out", "other", "--no-pictures", *words))
    assert not (tmp_path / "other").exists()


@pytest.mark.parametrize(
    ("addition", "said"),
    [
        (
            "output.signals=[tip.positon]",
            "output: signals: there is no signal 'tip.positon'; did you mean 'tip.position'? accepted are tip.position, ",
        ),
        ("output.signals=[strip.tip.position.w]", "there is no signal 'strip.tip.position.w'; "),
        ("output.field=stress", "picture: no field 'stress'; accepted are displacement, "),
        ("output.field=curvature", "picture: field 'curvature' has no magnitude; accepted are curvature.xx, "),
        ("output.field=T_N", "picture: plate 'strip' has no temperature; accepted is "),
        ("output.field=tsai_wu", "Lamina: a failure criterion needs the strengths "),
        ("analysis.plant={type: linear, inputs: [lod], outputs: [tip.position.z]}", "there is no input 'lod'; "),
        ("analysis.plant={type: linear, inputs: [load], outputs: [tip.positon.z]}", "there is no output 'tip.positon.z'; "),
    ],
)
def test_names_that_do_not_exist_are_told_before_anything_is_computed(
    here, model: Path, tmp_path: Path, addition: str, said: str
) -> None:
    still = "analysis.still={type: statics}"
    assert here("run", model, "--out", "out", "--no-pictures").returncode == 0
    kept = (tmp_path / "out" / "run.h5").read_bytes()
    refused = here("run", model, "--out", "out", "--overwrite", "--set", still, "--set", addition)
    assert said in " ".join(one_message(refused).split())
    assert (tmp_path / "out" / "run.h5").read_bytes() == kept


def test_signals_that_one_analysis_alone_records_are_drawn_there(here, model: Path, tmp_path: Path) -> None:
    still, drawn = "analysis.still={type: statics}", "output.signals=[load_factor]"
    done = here("run", model, "--out", "out", "--set", still, "--set", drawn, "--set", "output.animation=false")
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "out/still/pictures/signals.png").is_file()
    assert not (tmp_path / "out/swing/pictures/signals.png").exists()


def test_statics_without_a_support_is_refused(here, model: Path) -> None:
    model.write_text(model.read_text().replace("  root: {type: clamp, on: strip.x-}\n", ""))
    message = one_message(here("run", model, "--out", "out", "--no-pictures", "--set", "analysis={still: {type: statics}}"))
    assert "nothing holds the system; add at least one support" in message


def test_load_that_cannot_be_carried_says_how_far_it_got(here, model: Path, tmp_path: Path) -> None:
    text = model.read_text().replace("root: {type: clamp, on: strip.x-}", "root: {type: point_support, on: strip.x-y-}")
    model.write_text(text)  # a plate on one ball joint turns away under any load
    message = one_message(here("run", model, "--out", "out", "--no-pictures", "--set", "analysis={still: {type: statics}}"))
    assert "singular" in message or "stopped at 0 of 1" in message


def test_missing_files_and_folders(here, tmp_path: Path) -> None:
    assert "the model file 'none.yaml' does not exist" in one_message(here("run", "none.yaml"))
    assert "is a folder; expected is a model file" in one_message(here("run", tmp_path))
    assert "neither a model file nor an example" in one_message(here("run", "cantilver-plate"))
    assert "does not exist" in one_message(here("info", "none.h5"))
    assert "does not exist" in one_message(here("plot", "none.h5"))
    assert "holds no result file" in one_message(here("info", tmp_path))
    (tmp_path / "words.h5").write_text("no result")
    assert "is not a result file" in one_message(here("info", "words.h5"))


def test_output_folder_that_is_a_file(here, model: Path) -> None:
    assert "is a file; accepted is a folder" in one_message(here("run", model, "--out", model))


@pytest.mark.skipif(os.geteuid() == 0, reason="the administrator may write everywhere")
def test_read_only_folder(here, model: Path, tmp_path: Path) -> None:
    closed = tmp_path / "closed"
    closed.mkdir(mode=0o555)
    assert "cannot be written: Permission denied" in one_message(here("run", model, "--out", closed / "out"))


def test_folder_where_nothing_can_be_made(here, model: Path) -> None:
    assert "cannot be written" in one_message(here("run", model, "--out", "/proc/results"))


def test_full_disk(model: Path, tmp_path: Path, environment: dict[str, str]) -> None:
    """A limit on the size of files stands for the full disk: the run ends with one message."""
    words = ["run", model, "--out", "out", "--no-pictures", "--quiet", "--set", "analysis.swing.t_end=60 s"]

    def limit() -> None:
        resource.setrlimit(resource.RLIMIT_FSIZE, (600_000, 600_000))

    done = subprocess.run(
        [sys.executable, "-m", "lamella", *words],
        cwd=tmp_path,
        env=environment,
        capture_output=True,
        text=True,
        timeout=600,
        preexec_fn=limit,
        check=False,
    )
    assert "cannot be written" in one_message(done)


HEATED = """\
lamella: 1
system:
  panel:
    type: plate
    size: [1 m, 200 mm]
    mesh: [2, 1]
    laminate: {ply: {type: isotropic, E: 70 GPa, nu: 0.3, rho: 2700, alpha: 2.3e-5 1/K, k: 200, c: 900}, thickness: 2 mm}
  root: {type: clamp, on: panel.x-}
  heat: {type: temperature_field, on: panel, reference: 20 degC}
  sun: {type: solar_flux, on: panel, direction: [0, 0, -1], absorptivity: 0.8, constant: 1350 W/m^2}
  sink: {type: radiation, on: panel, emissivity: 0.8}
analysis: {still: {type: statics}}
"""


@pytest.mark.parametrize(
    ("override", "said"),
    [
        ("system.sun.absorptivity=1.2", "found 1.2; accepted is a value at most 1"),
        ("system.sun.direction=[0, 0, 0]", "accepted is a vector of some length"),
        ("system.heat.reference=-300 degC", "found '-300 degC'; accepted is a value at least 0"),
        ("system.heat.initial_gradient=3 degC/m", "differences of temperature in K or delta_degC"),
        ("system.sink.sides=[top, top]", "accepted is top, bottom or both, each once"),
        ("system.heat={type: heat_source, on: panel, power: 1}", "plate 'panel' has no temperature field"),
        (
            "system.sink={type: heat_source, on: panel, power: 1 W/m^3}",
            "nothing determines the temperatures of 'heat', heat has no way out; add a Film",
        ),
    ],
)
def test_heat_that_cannot_be(here, tmp_path: Path, override: str, said: str) -> None:
    (tmp_path / "heated.yaml").write_text(HEATED)
    assert said in one_message(here("run", "heated.yaml", "--out", "out", "--no-pictures", "--quiet", "--set", override))


def test_edge_that_cannot_grow_is_told(here, tmp_path: Path) -> None:
    (tmp_path / "heated.yaml").write_text(HEATED)
    done = here("run", "heated.yaml", "--out", "out", "--no-pictures")
    assert done.returncode == 0, done.stderr
    assert "'root' clamps an edge of 'panel' with the kind 'full'" in " ".join((done.stdout + done.stderr).split())


MECHANISM = """\
lamella: 1
system:
  ground: {type: ground}
  a: {type: rigid_body, mass: 1, inertia: [1, 1, 1], markers: {m: [0.1, 0, 0], n: [0.2, 0, 0]}}
  pin: {type: revolute_joint, a: ground.origin, b: a.origin}
  OTHER
analysis: {swing: {type: motion, t_end: 0.01 s}}
"""


@pytest.mark.parametrize(
    ("other", "said"),
    [
        ("second: {type: revolute_joint, a: a.m, b: a.n}", "a.m and a.n are points of one body"),
        ("second: {type: spherical_joint, a: ground.origin, b: a.n}", "lie 0.2 m apart"),
        ("second: {type: revolute_joint, a: ground.origin, b: a.origin, axis: [1, 0, 0]}", "locked by its joints"),
        ("spring: {type: torsion_spring, on: pin, stiffness: -1}", "accepted is a value at least 0"),
        ("spring: {type: torsion_spring, on: pni, stiffness: 1}", "did you mean 'pin'?"),
        (
            "drive: {type: angle_drive, on: pin, angle: {kind: table, times: [0, 2, 1], values: [0, 1, 2]}}",
            "accepted are strictly increasing times",
        ),
    ],
)
def test_mechanisms_that_cannot_be(here, tmp_path: Path, other: str, said: str) -> None:
    (tmp_path / "mechanism.yaml").write_text(MECHANISM.replace("OTHER", other))
    assert said in one_message(here("run", "mechanism.yaml", "--out", "out", "--no-pictures"))
    assert not list((tmp_path / "out").rglob("*"))  # nothing half-written stays


EDGES = """\
lamella: 1
system:
  ground: {type: ground}
  panel:
    type: plate
    size: [1, 0.4]
    mesh: [2, 1]
    laminate: {ply: {type: isotropic, E: 70 GPa, nu: 0.3, rho: 2700}, thickness: 2 mm}
    markers: {tip: [0.7, 0.1]}
  root: {type: clamp, on: panel.x-}
  OTHER
analysis: {still: {type: statics}}
"""


@pytest.mark.parametrize(
    ("other", "said"),
    [
        (
            "middle: {type: symmetry, on: panel.y+, normal: x}",
            "edge panel.y+ leaves the plane with the normal (1, 0, 0) by 0.5 m",
        ),
        (
            "middle: {type: symmetry, on: panel.y+, normal: [0, 1, 1]}",
            "meet the plane with the normal (0, 0.7071, 0.7071) at 45 deg",
        ),
        ("middle: {type: symmetry, on: panel.y+, normal: [0, 0, 0]}", "accepted is a direction of any length but zero"),
        ("end: {type: diaphragm, on: panel.x+, normal: y}", "edge panel.x+ leaves the plane with the normal (0, 1, 0)"),
        ("end: {type: edge_support, on: panel.x+, axes: xx}", "accepted are distinct letters of x, y and z"),
        ("end: {type: edge_average, on: panel.x+, rotations: y}", "the mean rotation of edge panel.x+ about y, on which it lies"),
        (
            "hold: {type: linear_constraint, terms: [{on: panel.tip, axis: z, factor: 0}]}",
            "nothing in it can move: 0 position of",
        ),
        (
            "hold: {type: linear_constraint, terms: [{on: ground.origin, axis: z}]}",
            "nothing in it can move: 1 position of ground.origin",
        ),
        (
            "hold: {type: linear_constraint, terms: [{on: panel.x-y-, axis: z}], value: 0.1}",
            "contradicts z of r at node 0 of edge panel.x-",
        ),
    ],
)
def test_supports_that_cannot_be(here, tmp_path: Path, other: str, said: str) -> None:
    (tmp_path / "edges.yaml").write_text(EDGES.replace("OTHER", other))
    assert said in " ".join(one_message(here("run", "edges.yaml", "--out", "out", "--no-pictures", "--quiet")).split())
