"""Natural modes and buckling shapes as a file and as frames of a result.

The file is HDF5 with the layout of netCDF-4, like result files:

    /mode, /coordinate         numbers of the shapes, from 1, and of the coordinates
    /frequency                 (mode,) [Hz]; negative for an unstable mode; of natural modes
    /load_factor               (mode,); of buckling shapes
    /shapes                    (mode, coordinate), normalised by phi^T M phi = 1, or phi^T K phi = 1 of buckling shapes
    /quadrature                (mode, coordinate), the part a quarter of a period late; of modes in a frame that spins
    /imperfection              (coordinate,), added to the stress-free geometry; only where there is one
    /state                     (coordinate,), about which the shapes are
    attributes of /            format, format_version, versions, created, title, model
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from lamella.arguments import PATH, accepts, instance
from lamella.dofs import Signal
from lamella.errors import DeclarationError, ResultFileError
from lamella.io.result_layout import Node, is_file, is_hdf5, origin, plain, refuse_unfit
from lamella.modal import Modes
from lamella.result import Cause, Outcome, Recorder, Result, Statistics
from lamella.shapes import Shapes
from lamella.stability import Buckling
from lamella.state import State
from lamella.viz.solids import drawable, shaped, surface
from lamella.whole import replaced_hdf5

FORMAT, FORMAT_VERSION = "lamella modes", "1.0"
AXIS = "mode"
SHARE = 0.12
"""Largest displacement of a drawn shape as a share of the largest extent of the bodies."""


@accepts(modes=instance("natural modes or buckling shapes", Shapes), path=PATH)
def write_modes(modes: Shapes, path: str | Path, *, model_text: str | None = None, title: str = "") -> Path:
    """Write shapes and their values to an HDF5 file; an existing one is replaced only when the new one is whole.

    Args:
        modes: what was computed.
        path: file to write.
        model_text: the model file; made from the system when left out.
        title: one line for people.

    Raises:
        ResultFileError: ``path`` is another kind of file, or cannot be written.
    """
    path = Path(path)
    refuse_unfit(path)
    with replaced_hdf5(path, track_order=True) as file:
        text = _text(modes) if model_text is None else model_text
        file.attrs.update(plain({"format": FORMAT, "format_version": FORMAT_VERSION, "title": title, "model": text}))
        file.attrs.update(plain(origin()))
        _write(file, modes)
    return path


@accepts(path=PATH)
def read_modes(path: str | Path) -> Modes | Buckling:
    """Read a file of natural modes or buckling shapes; the model is compiled from the stored model file.

    Raises:
        ResultFileError: no such file, not a file of modes, damaged, or without a model.
    """
    import h5py

    path = Path(path)
    if not is_file(path) or not is_modes_file(path):
        raise ResultFileError(
            f"'{path}' is not a file of modes; accepted is one written for an analysis natural_modes or buckling"
        )
    try:
        with h5py.File(path, "r", locking=False) as file:
            text = str(file.attrs["model"])
            root: Node = file
            kind = Buckling if Buckling.quantity[0] in root else Modes
            values, shapes, state = (np.asarray(root[name][()]) for name in (kind.quantity[0], "shapes", "state"))
            imperfection = np.asarray(root["imperfection"][()]) if "imperfection" in root else None
            late = np.asarray(root["quadrature"][()]).T if "quadrature" in root else None
    except (OSError, KeyError, RuntimeError, ValueError, TypeError) as error:  # what h5py raises for a truncated or altered file
        raise ResultFileError(f"file of modes '{path}' is damaged or cannot be read: {error}") from error
    if not text:
        raise ResultFileError(f"'{path}' holds no model; accepted are modes of a model that can be written as a model file")
    from lamella.io.model_file import loads

    model = loads(text, name=str(path)).system.compile(imperfection)
    return Buckling(model, values, shapes.T, state) if kind is Buckling else Modes(model, values, shapes.T, state, late)


def is_modes_file(path: Path) -> bool:
    """Whether a file is one of modes."""
    import h5py

    if not is_hdf5(path):
        return False
    try:
        with h5py.File(path, "r", locking=False) as file:
            return file.attrs.get("format", "") == FORMAT
    except OSError:  # truncated
        return False


def mode_frames(modes: Shapes, amplitude: float, count: int | None = None) -> Result:
    """A frame for each shape, over its number: the state with the shape added.

    Displacements are counted from the state that the shapes are about, so they show the shape alone.

    Args:
        modes: what was computed.
        amplitude: largest displacement of each shape [m].
        count: number of shapes, all when left out.
    """
    count = min(count or len(modes.values), len(modes.values))
    name, unit, meaning = modes.quantity
    model = replace(modes.model, q0=modes.state)
    numbers = [float(number) for number in range(1, count + 1)]
    shapes = [modes.displaced(mode, amplitude) for mode in range(count)]
    unknown, none = np.full(len(modes.state), np.nan), np.empty(0)
    last = State(0.0, shapes[-1], unknown, unknown, none, none)
    recorder = Recorder(
        [Signal(name, unit, (), lambda state: np.nan, meaning)],
        AXIS,
        numbers[0],
        numbers[-1],
        at=numbers,
        values=[np.array([value]) for value in modes.values[:count]],
        frame_at=numbers,
        frame_q=shapes,
        frame_v=[unknown] * count,
    )
    return Result(model, recorder, last, Outcome(Cause.COMPLETED, numbers[-1], numbers[-1]), Statistics())


def natural_amplitude(modes: Shapes) -> float:
    """A largest displacement that shows shapes well [m]: a share of the largest extent of the bodies.

    Raises:
        DeclarationError: the model has nothing to draw.
    """
    if not drawable(modes.model):
        raise DeclarationError("modes", "the model has nothing to show", "accepted is one with a plate, or a body with a shape")
    solids = [surface(body, modes.state)[0] for body in shaped(modes.model)]
    positions = np.concatenate([modes.model.vectors(modes.state)[modes.model.is_position], *solids])
    return SHARE * float(np.ptp(positions, axis=0).max())


def _write(file: Node, modes: Shapes) -> None:
    scales = {AXIS: np.arange(1, len(modes.values) + 1), "coordinate": np.arange(len(modes.state))}
    for name, numbers in scales.items():
        file.create_dataset(name, data=numbers).attrs.update({"units": "1", "long_name": f"number of the {name}"})
        file[name].make_scale(name)
    quantity, of, meaning = modes.quantity
    late = modes.quadrature if isinstance(modes, Modes) else None
    for name, values, axes, unit, label in (
        (quantity, modes.values, (AXIS,), of, meaning),
        ("shapes", modes.shapes.T, (AXIS, "coordinate"), "1", f"shape, normalised by {modes.scaling}"),
        ("quadrature", None if late is None else late.T, (AXIS, "coordinate"), "1", "part of the shape a quarter period late"),
        ("imperfection", modes.model.imperfection, ("coordinate",), "m, 1", "added to the stress-free geometry"),
        ("state", modes.state, ("coordinate",), "m, 1", "coordinates about which the shapes are"),
    ):
        if values is None:
            continue
        dataset = file.create_dataset(name, data=values)
        dataset.attrs.update({"units": unit, "long_name": label})
        for dimension, axis in zip(dataset.dims, axes, strict=True):
            dimension.attach_scale(file[axis])


def _text(modes: Shapes) -> str:
    from lamella.io.writer import dumps

    try:
        return dumps(modes.model.description) if modes.model.description is not None else ""
    except DeclarationError:  # forces written in Python and the like: the modes are complete without their model file
        return ""
