"""What an equilibrium path, natural modes and a table from a file leave, from the command line on."""

from __future__ import annotations

import csv
from pathlib import Path

import h5py
import numpy as np
import pytest

from lamella.io.modes import read_modes
from lamella.io.results import read_result

ANALYSES = """\
analysis:
  along: {type: path, until: 1, arc: {largest: 0.02}}
  modes: {type: natural_modes, count: 4}
output: {animation: false}
"""


@pytest.fixture
def bent(model: Path) -> Path:
    """The small strip with a path and modes, its load following a table."""
    text = model.read_text().partition("analysis:")[0]
    loaded = "profile: {kind: table, file: load.csv}, force: [0, 0, -20 N]"
    model.write_text(text.replace("force: [0, 0, -0.1 N]", loaded) + ANALYSES)
    (model.parent / "load.csv").write_text("t,p\n0,1\n1,2\n")
    return model


def test_path_and_modes_leave_files_and_pictures(lamella, bent: Path, tmp_path: Path) -> None:
    done = lamella("run", bent, "--out", "out")
    assert done.returncode == 0, done.stderr
    along, modes = tmp_path / "out/along", tmp_path / "out/modes"
    files = {path.relative_to(along).as_posix() for path in along.rglob("*") if path.is_file()}
    pictures = {f"pictures/{name}.png" for name in ("path", "signals", "energy", "shape")}
    assert files == {"run.h5", "model.yaml", "signals.csv", "surface.vtkhdf", "report.html"} | pictures

    result = read_result(along / "run.h5")
    assert result.axis == "path"
    np.testing.assert_array_equal(result.at, np.arange(len(result.at)))
    factors = result.history("load_factor").values
    assert factors[0] == 0
    assert factors[-1] == pytest.approx(1, rel=1e-12)
    assert result.outcome.target == 1  # the load factor, not the number of points
    np.testing.assert_allclose(result.history("root.force")[:, 2], 20 * factors, rtol=1e-6)  # each signal under its own name
    with (along / "signals.csv").open() as file:
        heading, *rows = list(csv.reader(file))
    assert heading[:2] == ["path [1]", "load_factor [1]"]
    np.testing.assert_allclose([float(row[1]) for row in rows], factors, rtol=1e-12)

    files = {path.relative_to(modes).as_posix() for path in modes.rglob("*") if path.is_file()}
    assert files == {"model.yaml", "modes.csv", "modes.h5", "modes.vtkhdf", "pictures/modes.png", "report.html"}
    found = read_modes(modes / "modes.h5")
    with (modes / "modes.csv").open() as file:
        assert [float(row[1]) for row in list(csv.reader(file))[1:]] == pytest.approx(found.frequencies, rel=1e-12)
    with h5py.File(modes / "modes.vtkhdf") as file:
        np.testing.assert_array_equal(file["VTKHDF/Steps/Values"], [1, 2, 3, 4])
    assert "Frequency [Hz]" in (modes / "report.html").read_text()


def test_stored_model_does_not_need_the_file_of_its_table(lamella, bent: Path, tmp_path: Path) -> None:
    assert lamella("run", bent, "--out", "out", "--no-pictures").returncode == 0
    (bent.parent / "load.csv").unlink()
    again = lamella("run", "out/along/model.yaml", "--out", "again", "--no-pictures")
    assert again.returncode == 0, again.stderr
    ends = [read_result(tmp_path / name / "along/run.h5").history("tip.position")[-1] for name in ("out", "again")]
    np.testing.assert_array_equal(*ends)
    missing = lamella("run", bent, "--out", "other")
    assert missing.returncode == 2
    assert "system.load.profile.file: " in missing.stderr
    assert f"{bent.parent / 'load.csv'}': the file cannot be read" in missing.stderr
    assert not (tmp_path / "other").exists()
