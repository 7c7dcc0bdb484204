"""A linear model of a model file: what a run leaves, and how wrong names are told."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.io import loadmat

import lamella as lm
from lamella.io.model_file import dumps, read_model
from lamella.viz.linear import bode_frequencies, step_times

PLANT = "plant: {type: linear, inputs: [load], outputs: [tip.position.z, root.force.z], modes: 4, order: 6}"


@pytest.fixture
def plant(model: Path) -> Path:
    """The small strip, damped and without load, with a linear model."""
    text = model.read_text().partition("analysis:")[0]
    text = text.replace("mesh: [2, 1]", "mesh: [2, 1]\n    damping: 0.3 ms").replace("-0.1 N]", "-0.1 N], profile: 0")
    model.write_text(f"{text}analysis:\n  {PLANT}\n")
    return model


def test_a_run_writes_the_linear_model_and_its_pictures(here, plant: Path, tmp_path: Path) -> None:
    done = here("run", plant, "--out", "out")
    assert done.returncode == 0, done.stderr
    assert "6 states, 1 input, 2 outputs, stable" in " ".join(done.stdout.replace("│", " ").split())
    folder = tmp_path / "out"
    files = {path.relative_to(folder).as_posix() for path in folder.rglob("*") if path.is_file()}
    assert files == {"linear.npz", "linear.mat", "model.yaml", "report.html", "pictures/bode.png", "pictures/step.png"}
    model = lm.StateSpace.load(folder / "linear.npz")
    assert model.outputs == ("tip.position.z", "root.force.z")
    assert model.error_bound is not None
    np.testing.assert_array_equal(loadmat(folder / "linear.mat")["A"], model.A)
    # the clamp bears the force; balancing errs at rest by less than its bound, as at any frequency
    assert model.dc_gain()[1, 0] == pytest.approx(0.1, abs=model.error_bound)
    report = (folder / "report.html").read_text()
    assert "errs by at most" in report
    assert "root.force.z" in report
    assert here("run", plant, "--out", "out", "--overwrite", "--no-pictures").returncode == 0
    assert not (folder / "report.html").exists()


def test_a_linear_model_goes_into_a_model_file_and_back(plant: Path) -> None:
    read = read_model(plant)
    again = dumps(read.system, analyses=read.analyses)
    assert "type: linear" in again
    assert "tip.position.z" in again


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ("analysis.plant.inputs=[lod]", "there is no input 'lod'"),
        ("analysis.plant.outputs=[tip.place]", "there is no output 'tip.place'"),
        ("analysis.plant.inputs=[]", "inputs"),
        ("analysis.plant.about=swing", "'swing' is no earlier analysis with a state; there is none to choose from"),
        ("analysis.plant.order=40", "order = 40; accepted is 1 to 10"),
    ],
)
def test_wrong_names_are_told(here, plant: Path, change: str, said: str) -> None:
    done = here("run", plant, "--out", "out", "--no-pictures", "--set", change)
    assert done.returncode == 2
    assert said in " ".join(done.stderr.split())
    assert "Traceback" not in done.stderr


def test_frequencies_and_times_of_pictures_cover_the_poles() -> None:
    def of(*poles: complex) -> lm.StateSpace:
        A = np.zeros((2 * len(poles), 2 * len(poles)))
        for k, pole in enumerate(poles):
            A[2 * k : 2 * k + 2, 2 * k : 2 * k + 2] = [[pole.real, pole.imag], [-pole.imag, pole.real]]
        ones = np.ones((len(A), 1))
        return lm.StateSpace(A, ones, ones.T, np.zeros((1, 1)), ("u",), ("y",), ("1",), ("m",), np.zeros(1), np.zeros(1))

    fast, slow = complex(-1.0, 200.0), complex(-0.2, 10.0)
    f = bode_frequencies(of(fast, slow))
    assert f[0] < 10.0 / (2 * np.pi) < 200.0 / (2 * np.pi) < f[-1]
    # near a vibration the spacing is less than its width
    assert np.diff(f[np.abs(f - 200.0 / (2 * np.pi)) < 1.0 / (2 * np.pi)]).max() < 1.0 / (2 * np.pi)
    assert step_times(of(fast, slow))[-1] == pytest.approx(10 * 2 * np.pi / abs(slow))  # ten periods come before its end
    assert step_times(of(complex(-5.0, 1.0)))[-1] == pytest.approx(6.0 / 5.0)
    assert step_times(of(complex(0.0, 0.0)))[-1] == 1.0
    assert len(bode_frequencies(of(complex(0.0, 0.0)))) > 100
