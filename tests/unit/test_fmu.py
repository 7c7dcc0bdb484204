"""Units of FMI 2 and 3: valid, run by another program as the model itself runs, saved and restored; and what is refused."""

from __future__ import annotations

import gc
import json
import sys
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from fmi_units import VERSIONS, fmpy, instantiated, validate_fmu

import lamella as lm
from lamella.cli.main import ERROR, run_app
from lamella.errors import DeclarationError, MissingExtraError, ModelError, ResultFileError
from lamella.fmu.plant import Plant
from lamella.fmu.units import base_units, is_structured
from lamella.io.model_file import read_model

MODEL = """\
lamella: 1
title: A plate with an actuator
system:
  plate:
    type: plate
    size: [0.5 m, 0.2 m]
    mesh: [2, 1]
    damping: 0.1 ms
    laminate: {ply: {type: isotropic, E: 70 GPa, nu: 0.3, rho: 2700}, thickness: 2 mm}
    markers: {tip: [0.5 m, 0.1 m]}
  root: {type: clamp, on: plate.x-}
  gravity: {type: gravity}
  actuator: {type: point_force, on: plate.tip, force: [0, 0, 1 N], profile: 0.1}
analysis:
  hanging: {type: statics, steps: 2}
  plant: {type: linear, about: hanging, inputs: [actuator], outputs: [tip.position.z, root.torque.y]}
  motion: {type: motion, start: hanging, t_end: 0.1 s, integrator: {dt: 1 ms, newton: {tolerance: 1e-10}}}
"""
OUTPUTS = ["tip.position.z", "root.torque.y"]
STEP = 5e-3
LEVELS = np.array([0.3, -1.0, 2.0, 0.5, 1.5, -0.7])


