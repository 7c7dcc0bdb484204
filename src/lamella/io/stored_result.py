"""A result read back from its file: the same reading interface as the result of a solution in memory."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, NoReturn

import numpy as np

from lamella.arguments import PATH, accepts
from lamella.dofs import Signal
from lamella.errors import ResultFileError
from lamella.io.result_layout import (
    FORMAT,
    FORMAT_VERSION,
    Node,
    is_file,
    is_hdf5,
    read_critical_points,
    read_events,
    read_final,
    read_start,
)
from lamella.result import STEPS_OF_ORDER, Cause, Outcome, Result, Statistics
from lamella.roles import Floats
from lamella.state import State

if TYPE_CHECKING:
    from lamella.model import Model


class StoredResult(Result):
    """A result read from a file; everything a :class:`lamella.result.Result` shows.

    The model is compiled from the stored model file when it is first asked for. The state after the last frame kept is
    ``final``; of a run that was not closed accelerations and multipliers are not stored, and the former are NaN there.

    Args:
        path: where it was read from.
        file: the open file.
    """

    def __init__(self, path: Path, file: Node) -> None:
        self.path, self.attributes = path, {name: _plain(value) for name, value in file.attrs.items()}
        self.axis, self.title, self.model_text = (str(self.attributes[name]) for name in ("axis", "title", "model"))
        self.model_missing = str(self.attributes.get("model_missing", ""))
        self.outcome, self.statistics = _outcome(self.attributes, file), _statistics(file["statistics"])
        group, frames = file["signals"], file["frames"]
        self.at: Floats = group[self.axis][()]
        names = [name for name in group if not group[name].is_scale]
        names = [self.axis, *names] if self.axis == "load_factor" else names  # sampled like a signal, stored once, as the axis
        self.signals = {name: _signal(group, name) for name in names}
        columns = {name: group[name][: len(self.at)] for name in names}
        self._values = {name: column if column.ndim == 2 else column[:, None] for name, column in columns.items()}
        self.frame_at: Floats = frames[self.axis][()]
        self.frame_q: Floats = frames["q"][: len(self.frame_at)]
        self.frame_v: Floats = frames["v"][: len(self.frame_at)]
        self._imperfection: Floats | None = file["imperfection"][()] if "imperfection" in file else None
        self._model: Model | None = None
        self._final = read_final(file)

    @property
    def model(self) -> Model:  # pyright: ignore[reportIncompatibleVariableOverride] -- compiled only when it is needed
        """The compiled model of the stored model file.

        Raises:
            ResultFileError: the result was written without a model file.
        """
        if self._model is None:
            if not self.model_text:
                accepted = "accepted is the result of a model that can be written as a model file"
                why = f" ({self.model_missing})" if self.model_missing else ""
                raise ResultFileError(f"result file '{self.path}' holds no model{why}; {accepted}")
            from lamella.io.model_file import loads  # pydantic and the YAML reader are needed only here

            self._model = loads(self.model_text).system.compile(self._imperfection)
        return self._model

    @property
    def imperfection(self) -> Floats | None:
        """What was added to the stress-free geometry, shape (n_q,); None when it was perfect."""
        return self._imperfection

    @property
    def final(self) -> State:  # pyright: ignore[reportIncompatibleVariableOverride] -- made from the last frame
        """The last frame as a state."""
        if not len(self.frame_at):
            raise ResultFileError(f"result file '{self.path}' holds no frame; accepted is a run that got beyond its start")
        if self._final is not None:
            return State(q=self.frame_q[-1], v=self.frame_v[-1], **self._final)
        factors = self._values.get("load_factor", np.ones((len(self.at), 1)))
        factor = float(factors[np.searchsorted(self.at, self.frame_at[-1]), 0])
        t = float(self.frame_at[-1]) if self.axis == "time" else 0.0
        unknown = np.full(self.frame_q.shape[1], np.nan)
        return State(t, self.frame_q[-1], self.frame_v[-1], unknown, np.empty(0), np.empty(0), factor)


@accepts(path=PATH)
def read_result(path: str | Path) -> StoredResult:
    """Read a result file, also one whose run was killed or is still going on.

    Raises:
        ResultFileError: no such file, not a result file, damaged, or of a newer format.
    """
    import h5py

    path = Path(path)
    if not is_file(path):
        raise ResultFileError(f"result file '{path}' does not exist; accepted is a file written by lamella run or Result.save")
    other = f"'{path}' is not a result file; accepted is a file written by lamella run or Result.save"
    try:
        if not is_hdf5(path):
            raise ResultFileError(other)
        with h5py.File(path, "r", locking=False) as file:  # unlocked: the run may still be writing
            if _plain(file.attrs.get("format", "")) != FORMAT:
                raise ResultFileError(other)
            version = str(_plain(file.attrs["format_version"]))
            if version.split(".")[0] != FORMAT_VERSION.split(".")[0]:
                raise ResultFileError(f"result file '{path}' has format {version}; accepted is {FORMAT_VERSION}")
            return StoredResult(path, file)
    except (OSError, KeyError, RuntimeError, ValueError, TypeError) as error:  # what h5py raises for a truncated or altered file
        raise ResultFileError(f"result file '{path}' is damaged or cannot be read: {error}") from error


def _outcome(attributes: dict[str, object], file: Node) -> Outcome:
    name, reached, target = (attributes[key] for key in ("outcome", "reached", "target"))
    numbers = float(str(reached)), float(str(target))
    if name == "running":
        return Outcome(Cause.INTERRUPTED, *numbers, "the file was not closed: the run was killed or is still going on")
    events, start = read_events(file), read_start(attributes)
    return Outcome(Cause[str(name).upper()], *numbers, str(attributes["detail"]), events, start, read_critical_points(file))


def _statistics(group: Node) -> Statistics:
    statistics = Statistics()
    for name, empty in statistics.as_dict().items():
        if name in group:
            setattr(statistics, name, type(empty)(group[name][()]))
    for name in group:
        if name.startswith(STEPS_OF_ORDER):
            statistics.steps_of_order[int(name.removeprefix(STEPS_OF_ORDER))] = int(group[name][()])
    return statistics


def _signal(group: Node, name: str) -> Signal:
    dataset = group[name]
    labels = tuple(dataset.dims[1][0].asstr()[()]) if dataset.ndim == 2 else ()

    def refuse(state: State) -> NoReturn:
        raise ResultFileError(f"signal '{name}' was read from a file; accepted is history('{name}') or the model's own signal")

    return Signal(name, str(dataset.attrs["units"]), labels, refuse, str(dataset.attrs["long_name"]))


def _plain(value: object) -> object:
    """An attribute as text or number, however HDF5 stores it."""
    return value.decode() if isinstance(value, bytes) else value
