"""Units of FMI whose resources are damaged, whose lamella is missing, and what their binaries hold when the process ends."""

from __future__ import annotations

import atexit
import base64
import sys
from pathlib import Path
from zipfile import ZipFile

import numpy as np
import pytest
from fmi_units import VERSIONS, fmpy, instantiated, validate_fmu

import lamella as lm
from lamella.errors import DeclarationError, ModelError
from lamella.fmu.lasting import ENDING
from lamella.fmu.plant import Plant

MODEL = """\
lamella: 1
title: A mass on a spring
system:
  ground: {type: ground}
  mass: {type: rigid_body, mass: 2 kg, inertia: [1, 1, 1], position: [0, 0, -0.5 m]}
  guide: {type: prismatic_joint, a: ground.origin, b: mass.origin, axis: [0, 0, 1]}
  spring: {type: spring_damper, a: ground.origin, b: mass.origin, stiffness: 100, rest_length: 0.4}
  gravity: {type: gravity}
  push: {type: point_force, on: mass.origin, force: [0, 0, 1 N], profile: 0}
analysis:
  hanging: {type: statics}
  plant: {type: linear, about: hanging, inputs: [push], outputs: [mass.position.z]}
  motion: {type: motion, start: hanging, t_end: 0.1 s, integrator: {dt: 1 ms}}
"""


@pytest.fixture(scope="module")
def units(tmp_path_factory: pytest.TempPathFactory) -> dict[int, Path]:
    model = tmp_path_factory.mktemp("unit") / "hung.yaml"
    model.write_text(MODEL, encoding="utf-8")
    return {fmi: lm.export_fmu(model, model.with_name(f"hung{fmi}.fmu"), fmi=fmi) for fmi in VERSIONS}


def _instance(path: Path, fmi: int, folder: Path):
    """A unit of the package that is unpacked in ``folder``, and how it is initialised."""
    slave = instantiated(path, fmi, folder)

    def begin() -> None:
        if fmi == 2:
            slave.setupExperiment(startTime=0.0)
        slave.enterInitializationMode()
        slave.exitInitializationMode()

    return slave, begin


@pytest.mark.parametrize("fmi", VERSIONS)
def test_a_binary_lets_go_of_python_before_the_process_ends(units, fmi, tmp_path, monkeypatch):
    """Its own end lets go twice, the second time by memory that is freed."""
    ends: list = []
    monkeypatch.setattr(atexit, "register", ends.append)
    for name in ("one", "one", "other"):  # a unit that is unpacked once more has a binary of its own
        slave, _ = _instance(units[fmi], fmi, tmp_path / name)
        slave.reset()
        slave.freeInstance()
    assert [end.__name__ for end in ends] == ["finalizePythonInterpreter"] * 2
    assert {path.parents[2].name for path in ENDING} >= {"one", "other"}
    for end in ends:
        end()  # as at the end of the process; a unit may be made again
    slave, begin = _instance(units[fmi], fmi, tmp_path / "one")
    begin()
    slave.doStep(0.0, 1e-3)
    slave.freeInstance()


@pytest.mark.parametrize("fmi", VERSIONS)
def test_a_unit_whose_resources_are_gone_is_reset_and_then_told(units, fmi, tmp_path, capfd):
    slave, begin = _instance(units[fmi], fmi, tmp_path / "unit")
    begin()
    slave.doStep(0.0, 1e-3)
    for name in ("interface.json", "model.yaml"):
        (tmp_path / "unit" / "resources" / name).unlink()
    slave.reset()  # makes the instance anew; where that fails the binary uses what it has freed
    with pytest.raises(Exception, match="EnterInitializationMode failed"):
        begin()
    assert "model.yaml' cannot be read: No such file or directory; accepted is the unit as it was" in "".join(capfd.readouterr())
    slave.reset()
    slave.freeInstance()


def test_an_input_that_is_no_number_is_refused_before_there_is_a_motion(units, tmp_path):
    plant = Plant(Path(fmpy.extract(units[2], tmp_path)) / "resources")
    with pytest.raises(DeclarationError, match="FMU 'hung': the input 'push' is set to nan; accepted is a number of up to"):
        plant.set("push", np.nan)
    plant.begin(0.0)
    assert plant.input("push") == 0.0


