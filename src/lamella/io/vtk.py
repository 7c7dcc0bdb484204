"""ParaView output: the moving surface with its fields as one VTKHDF file with a time series.

Each plate is a grid of quadrilaterals whose topology is written once; positions and fields follow, frame after frame, and the
``Steps`` group says where each frame begins. All plates and the surfaces of all rigid bodies are one unstructured grid; the
cell arrays ``plate`` and ``rigid_body`` number them, -1 being a cell of the other kind. A rigid body has displacement and
velocity; its other fields are NaN.

Numbers are stored in single precision, which is beyond what a picture shows, and compressed (gzip).

Source: VTK documentation, VTKHDF format specification, version 2, "Temporal UnstructuredGrid and PolyData".
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from lamella.arguments import PATH, TEXT, accepts, at_least, instance, optional, sequence
from lamella.errors import ResultFileError
from lamella.io.result_layout import Node, refuse_unfit
from lamella.result import Result
from lamella.roles import Floats, Ints
from lamella.viz.fields import Snapshot, SurfaceField, SurfaceSampler, available
from lamella.viz.solids import SolidSampler, SolidShot, drawable
from lamella.whole import replaced_hdf5

VERSION = (2, 0)
VTK_TRIANGLE, VTK_QUAD = 5, 9
OWNERS = ("plate", "rigid_body")
TOGETHER = 8192
"""Points of the frames that are evaluated, compressed and written at once: for those of one frame the calls take longest."""
PACKED: dict[str, Any] = {"dtype": "f4", "compression": "gzip", "compression_opts": 1, "shuffle": True}
"""More than the least compression takes half as long again and saves 3 %."""


@accepts(result=instance("a result", Result), path=PATH, per_element=at_least(1), fields=optional(sequence(TEXT)))
def write_vtkhdf(result: Result, path: str | Path, *, per_element: int = 4, fields: Sequence[str] | None = None) -> Path:
    """Write the frames of a result for ParaView (File > Open, reader "VTKHDF").

    Args:
        result: of a solution, or read from a file.
        path: file to write, by custom ``*.vtkhdf``; an existing HDF5 file is replaced when the new one is whole.
        per_element: grid intervals along each side of an element.
        fields: names from :data:`lamella.viz.fields.FIELDS`; by default all that the result can give.

    Raises:
        DeclarationError: ``per_element`` or ``fields`` is of another kind.
        ResultFileError: the result has no frame or nothing to draw, a field is not available, or the file cannot be written.
    """
    path = Path(path)
    refuse_unfit(path)
    chosen = _choose(result, fields)
    if not len(result.frame_at) or not drawable(result.model):
        raise ResultFileError(
            f"'{path}': the result has no frame of a plate or of a body with a shape; accepted is a run that got beyond its start"
        )
    with replaced_hdf5(path) as file:
        _write(file.create_group("VTKHDF"), result, per_element, chosen)
    return path


def _choose(result: Result, names: Sequence[str] | None) -> list[SurfaceField]:
    there = {field.name: field for field in available(result)}
    unknown = [name for name in names or () if name not in there]
    if unknown:
        raise ResultFileError(f"no field '{unknown[0]}' in this result; available are {', '.join(there)}")
    return list(there.values()) if names is None else [there[name] for name in names]


def _write(group: Node, result: Result, per_element: int, fields: list[SurfaceField]) -> None:
    n_frames = len(result.frame_at)
    group.attrs["Version"] = np.array(VERSION, dtype="i8")
    group.attrs.create("Type", b"UnstructuredGrid", dtype="S16")  # VTK reads fixed-length ASCII only
    plates, bodies = SurfaceSampler(result, per_element), SolidSampler(result)
    n_points = _write_topology(group, plates.at(0), bodies.at(0))
    burst = min(max(TOGETHER // n_points, 1), n_frames)
    n, chunk = n_frames * n_points, burst * n_points
    points = _create_array(group, "Points", 3, n, chunk)
    data = group.create_group("PointData")
    arrays = [points, *(_create_field(data, field, n, chunk) for field in fields)]
    for first in range(0, n_frames, burst):
        frames = slice(first, first + burst)
        for array, column in zip(arrays, _columns(plates.at(frames), bodies.at(frames), fields), strict=True):
            array[first * n_points : first * n_points + len(column)] = column.astype("f4")  # HDF5 would take twice as long
    _write_steps(group, result.frame_at, n_points, fields)


def _columns(shots: list[Snapshot], solids: list[SolidShot], fields: list[SurfaceField]) -> list[Floats]:
    """Points and fields, shapes (n, 3), (n,) or (n, components): those of all points in one frame after those in another."""
    columns = [_joined([*(shot.now.r for shot in shots), *(solid.points for solid in solids)], 3)]
    for field in fields:
        width = len(field.labels) or 1
        column = _joined(
            [*(field.evaluate(shot) for shot in shots), *(_on_solid(field, solid, width) for solid in solids)], width
        )
        columns.append(column if field.labels else column[:, 0])
    return columns


def _joined(parts: list[Floats], width: int) -> Floats:
    """Values of all plates and bodies in the frames, which come first in each, shape (n, width)."""
    return np.concatenate([part.reshape(len(part), -1, width) for part in parts], axis=1).reshape(-1, width)


def _on_solid(field: SurfaceField, solid: SolidShot, width: int) -> Floats:
    """Values of a field at the vertices of a rigid body, shape (n_frames, n, width)."""
    known = {"displacement": solid.displacement, "velocity": solid.velocity}
    return known.get(field.name, np.full((*solid.points.shape[:-1], width), np.nan))


def _write_topology(group: Node, shots: list[Snapshot], solids: list[SolidShot]) -> int:
    """Cells of all plates and rigid bodies; returns the number of points."""
    faces, owners, first = [], [], 0
    for number, shot in enumerate(shots):
        my, mx = shot.now.r.shape[:2]
        faces.append(quadrilaterals(my, mx) + first)
        owners.append(np.tile([number, -1], (len(faces[-1]), 1)))
        first += my * mx
    for number, solid in enumerate(solids):
        faces.append(solid.faces + first)
        owners.append(np.tile([-1, number], (len(faces[-1]), 1)))
        first += len(solid.points)
    corners = np.concatenate(faces)
    is_triangle = corners[:, 2] == corners[:, 3]
    used = np.stack([*3 * [np.ones(len(corners), bool)], ~is_triangle], axis=1)
    group["NumberOfPoints"], group["NumberOfCells"] = np.array([first]), np.array([len(corners)])
    group["NumberOfConnectivityIds"] = np.array([used.sum()])
    group["Connectivity"], group["Offsets"] = corners[used], np.concatenate([[0], np.cumsum(used.sum(axis=1))])
    group["Types"] = np.where(is_triangle, VTK_TRIANGLE, VTK_QUAD).astype("u1")
    cells = group.create_group("CellData")
    for name, numbers in zip(OWNERS, np.concatenate(owners).T, strict=True):
        cells[name] = numbers
    return first


def quadrilaterals(my: int, mx: int) -> Ints:
    """Corners of the cells of a structured grid whose point (i, j) has number j mx + i; shape ((my - 1) (mx - 1), 4)."""
    corner = (np.arange(my - 1)[:, None] * mx + np.arange(mx - 1)).reshape(-1, 1)
    return corner + np.array([0, 1, mx + 1, mx])


def _create_array(group: Node, name: str, width: int, n: int, chunk: int) -> Node:
    """An array of ``n`` points, those of all frames one after another, compressed by ``chunk`` of them."""
    more = (width,) if width else ()
    return group.create_dataset(name, (n, *more), chunks=(chunk, *more), **PACKED)


def _create_field(data: Node, field: SurfaceField, n: int, chunk: int) -> Node:
    array = _create_array(data, field.name, len(field.labels), n, chunk)
    array.attrs.update({"units": field.unit, "long_name": field.title})
    return array


def _write_steps(group: Node, at: Floats, n_points: int, fields: list[SurfaceField]) -> None:
    """Where each frame begins: points and fields move on, the cells and their numbers stay."""
    steps, n = group.create_group("Steps"), len(at)
    steps.attrs["NSteps"] = n
    steps["Values"] = at
    moving, still = n_points * np.arange(n), np.zeros(n, dtype="i8")
    steps["PointOffsets"], steps["PartOffsets"], steps["NumberOfParts"] = moving, still, np.ones(n, dtype="i8")
    steps["CellOffsets"], steps["ConnectivityIdOffsets"] = still[:, None], still[:, None]
    for name in [field.name for field in fields]:
        steps[f"PointDataOffsets/{name}"] = moving
    for name in OWNERS:
        steps[f"CellDataOffsets/{name}"] = still
