"""The layout of a result file: what is where in the HDF5 file, and how it is created."""

from __future__ import annotations

import contextlib
import os
import re
import shutil
from collections.abc import Mapping, Sequence
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import numpy as np

from lamella.critical import CriticalPoint
from lamella.dofs import Signal
from lamella.errors import ResultFileError
from lamella.io.provenance import versions
from lamella.result import Happening, Start
from lamella.roles import Floats
from lamella.state import State
from lamella.stepping.saved import decoded, encoded

Node = Any
"""A file, group or dataset of h5py, whose own types leave open which of them a look-up gives."""

FORMAT = "lamella result"
FORMAT_VERSION = "1.0"
AXIS_UNIT = {"time": "s", "load_factor": "1", "path": "1"}
AXIS_NAME = {"load_factor": "factor of loads and support motions", "path": "number of the point on the equilibrium path"}
VECTOR = ("x", "y", "z")
_SIGNATURE = b"\x89HDF\r\n\x1a\n"


def create_file(path: Path, overwrite: bool, shown: str | Path) -> Node:
    """Create an empty result file, which messages call ``shown``; an existing one is replaced only with ``overwrite``.

    Raises:
        ResultFileError: the file exists, is not a result file, or its folder cannot be written.
    """
    import h5py

    refuse_unfit(path)
    if path.exists() and not path.is_file():  # it would be removed, and HDF5 writes here and there in its file
        raise ResultFileError(f"result file '{path}' is a device; accepted is the name of a file")
    if path.exists() and not overwrite:
        raise ResultFileError(f"result file '{path}' exists already; choose another name or ask to overwrite it")
    try:
        path.unlink(missing_ok=True)
        return h5py.File(path, "x", track_order=True, locking=False)  # unlocked: others may look at the running file
    except OSError as error:
        with contextlib.suppress(OSError):
            path.unlink(missing_ok=True)  # HDF5 leaves an empty one where the disk is full
        why = os.strerror(error.errno) if error.errno else error  # HDF5's own text has addresses in it
        raise ResultFileError(
            f"result file '{shown}' cannot be created: {why}; accepted is a file in a writable folder"
        ) from error


def refuse_unfit(path: Path) -> None:
    """Refuse a path in a folder that is not there, or of something that is no HDF5 file, such as the model file by mistake."""
    try:
        path.lstat()
    except FileNotFoundError:
        pass
    except (OSError, ValueError) as error:  # too long a name, or one with a null character
        why = getattr(error, "strerror", error)
        raise ResultFileError(f"result file {str(path)!r} cannot be written: {why}; accepted is another name") from error
    if not path.parent.is_dir():
        raise ResultFileError(f"result file '{path}': folder '{path.parent}' does not exist; create it or choose another")
    if path.is_dir():
        raise ResultFileError(f"result file '{path}' is a folder; accepted is the name of a file")
    if path.exists() and path.stat().st_size and not is_hdf5(path):
        raise ResultFileError(f"'{path}' exists and is not a result file, so it is not replaced; choose another name")


def is_file(path: Path) -> bool:
    """Whether there is such a file; none has a name too long for one."""
    try:
        return path.is_file()
    except OSError:
        return False


def is_hdf5(path: Path) -> bool:
    """Whether a file begins as HDF5 files do."""
    with path.open("rb") as file:
        return file.read(len(_SIGNATURE)) == _SIGNATURE


def describe(root: Node, axis: str, *, model: tuple[str, str], title: str, target: float) -> None:
    """Write what a new file is of; ``model`` is its text, or none and why."""
    root.attrs.update(plain({"format": FORMAT, "format_version": FORMAT_VERSION, "axis": axis, "title": title}))
    root.attrs.update(plain({**origin(), "model": model[0], "model_missing": model[1]}))
    write_outcome(root, "running", float("nan"), target, "")


def reserve(path: Path, end: int, size: int) -> None:
    """Make sure that ``size`` bytes from ``end`` of a file can be written.

    Raises:
        OSError: the disk is full, or a quota or limit is reached.
    """
    if not hasattr(os, "posix_fallocate"):  # Windows and macOS: the free space is the best that can be known
        free = shutil.disk_usage(path.parent).free
        if free < size:
            raise OSError(f"the disk has {free / 1e6:.1f} MB left")
        return
    descriptor = os.open(path, os.O_RDWR)
    try:
        os.posix_fallocate(descriptor, end, size)
    finally:
        os.close(descriptor)