def test_a_state_that_is_refused_begins_no_motion(units, tmp_path):
    """It is that of a unit with the same inputs and another model."""
    plant = Plant(Path(fmpy.extract(units[2], tmp_path)) / "resources")
    ball = lm.System()
    ball.add(lm.RigidBody("ball", mass=1.0, inertia=(1, 1, 1)))
    other = lm.Stepping(ball, lm.GeneralizedAlpha(dt=1e-3)).save()
    with pytest.raises(DeclarationError, match="the saved state is that of another system"):
        plant.restore({"inputs": {"push": 0.0}, "run": base64.b64encode(other).decode()})
    assert not plant.moves


def _part(name: str, content: bytes | None):
    """What damages a file of the resources: it is taken away, or has another content."""

    def damage(resources: Path) -> None:
        path = resources / name
        path.unlink()
        if content is not None:
            path.write_bytes(content)

    return damage


def _without_coordinates(resources: Path) -> None:
    np.savez(resources / "start.npz", v=np.zeros(3))


@pytest.mark.parametrize(
    ("damage", "said"),
    [
        (_part("interface.json", None), r"interface\.json' cannot be read: No such file"),
        (_part("interface.json", b'{"name": 3'), r"interface\.json' cannot be read: it is damaged"),
        (_part("interface.json", b'{"inputs": [], "outputs": []}'), r"interface\.json' cannot be read: it is damaged"),
        (_part("model.yaml", b"\xff"), r"model\.yaml' cannot be read: it is damaged"),
        (_part("model.yaml", MODEL.replace("  motion:", "  moves:").encode()), r"model\.yaml' cannot be read: it is damaged"),
        (_part("start.npz", None), r"start\.npz' cannot be read: No such file"),  # it began somewhere else
        (_part("start.npz", b"PK"), r"start\.npz' cannot be read: it is damaged"),
        (_part("start.npz", b""), r"start\.npz' cannot be read: it is damaged"),
        (_without_coordinates, r"start\.npz' cannot be read: it is damaged"),
    ],
)
def test_a_damaged_unit_is_told(units, tmp_path, damage, said):
    resources = Path(fmpy.extract(units[2], tmp_path)) / "resources"
    damage(resources)
    with pytest.raises(ModelError, match=f"^FMU: '.*{said}.*; accepted is the unit as it was written"):
        Plant(resources).begin(0.0)


@pytest.mark.parametrize("fmi", VERSIONS)
def test_a_unit_without_outputs_or_with_an_input_called_time_is_valid(units, tmp_path, fmi):
    model = units[fmi].with_name("hung.yaml")
    unit = lm.export_fmu(model, tmp_path / "unit.fmu", fmi=fmi, inputs=("push",), outputs=())
    assert validate_fmu(str(unit)) == []
    timed = {"inputs": {"time": "push"}, "outputs": ("mass.position.z",), "overwrite": True}
    if fmi == 2:
        assert validate_fmu(str(lm.export_fmu(model, unit, fmi=2, **timed))) == []
    else:
        with pytest.raises(DeclarationError, match=r"an input is called 'time', .* accepted is another name, \{'name': 'push'\}"):
            lm.export_fmu(model, unit, fmi=3, **timed)


@pytest.mark.parametrize("fmi", VERSIONS)
@pytest.mark.parametrize(("name", "found"), [("2-bodies", "_2_bodies"), ("class", "_class"), ("None", "_None")])
def test_a_name_that_python_does_not_know_is_made_one(tmp_path, fmi, name, found):
    model = tmp_path / f"{name}.yaml"
    model.write_text(MODEL, encoding="utf-8")
    unit = lm.export_fmu(model, tmp_path / "unit.fmu", fmi=fmi)
    assert fmpy.read_model_description(unit).modelName == found
    slave, begin = _instance(unit, fmi, tmp_path / "unit")
    begin()
    slave.freeInstance()


@pytest.mark.parametrize("fmi", VERSIONS)
def test_a_unit_without_lamella_is_told(units, fmi, monkeypatch):
    """The binary of FMI 3 ended the process where the unit's text could not be run."""
    with ZipFile(units[fmi]) as unit:
        name = next(item for item in unit.namelist() if item.startswith("resources/hung") and item.endswith(".py"))
        text = unit.read(name).decode()
    monkeypatch.setitem(sys.modules, f"lamella.fmu.fmi{fmi}", None)
    there: dict = {}
    exec(text, there)
    with pytest.raises(ImportError, match=r"the unit 'hung' cannot be run without lamella: .*fmi\d"):
        there["hung"](instance_name="unit", resources=".")