@pytest.fixture(scope="module")
def model(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("unit") / "plant.yaml"
    path.write_text(MODEL, encoding="utf-8")
    return path


@pytest.fixture(scope="module")
def units(model: Path) -> dict[int, Path]:
    return {fmi: lm.export_fmu(model, model.with_name(f"plant{fmi}.fmu"), fmi=fmi) for fmi in VERSIONS}


@pytest.fixture(scope="module")
def own(model: Path) -> np.ndarray:
    """Outputs of the model's own run, before each jump of the input."""
    file = read_model(model, ["system.actuator.profile=1"])
    hanging = lm.equilibrium(read_model(model).system, steps=2).final
    motion = next(item for item in file.analyses if item.name == "motion")
    law = lm.FunctionLaw(lambda t, y: LEVELS[min(round(t / STEP), len(LEVELS) - 1)])
    file.system.add(lm.Controller("pilot", (OUTPUTS[0],), ("actuator",), law, STEP))
    run = lm.simulate(file.system, STEP * len(LEVELS), motion.integrator, initial=hanging)
    at = np.searchsorted(run.at, STEP * np.arange(1, len(LEVELS) + 1) - 1e-9)
    return np.stack([run["tip.position"].values[at, 2], run["root.torque"].values[at, 1]], axis=1)


def instance(path: Path, fmi: int, folder: Path) -> SimpleNamespace:
    """A unit at work, with the same few calls for both versions."""
    description = fmpy.read_model_description(path)
    numbers = {item.name: item.valueReference for item in description.modelVariables}
    slave = instantiated(path, fmi, folder)
    get, put = (slave.getReal, slave.setReal) if fmi == 2 else (slave.getFloat64, slave.setFloat64)

    def begin(level: float) -> None:
        if fmi == 2:
            slave.setupExperiment(startTime=0.0)
            slave.enterInitializationMode()
        else:
            slave.enterInitializationMode(startTime=0.0)
        put([numbers["actuator"]], [level])
        slave.exitInitializationMode()

    def march(first: int, last: int) -> list[list[float]]:
        found = []
        for k in range(first, last):
            put([numbers["actuator"]], [float(LEVELS[k])])
            slave.doStep(k * STEP, STEP)
            found.append(get([numbers[name] for name in OUTPUTS]))
        return found

    load = slave.deSerializeFMUstate if fmi == 2 else slave.deserializeFMUState
    return SimpleNamespace(slave=slave, begin=begin, march=march, load=load)


@pytest.mark.parametrize("fmi", VERSIONS)
def test_a_unit_is_valid_and_says_what_it_has(units, fmi):
    assert validate_fmu(str(units[fmi])) == []
    description = fmpy.read_model_description(units[fmi])
    found = {item.name: item for item in description.modelVariables}
    assert {name for name, item in found.items() if item.causality == "input"} == {"actuator"}
    assert [name for name, item in found.items() if item.causality == "output"] == OUTPUTS
    assert [found[name].unit for name in ("actuator", *OUTPUTS)] == [None, "m", "N m"]
    assert found["actuator"].description == "profile of PointForce actuator"
    assert float(found["actuator"].start) == 0.1
    assert description.description == "A plate with an actuator"
    assert (float(description.defaultExperiment.stopTime), float(description.defaultExperiment.stepSize)) == (0.1, 1e-3)
    unit = next(item for item in description.unitDefinitions if item.name == "N m")
    assert [getattr(unit.baseUnit, name) for name in ("kg", "m", "s", "rad")] == [1, 2, -2, 0]


@pytest.mark.parametrize("fmi", VERSIONS)
def test_another_program_runs_it_as_the_model_runs(units, own, fmi, tmp_path):
    """Jumps of inputs at communication points, against the model's own run with a controller that holds the same levels."""
    unit = instance(units[fmi], fmi, tmp_path)
    unit.begin(LEVELS[0])
    found = np.array(unit.march(0, len(LEVELS)))
    np.testing.assert_allclose(found, own, rtol=0, atol=1e-8 * np.abs(own).max(axis=0).max())
    unit.slave.terminate()
    unit.slave.freeInstance()


@pytest.mark.parametrize("fmi", VERSIONS)
def test_states_are_saved_restored_and_reset_to_the_bit(units, fmi, tmp_path):
    unit = instance(units[fmi], fmi, tmp_path)
    unit.begin(LEVELS[0])
    first = unit.march(0, 3)
    state = unit.slave.getFMUState()
    written = bytes(unit.slave.serializeFMUState(state))
    rest = unit.march(3, 6)
    unit.slave.setFMUState(state)
    assert unit.march(3, 6) == rest
    other = instance(units[fmi], fmi, tmp_path / "other")  # a second instance beside the first one
    other.begin(0.0)
    other.slave.setFMUState(other.load(written))
    assert other.march(3, 6) == rest
    unit.slave.freeFMUState(state)
    unit.slave.reset()
    unit.begin(LEVELS[0])
    assert unit.march(0, 6) == [*first, *rest]
    for item in (unit, other):
        item.slave.terminate()
        item.slave.freeInstance()


@pytest.mark.parametrize("fmi", VERSIONS)
def test_a_master_simulates_it(units, fmi):
    """fmpy's own loop, with an input over time."""
    table = np.array([(0.0, 0.5), (1.0, 0.5)], dtype=[("time", float), ("actuator", float)])
    found = fmpy.simulate_fmu(str(units[fmi]), stop_time=0.02, step_size=STEP, output_interval=STEP, input=table, output=OUTPUTS)
    assert found["time"][-1] == pytest.approx(0.02)
    assert np.isfinite(found["root.torque.y"]).all()
    assert found["tip.position.z"][-1] > found["tip.position.z"][0]  # the force is upwards


@pytest.mark.parametrize("fmi", VERSIONS)
def test_a_step_that_fails_is_told(units, fmi, tmp_path):
    unit = instance(units[fmi], fmi, tmp_path)
    unit.begin(1e9)
    with pytest.raises(Exception, match=r"fmi\dDoStep failed"):
        unit.slave.doStep(0.0, STEP)
    unit.slave.freeInstance()


@pytest.mark.parametrize("fmi", VERSIONS)
def test_a_step_before_there_is_a_motion_is_told(units, fmi, tmp_path):
    unit = instance(units[fmi], fmi, tmp_path)
    with pytest.raises(Exception, match=r"fmi\dDoStep failed with status (2 \(discard\)|3 \(error\))"):
        unit.slave.doStep(0.0, STEP)  # told by the unit; an error in Python itself would be fatal
    unit.slave.freeInstance()


@pytest.mark.parametrize("fmi", VERSIONS)
def test_a_step_from_another_time_than_the_present_one_is_refused(units, fmi, tmp_path):
    unit = instance(units[fmi], fmi, tmp_path)
    unit.begin(0.0)
    for first in (0.05, -STEP):
        with pytest.raises(Exception, match=r"fmi\dDoStep failed"):
            unit.slave.doStep(first, STEP)
    if fmi == 3:
        assert unit.slave.getFloat64([0]) == [0.0]  # the time
    assert len(unit.march(0, 2)) == 2
    unit.slave.doStep(2 * STEP + 1e-10, STEP)  # a master sums its steps
    with pytest.raises(DeclarationError, match=r"a step of 0\.005 s from 0\.05 s; accepted is one from the present time, 0 s"):
        _plant(units[fmi], tmp_path / "plain").advance(0.05, STEP)
    unit.slave.freeInstance()


@pytest.mark.parametrize("fmi", VERSIONS)
def test_a_variable_that_is_not_there_or_cannot_be_set_is_told(units, fmi, tmp_path, capfd):
    unit = instance(units[fmi], fmi, tmp_path)
    unit.begin(0.0)
    get, put = (unit.slave.getReal, unit.slave.setReal) if fmi == 2 else (unit.slave.getFloat64, unit.slave.setFloat64)
    first = [] if fmi == 2 else ["time"]
    there = ", ".join(f"{i} ({name})" for i, name in enumerate([*first, "actuator", *OUTPUTS]))
    unknown = f"FMU 'plant': no variable has the reference 99; accepted is one of {there}"
    held = len(first) + 1
    cases = [
        (lambda: get([0, 99]), unknown),
        (lambda: put([99], [1.0]), unknown),
        (lambda: put([held], [1.0]), f"FMU 'plant': '{OUTPUTS[0]}' is set; accepted is an input: actuator"),
        (lambda: put([held - 1], [np.nan]), "FMU 'plant': the input 'actuator' is set to nan; accepted is a number of up to"),
    ]
    if fmi == 3:
        cases.append((lambda: put([0], [1.0]), "FMU 'plant': 'time' is set; accepted is an input: actuator"))
    kept = _references()
    for ask, said in cases:
        capfd.readouterr()
        with pytest.raises(Exception, match=r"fmi\d[GS]et\w+ failed"):
            ask()
        assert said in "".join(capfd.readouterr())
    assert _references() == kept  # what is given up for an error would be used when the unit is freed
    assert get([held - 1]) == [0.0]  # as it was set
    assert len(unit.march(0, 2)) == 2
    unit.slave.freeInstance()


@pytest.mark.parametrize("fmi", VERSIONS)
def test_bytes_that_are_no_state_are_told(units, fmi, tmp_path, capfd):
    unit = instance(units[fmi], fmi, tmp_path)
    unit.begin(0.0)
    run = json.dumps({"inputs": {"actuator": 0.0}, "run": "AAAA"}).encode()
    other = json.dumps({"inputs": {}, "run": None}).encode()
    of_unit, of_run = "accepted is one that this unit has given", "accepted is what save() gave"
    for written, said in ((b"{", of_unit), (b"[]", of_unit), (other, of_unit), (run, of_run)):
        capfd.readouterr()
        with pytest.raises(Exception, match="failed"):
            unit.slave.setFMUState(unit.load(written))
        assert said in "".join(capfd.readouterr())
    assert len(unit.march(0, 2)) == 2
    unit.slave.freeInstance()


def _references() -> list[int]:
    """How many references there are to the instance that a binary made last, to its class and to its messages."""
    gc.collect()
    own = [item for item in gc.get_objects() if type(item).__name__ == "plant"][-1]
    return [sys.getrefcount(item) for item in (own, type(own), own.log_queue)]


def _plant(path: Path, folder: Path) -> Plant:
    plant = Plant(str(Path(fmpy.extract(path, folder)) / "resources"))
    plant.begin(0.0)
    return plant


def test_units_and_names_are_those_of_the_standard():
    assert base_units("N m/rad") == {"kg": "1", "m": "2", "s": "-2", "rad": "-1"}
    assert base_units("1/s") == {"s": "-1"}
    assert base_units("K/m") == {"K": "1", "m": "-1"}
    assert is_structured("tip.position.z")
    assert not is_structured("my-plate.x")
    assert not is_structured("wheel.state.0")


def test_names_that_are_no_modelica_names_are_plain(tmp_path):
    path = tmp_path / "my plant-2.yaml"
    path.write_text(MODEL.replace("actuator", "the-actuator"), encoding="utf-8")
    for fmi in VERSIONS:
        unit = lm.export_fmu(path, tmp_path / f"{fmi}.fmu", fmi=fmi, step=0.01)
        assert validate_fmu(str(unit)) == []
        description = fmpy.read_model_description(unit)
        assert (description.modelName, description.variableNamingConvention) == ("my_plant_2", "flat")
        assert float(description.defaultExperiment.stepSize) == 0.01


@pytest.mark.parametrize(
    ("options", "error", "said"),
    [
        ({"fmi": 1}, DeclarationError, "fmi = 1; accepted is 2 or 3"),
        ({"inputs": ["aktuator"]}, DeclarationError, "no input 'aktuator'.*there are: gravity, actuator"),
        ({"outputs": ["tip.positon"]}, DeclarationError, r"no output 'tip\.positon'.*tip\.position"),
        ({"inputs": "actuator"}, DeclarationError, "inputs = 'actuator'; accepted is a list of names, or a mapping"),
        ({"outputs": 5}, DeclarationError, "outputs = 5; accepted is a list of names, or None"),
        ({"step": 0.0}, DeclarationError, "step = 0.0"),
        ({"step": float("inf")}, DeclarationError, "step = inf; accepted is a positive, finite"),
        ({"motion": "swing"}, ModelError, "no motion 'swing'; there are: motion"),
        ({"overrides": ["analysis.plant.inputs=[x]"]}, DeclarationError, "no input 'x'"),
        ({"overrides": ["analysis={motion: {type: motion, t_end: 1}}"]}, ModelError, "neither inputs nor outputs.*type: linear"),
        ({"overrides": ["analysis={}"]}, ModelError, "no motion, whose integrator a unit takes; there are: none"),
    ],
)
def test_bad_input_is_told_before_anything_is_written(model, tmp_path, options, error, said):
    with pytest.raises(error, match=said):
        lm.export_fmu(model, tmp_path / "x.fmu", **options)
    assert not list(tmp_path.iterdir())


def test_bad_targets_are_told(model, tmp_path):
    with pytest.raises(DeclarationError, match=r"ends in \.fmu"):
        lm.export_fmu(model, tmp_path / "x.zip")
    with pytest.raises(ResultFileError, match="cannot be written: No such file or directory"):
        lm.export_fmu(model, tmp_path / "none" / "x.fmu")
    (tmp_path / "x.fmu").write_text("mine")
    with pytest.raises(ResultFileError, match="exists already"):
        lm.export_fmu(model, tmp_path / "x.fmu")
    assert (tmp_path / "x.fmu").read_text() == "mine"
    assert len(list(tmp_path.iterdir())) == 1


@pytest.mark.parametrize(("fmi", "package"), [(2, "pythonfmu"), (3, "pythonfmu3")])
def test_a_missing_package_is_told(model, tmp_path, monkeypatch, fmi, package):
    monkeypatch.setitem(sys.modules, package, None)
    with pytest.raises(MissingExtraError, match=rf"FMI {fmi} needs {package}: pip install 'lamella\[fmu\]'"):
        lm.export_fmu(model, tmp_path / "x.fmu", fmi=fmi)


def test_the_command_writes_a_unit(model, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    words = ["fmu", str(model), "--fmi", "3", "--set", "system.plate.mesh=[1, 1]", "--output", "energy.kinetic"]
    assert run_app(words) == 0
    assert "wrote plant.fmu (FMI 3, co-simulation)" in capsys.readouterr().out
    found = {item.name: item.causality for item in fmpy.read_model_description("plant.fmu").modelVariables}
    assert found == {"time": "independent", "actuator": "input", "energy.kinetic": "output"}
    assert run_app(words) == ERROR
    assert "exists already" in capsys.readouterr().err
    assert run_app([*words, "--overwrite"]) == 0