def room_for(datasets: Mapping[str, Node], count: int) -> int:
    """Bytes by which the file grows at most when so many rows are appended to each, whole chunks and indices included."""
    size = 0
    for dataset in datasets.values() if count else ():
        chunk = int(np.prod(dataset.chunks)) * dataset.dtype.itemsize
        size += (count // dataset.chunks[0] + 2) * (chunk + 4096)
    return size


def lay_out_signals(root: Node, signals: Sequence[Signal], axis: str) -> dict[str, Node]:
    """Create the empty datasets of the samples, and return them by name: to look one up takes longer than to write to it."""
    group = root.create_group("signals", track_order=True)
    at = _scale(group, axis, AXIS_UNIT.get(axis, "1"))
    datasets = {axis: at}
    for signal in signals:
        if signal.name == axis:  # a static solution samples its load factor, which is already the axis
            continue
        shape, limit = ((0,), (None,)) if not signal.labels else ((0, len(signal.labels)), (None, len(signal.labels)))
        dataset = group.create_dataset(signal.name, shape, "f8", maxshape=limit, chunks=(512, *shape[1:]))
        dataset.attrs.update(plain({"units": signal.unit, "long_name": signal.description or signal.name}))
        dataset.dims[0].attach_scale(at)
        if signal.labels:
            dataset.dims[1].attach_scale(_component_scale(group, signal.labels))
        datasets[signal.name] = dataset
    return datasets


def lay_out_frames(root: Node, axis: str, n_q: int) -> dict[str, Node]:
    """Create the empty datasets of the frames, and return them by name."""
    group = root.create_group("frames")
    at = _scale(group, axis, AXIS_UNIT.get(axis, "1"))
    coordinate = group.create_dataset("coordinate", data=np.arange(n_q))
    coordinate.attrs.update(plain({"units": "1", "long_name": "number of the coordinate, three to a vector"}))
    coordinate.make_scale("coordinate")
    datasets = {axis: at}
    rows = max(1, min(64, 65536 // (8 * max(n_q, 1))))
    for name, label in (("q", "coordinates (positions [m] and slopes)"), ("v", "rates of the coordinates")):
        dataset = group.create_dataset(name, (0, n_q), "f8", maxshape=(None, n_q), chunks=(rows, max(n_q, 1)) if n_q else True)
        dataset.attrs.update(plain({"units": "m, 1" if name == "q" else "m/s, 1/s", "long_name": label}))
        dataset.dims[0].attach_scale(at)
        dataset.dims[1].attach_scale(coordinate)
        datasets[name] = dataset
    return datasets


def _scale(group: Node, axis: str, unit: str) -> Node:
    dataset = group.create_dataset(axis, (0,), "f8", maxshape=(None,), chunks=(1024,))
    dataset.attrs.update(plain({"units": unit, "long_name": AXIS_NAME.get(axis, axis.replace("_", " "))}))
    dataset.make_scale(axis)
    return dataset


def _component_scale(group: Node, labels: tuple[str, ...]) -> Node:
    import h5py

    name = "component" if labels == VECTOR else "component_" + re.sub(r"\W+", "_", "_".join(labels))
    if name not in group:
        dataset = group.create_dataset(name, data=list(labels), dtype=h5py.string_dtype())
        dataset.attrs.update(plain({"long_name": "component"}))
        dataset.make_scale(name)
    return group[name]


def append(dataset: Node, values: Floats) -> None:
    """Add rows at the end of a dataset."""
    start = dataset.shape[0]
    dataset.resize(start + len(values), axis=0)
    dataset[start:] = values


def write_outcome(root: Node, outcome: str, reached: float, target: float, detail: str) -> None:
    """Say at the root how the run ended, or that it is running."""
    root.attrs.update({"outcome": outcome, "reached": float(reached), "target": float(target), "detail": detail})


CHANGES = ("displacement", "turn", "velocity", "spin")


def write_start(root: Node, start: Start) -> None:
    """Say at the root what was changed in the initial state."""
    for name in CHANGES:
        root.attrs[f"start_{name}"] = float(getattr(start, name))
    root.attrs.update(plain({"start_where": "\n".join(start.where), "start_left_out": "\n".join(start.left_out)}))


def read_start(attributes: Mapping[str, object]) -> Start:
    """What :func:`write_start` wrote; nothing changed when it wrote nothing."""
    if "start_where" not in attributes:
        return Start()
    displacement, turn, velocity, spin = (float(str(attributes[f"start_{name}"])) for name in CHANGES)
    displaced, turned, quickened, spun = str(attributes["start_where"]).split("\n")
    left_out = tuple(line for line in str(attributes["start_left_out"]).split("\n") if line)
    return Start(displacement, turn, velocity, spin, (displaced, turned, quickened, spun), left_out)


def write_events(group: Node, events: Sequence[Happening]) -> None:
    """Write when which events happened."""
    import h5py

    at = group.create_dataset("time", data=[event.t for event in events], dtype="f8")
    at.attrs.update(plain({"units": "s", "long_name": "time of the event"}))
    at.make_scale("time")
    for name, label in (("name", "name of the event or latch"), ("text", "what happened")):
        words = [getattr(event, name).replace("\x00", "") for event in events]
        dataset = group.create_dataset(name, (len(words),), h5py.string_dtype(), data=words or None)
        dataset.attrs.update(plain({"long_name": label}))
        dataset.dims[0].attach_scale(at)


def read_events(root: Node) -> tuple[Happening, ...]:
    """What :func:`write_events` wrote; nothing where the run was not closed."""
    group = root.get("events", {})
    if "time" not in group:
        return ()
    columns = group["time"][()].tolist(), group["name"].asstr()[()].tolist(), group["text"].asstr()[()].tolist()
    return tuple(Happening(t, name, text) for t, name, text in zip(*columns, strict=True))


BESIDE = {
    "a": "second rates of the coordinates",
    "lam": "multipliers of the constraints",
    "reaction": "forces of the eliminated constraints",
}
"""Arrays of a state beside coordinates and velocities."""


def remembered(state: State) -> bytes:
    """What a state remembers, see :meth:`lamella.model.Model.remembering`, as bytes; none where it remembers nothing."""
    return b"" if state.memory is None else encoded(state.memory)


def room_for_final(state: State) -> int:
    """Bytes by which the file grows at most with :func:`write_final`."""
    return 4096 + len(remembered(state)) + 8 * (2 * len(state.a) + len(state.lam))


def write_final(group: Node, state: State) -> None:
    """Write of the last state what its frame does not hold."""
    group.attrs.update({"time": state.t, "factor": state.factor})
    for name, label in BESIDE.items():
        group.create_dataset(name, data=getattr(state, name)).attrs.update(plain({"long_name": label}))
    memory = group.create_dataset("memory", data=np.frombuffer(remembered(state), np.uint8))
    memory.attrs.update(plain({"long_name": "what the last state remembers: turns, latches, bristles and the like, as JSON"}))


def read_final(root: Node) -> dict[str, Any] | None:
    """What :func:`write_final` wrote, by the names of a state; None where the run was not closed, and in older files."""
    if "final" not in root:
        return None
    group = root["final"]
    memory = group["memory"][()].tobytes()
    numbers = {"t": float(group.attrs["time"]), "factor": float(group.attrs["factor"])}
    return {**numbers, **{name: group[name][()] for name in BESIDE}, "memory": decoded(memory) if memory else None}


def write_critical_points(group: Node, points: Sequence[CriticalPoint]) -> None:
    """Write where the stiffness became singular, with the null vectors and the equilibria."""
    import h5py

    numbers = group.create_dataset("point", data=np.arange(1, len(points) + 1))
    numbers.attrs.update(plain({"units": "1", "long_name": "number of the critical point"}))
    numbers.make_scale("point")
    for name, unit, label in (
        ("factor", "1", "load factor"),
        ("at", "1", "place on the axis of the result"),
        ("negative", "1", "negative eigenvalues of the stiffness before and behind the point"),
        ("shape", "m, 1", "null vector of the stiffness, its largest displacement 1 m"),
    ):
        dataset = group.create_dataset(name, data=np.array([getattr(point, name) for point in points]))
        dataset.attrs.update(plain({"units": unit, "long_name": label}))
        dataset.dims[0].attach_scale(numbers)
    for name, label in (("t", "time"), ("q", "coordinates of the equilibrium"), ("lam", "multipliers of the constraints")):
        dataset = group.create_dataset(name, data=np.array([getattr(point.state, name) for point in points]))
        dataset.attrs.update(plain({"units": "s" if name == "t" else "m, 1", "long_name": label}))
        dataset.dims[0].attach_scale(numbers)
    kinds = group.create_dataset("kind", (len(points),), h5py.string_dtype(), data=[point.kind for point in points])
    kinds.attrs.update(plain({"long_name": "limit point or bifurcation"}))
    kinds.dims[0].attach_scale(numbers)


def read_critical_points(root: Node) -> tuple[CriticalPoint, ...]:
    """What :func:`write_critical_points` wrote; nothing where there is none."""
    group = root.get("critical_points", {})
    if "point" not in group:
        return ()
    names = ("factor", "at", "kind", "negative", "shape", "t", "q", "lam")
    columns = (group[name].asstr()[()] if name == "kind" else group[name][()] for name in names)
    found = []
    for factor, at, kind, negative, shape, t, q, lam in zip(*columns, strict=True):
        rest = np.zeros_like(q)
        state = State(float(t), q, rest, rest, lam, np.empty(0), float(factor))
        found.append(CriticalPoint(float(factor), float(at), kind, (int(negative[0]), int(negative[1])), shape, state))
    return tuple(found)


def origin() -> dict[str, str]:
    """When and with which versions a file is written, as attributes."""
    packages = {f"{package}_version": version for package, version in versions().items()}
    return {**packages, "created": datetime.now(UTC).isoformat(timespec="seconds")}


def plain(attributes: dict[str, str]) -> dict[str, str]:
    """Attributes as netCDF stores them: no null characters, which end a string in HDF5."""
    return {name: value.replace("\x00", "") for name, value in attributes.items()}
