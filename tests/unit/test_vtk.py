"""ParaView output, read back by VTK's own reader."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import stand_in

import lamella as lm
from lamella.body.shape import FACETS
from lamella.errors import DeclarationError, ResultFileError
from lamella.io import vtk
from lamella.io.vtk import quadrilaterals, write_vtkhdf
from lamella.viz.fields import FIELDS, HEAT, SurfaceSampler

pytest.importorskip("vtkmodules.vtkIOHDF", reason="the reader comes with the extra viz")


class Reader:
    """VTK's reader of the file at its time steps."""

    def __init__(self, path: Path) -> None:
        from vtkmodules.vtkIOHDF import vtkHDFReader

        self.reader = vtkHDFReader()
        self.reader.SetFileName(str(path))
        self.reader.UpdateInformation()
        key = type(self.reader.GetExecutive()).TIME_STEPS()
        self.times = self.reader.GetOutputInformation(0).Get(key)

    def step(self, number: int) -> tuple[Any, dict[str, Any]]:
        from vtkmodules.util.numpy_support import vtk_to_numpy

        self.reader.SetStep(number)
        self.reader.Update()
        grid = self.reader.GetOutputDataObject(0)
        data = grid.GetPointData()
        names = [data.GetArrayName(k) for k in range(data.GetNumberOfArrays())]
        return grid, {name: vtk_to_numpy(data.GetArray(name)).copy() for name in names}


