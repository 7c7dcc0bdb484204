"""A closed shell from its model file to results, pictures and their description, from the command line."""

from __future__ import annotations

from pathlib import Path

import h5py
import numpy as np

from lamella.io.results import read_result

TANK = """\
lamella: 1
title: Tank
system:
  tank:
    type: shell
    surface: {kind: cylinder, radius: 500 mm, length: 1 m, closed: true}
    mesh: [12, 2]
    laminate: {ply: {type: isotropic, E: 70 GPa, nu: 0.3, rho: 2700}, thickness: 2 mm}
    thickness_factors: [[1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1], [2, 2, 2, 2, 2, 2, 2, 2, 2, 2, 2, 2]]
    ply_direction: [0, 0, 1]
    markers: {top: [0, 1 m]}
  foot: {type: clamp, on: tank.y-}
  inside: {type: pressure, on: tank, pressure: -0.1 MPa}
analysis:
  filled: {type: statics}
"""


def test_a_tank_is_run_shown_and_exported(here, tmp_path: Path) -> None:
    (tmp_path / "tank.yaml").write_text(TANK)
    done = here("run", "tank.yaml", "--out", "out")
    assert done.returncode == 0, done.stderr
    result = read_result(tmp_path / "out/run.h5")
    sample = result.plate("tank")
    np.testing.assert_allclose(sample.r[:, 0], sample.r[:, -1], atol=1e-12)  # it is closed
    assert result["top.position"].values[0] > 0.5  # and has grown
    assert {path.name for path in (tmp_path / "out/pictures").iterdir()} >= {"shape.png"}
    shown = here("info", "out").stdout
    assert "plates 1" in shown
    assert "coordinates 432" in shown  # 12 nodes around and 3 along, 12 each
    with h5py.File(tmp_path / "out/surface.vtkhdf") as file:
        assert file["VTKHDF/NumberOfPoints"][0] > 0
    assert here("export", "out", "--to", "yaml").returncode == 0
    assert "closed: true" in (tmp_path / "out/model.yaml").read_text()


def test_a_surface_that_does_not_close_is_told_by_its_key(here, tmp_path: Path) -> None:
    (tmp_path / "tank.yaml").write_text(TANK.replace("closed: true", "closed: true, angle: [0, 350 deg]"))
    done = here("run", "tank.yaml", "--out", "out")
    assert done.returncode == 2
    assert "system.tank.surface" in done.stderr
    assert "its ends do not meet: the angle spans 350 deg" in done.stderr


def test_an_edge_that_is_not_there_is_told(here, tmp_path: Path) -> None:
    (tmp_path / "tank.yaml").write_text(TANK.replace("on: tank.y-}", "on: tank.x-}"))
    done = here("run", "tank.yaml", "--out", "out")
    assert done.returncode == 2
    assert "closed along x; its edges are y- and y+" in done.stderr