@pytest.mark.parametrize(("plates", "together"), [(1, 8192), (2, 700)])
def test_reader_finds_points_and_fields_of_each_frame(
    tmp_path: Path, plates: int, together: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Whether all frames are written at once or by fours, the last by themselves."""
    monkeypatch.setattr(vtk, "TOGETHER", together)
    result = stand_in.result(plates, **stand_in.STRONG)
    reader = Reader(write_vtkhdf(result, tmp_path / "run.vtkhdf", per_element=2))
    np.testing.assert_array_equal(reader.times, result.frame_at)
    for frame in (0, 4, 9):
        grid, arrays = reader.step(frame)
        shots = SurfaceSampler(result, 2).at(frame)
        from vtkmodules.util.numpy_support import vtk_to_numpy

        expected = np.concatenate([shot.now.r.reshape(-1, 3) for shot in shots])
        np.testing.assert_array_equal(vtk_to_numpy(grid.GetPoints().GetData()), expected.astype(np.float32))
        assert set(FIELDS) - HEAT <= set(arrays)
        for name, field in FIELDS.items():
            if name in HEAT:
                continue
            values = np.concatenate([field.evaluate(shot).reshape(len(expected) // plates, -1) for shot in shots])
            stored = arrays[name].reshape(len(expected), -1)
            np.testing.assert_array_equal(stored, values.astype(np.float32), err_msg=f"{name} at frame {frame}")


def test_cells_cover_each_plate_once(tmp_path: Path) -> None:
    from vtkmodules.util.numpy_support import vtk_to_numpy

    grid, _ = Reader(write_vtkhdf(stand_in.result(2), tmp_path / "run.vtkhdf", per_element=2)).step(0)
    assert grid.GetNumberOfCells() == 2 * 8 * 8
    cells = vtk_to_numpy(grid.GetCells().GetConnectivityArray()).reshape(-1, 4)
    r = vtk_to_numpy(grid.GetPoints().GetData())[cells]
    area = np.linalg.norm(np.cross(r[:, 2] - r[:, 0], r[:, 3] - r[:, 1]), axis=1) / 2
    owner = vtk_to_numpy(grid.GetCellData().GetArray("plate"))
    for number in (0, 1):
        # 1.5 m x 2 m, flat at the first frame; corners in single precision
        assert area[owner == number].sum() == pytest.approx(3.0, rel=1e-6)
    assert np.all(np.cross(r[:, 1] - r[:, 0], r[:, 3] - r[:, 0])[:, 2] > 0)  # turned about the normal


def test_fields_have_their_values() -> None:
    result = stand_in.result(**stand_in.STRONG)
    shot = SurfaceSampler(result, 4).at(5)[0]  # deepest deflection, t = 0.25 s
    section = shot.plate.laminate
    x, y = shot.now.x, shot.now.y
    deflection = -0.5 * (x / 1.5) ** 2 * (1 + 0.3 * y[:, None])
    np.testing.assert_allclose(FIELDS["displacement"].evaluate(shot)[..., 2], deflection, atol=1e-12)
    np.testing.assert_allclose(FIELDS["normal"].evaluate(shot)[:, 0], np.tile([0, 0, 1.0], (len(y), 1)), atol=1e-12)
    strains = shot.now.strains
    z = section.h / 2
    top = (strains[..., :3] - z * strains[..., 3:]) @ section.Dk[-1]
    s_x, s_y, t = np.moveaxis(top, -1, 0)
    np.testing.assert_allclose(FIELDS["von_mises_top"].evaluate(shot), np.sqrt(s_x**2 - s_x * s_y + s_y**2 + 3 * t**2))
    largest = FIELDS["von_mises"].evaluate(shot)
    assert np.all(largest >= np.maximum(FIELDS["von_mises_top"].evaluate(shot), FIELDS["von_mises_bottom"].evaluate(shot)))
    eps, kap = strains[..., :3], strains[..., 3:]
    energy = 0.5 * (np.sum(eps @ section.A * eps, -1) + np.sum(kap @ section.D * kap, -1)) - np.sum(eps @ section.B * kap, -1)
    np.testing.assert_allclose(FIELDS["strain_energy_density"].evaluate(shot), energy)


def test_velocity_is_the_rate_of_the_displacement() -> None:
    shot = SurfaceSampler(stand_in.result(frames=20), 2).at(5)[0]  # t = 0.125 s, fastest
    s = shot.now.x / 1.5
    speed = -0.5 * 2 * np.pi * s**2 * (1 + 0.3 * shot.now.y[:, None])  # d/dt sin^2(2 pi t) = 2 pi sin(4 pi t)
    np.testing.assert_allclose(FIELDS["velocity"].evaluate(shot)[..., 2], speed, atol=1e-7)  # central difference of the stand-in


def test_only_what_a_result_holds_is_written(tmp_path: Path) -> None:
    result = stand_in.result()
    del result.frame_v  # type: ignore[attr-defined]
    _, arrays = Reader(write_vtkhdf(result, tmp_path / "run.vtkhdf")).step(1)
    assert set(arrays) == set(FIELDS) - HEAT - {"velocity", "tsai_hill", "tsai_wu"}
    _, arrays = Reader(write_vtkhdf(result, tmp_path / "one.vtkhdf", fields=["displacement"])).step(1)
    assert set(arrays) == {"displacement"}
    with pytest.raises(ResultFileError, match="no field 'tsai_wu' in this result; available are displacement"):
        write_vtkhdf(result, tmp_path / "none.vtkhdf", fields=["tsai_wu"])
    with pytest.raises(DeclarationError, match="fields = 'displacement'; accepted is a list of a text, or None"):
        write_vtkhdf(result, tmp_path / "none.vtkhdf", fields="displacement")
    with pytest.raises(DeclarationError, match="per_element = 0; accepted is a whole number, 1 or more"):
        write_vtkhdf(result, tmp_path / "none.vtkhdf", per_element=0)


def test_messages_for_files_that_cannot_be_written(tmp_path: Path) -> None:
    with pytest.raises(ResultFileError, match="does not exist; create it or choose another"):
        write_vtkhdf(stand_in.result(), tmp_path / "nowhere" / "run.vtkhdf")
    (tmp_path / "notes.txt").write_text("keep me")
    with pytest.raises(ResultFileError, match="not replaced"):
        write_vtkhdf(stand_in.result(), tmp_path / "notes.txt")
    empty = stand_in.result()
    empty.frame_at = np.empty(0)
    with pytest.raises(ResultFileError, match="no frame of a plate or of a body with a shape"):
        write_vtkhdf(empty, tmp_path / "run.vtkhdf")


def test_quadrilaterals_of_a_small_grid() -> None:
    np.testing.assert_array_equal(quadrilaterals(2, 3), [[0, 1, 4, 3], [1, 2, 5, 4]])


@pytest.mark.parametrize("plates", [0, 2])
def test_rigid_bodies_stand_beside_plates(tmp_path: Path, plates: int) -> None:
    from vtkmodules.util.numpy_support import vtk_to_numpy

    swing = stand_in.pendulum()
    sheets = stand_in.result(plates or 1, frames=len(swing.frame_at) - 1, **stand_in.STRONG)
    if plates:  # one result with the bodies of both
        n = len(swing.model.q0) // 3
        for sheet in sheets.model.plates:
            sheet.first += n  # type: ignore[misc]
        sheets.model.rigid_bodies, sheets.model.q0 = swing.model.rigid_bodies, np.append(swing.model.q0, sheets.model.q0)  # type: ignore[misc]
        sheets.frame_q = np.hstack([swing.frame_q, sheets.frame_q])
        sheets.frame_v = np.hstack([swing.frame_v, sheets.frame_v])
    result = sheets if plates else swing
    reader = Reader(write_vtkhdf(result, tmp_path / "run.vtkhdf", per_element=2))
    arm, ball = swing.model.rigid_bodies[:2]
    for frame in (0, 3):
        grid, arrays = reader.step(frame)
        expected = [body.surface(swing.frame_q[frame])[0] for body in (arm, ball)]
        points = vtk_to_numpy(grid.GetPoints().GetData())[-sum(map(len, expected)) :]
        np.testing.assert_array_equal(points, np.concatenate(expected).astype(np.float32))
        moved = np.concatenate([new - body.surface(swing.model.q0)[0] for new, body in zip(expected, (arm, ball), strict=True)])
        np.testing.assert_array_equal(arrays["displacement"][-len(points) :], moved.astype(np.float32))
        assert np.isnan(arrays["von_mises"][-len(points) :]).all()
        assert np.isfinite(arrays["von_mises"][: -len(points)]).all()
    around = [arm.surface(swing.frame_q[k])[0] for k in (2, 4)]
    speed = (around[1] - around[0]) / (swing.frame_at[4] - swing.frame_at[2])  # second order: it falls almost evenly
    first = len(arrays["velocity"]) - len(points)
    np.testing.assert_allclose(arrays["velocity"][first : first + 8], speed, atol=0.01 * np.abs(speed).max())
    owner = {name: vtk_to_numpy(grid.GetCellData().GetArray(name)) for name in ("plate", "rigid_body")}
    assert np.all((owner["plate"] >= 0) ^ (owner["rigid_body"] >= 0))
    assert (owner["rigid_body"] == 0).sum() == 6  # the faces of a box
    assert set(owner["rigid_body"]) == {0, 1} | ({-1} if plates else set())


def test_triangles_are_written_as_such(tmp_path: Path) -> None:
    system = lm.System()
    system.add(lm.RigidBody("drum", shape=lm.Cylinder(0.5, 1.0), density=1.0, velocity=(1.0, 0.0, 0.0)))
    result = lm.simulate(system, 0.01, lm.GeneralizedAlpha(dt=5e-3))
    grid, _ = Reader(write_vtkhdf(result, tmp_path / "run.vtkhdf")).step(1)
    sizes = [grid.GetCell(k).GetNumberOfPoints() for k in range(grid.GetNumberOfCells())]
    assert (sizes.count(4), sizes.count(3)) == (FACETS, 2 * FACETS)
