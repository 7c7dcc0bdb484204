"""One HDF5 file per run, written while it runs: recorded signals, frames of the motion, statistics, model and versions.

The layout is the one of netCDF-4 (dimension scales, ``units`` and ``long_name``), so that h5py, xarray, ncdump and ParaView's
spreadsheet read it without this package:

    /signals/<axis>            axis of the samples (time [s], load_factor, or path: number of the point), unlimited
    /signals/<signal>          (axis,) or (axis, component)
    /signals/component...      names of the components, one dataset for each set of names
    /frames/<axis>, q, v       coordinates and velocities of the kept frames, (axis, coordinate)
    /statistics/<count>        scalars
    /events/time, name, text   when which events happened, (event,)
    /critical_points/factor, at, kind, negative, shape, t, q, lam   where the stiffness became singular, (point, ...); in statics
    /final/a, lam, reaction, memory   of the last state beside its frame: accelerations, multipliers, forces of supports, and what
                               it remembers, as JSON in bytes; attributes time and factor
    /imperfection              (coordinate,), added to the stress-free geometry; only where there is one
    attributes of /            format_version, versions, created, title, axis, model, outcome, reached, target, detail,
                               start_displacement, start_turn, start_velocity, start_spin, start_where, start_left_out

The file is changed in short bursts that end with a flush, so a process killed at any other moment leaves a valid file whose
attribute ``outcome`` still says ``running``.
"""

from __future__ import annotations

import contextlib
import os
import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from lamella.arguments import PATH, accepts
from lamella.dofs import Signal
from lamella.errors import DeclarationError, ResultFileError
from lamella.io.result_layout import (
    Node,
    append,
    create_file,
    describe,
    lay_out_frames,
    lay_out_signals,
    plain,
    refuse_unfit,
    reserve,
    room_for,
    room_for_final,
    write_critical_points,
    write_events,
    write_final,
    write_outcome,
    write_start,
)
from lamella.io.stored_result import StoredResult, read_result
from lamella.result import Outcome, Result, Statistics
from lamella.roles import Floats
from lamella.state import State
from lamella.whole import replaced

__all__ = ["ResultWriter", "StoredResult", "frame_velocities", "model_text", "read_result", "write_result"]

_MARGIN = 1 << 18
"""Bytes reserved beyond the data, for HDF5's own tables and for the outcome and statistics at the end."""


class ResultWriter:
    """Writes a solution to an HDF5 file while it runs; a :class:`lamella.result.Sink`.

    Args:
        path: file to create.
        signals: what is sampled, in the order of the samples.
        axis: ``time``, ``load_factor`` or ``path`` (points of an equilibrium path).
        n_q: number of coordinates of a frame.
        model_text: the model file that describes the system, empty when there is none.
        model_missing: why there is none.
        title: one line for people.
        target: time [s] or load factor asked for.
        overwrite: replace an existing result file.
        flush_seconds: longest time between two flushes [s], which is what a killed run loses at most.
        imperfection: what is added to the stress-free geometry of the model, shape (n_q,).
        shown: what messages call the file, its path when left out.

    Raises:
        ResultFileError: the file exists, or cannot be created or written; none is left then.
    """

    def __init__(
        self,
        path: str | Path,
        signals: Sequence[Signal],
        axis: str,
        n_q: int,
        *,
        model_text: str = "",
        model_missing: str = "",
        title: str = "",
        target: float = float("nan"),
        overwrite: bool = False,
        flush_seconds: float = 2.0,
        imperfection: Floats | None = None,
        shown: str | Path | None = None,
    ) -> None:
        self.path = Path(path)
        self._shown = self.path if shown is None else shown
        self._signals, self._axis, self._n_q = tuple(signals), axis, n_q
        self._at: list[float] = []
        self._rows: list[Sequence[Floats]] = []
        self._frame_at: list[float] = []
        self._frame_q: list[Floats] = []
        self._frame_v: list[Floats] = []
        self._flush_seconds, self._flushed = flush_seconds, time.monotonic()
        self._frames = 0
        self._failed = self._damaged = False
        self._file = create_file(self.path, overwrite, self._shown)
        self._signal_rows: dict[str, Node] = {}
        self._frame_rows: dict[str, Node] = {}
        try:
            self._burst(lambda: self._lay_out((model_text, model_missing), title, target), _MARGIN + len(model_text))
            if imperfection is not None:
                self._burst(lambda: self._file.create_dataset("imperfection", data=imperfection), _MARGIN + imperfection.nbytes)
        except ResultFileError:  # without its layout it is no result file
            self.discard()
            raise

    def _lay_out(self, model: tuple[str, str], title: str, target: float) -> None:
        describe(self._file, self._axis, model=model, title=title, target=target)
        self._signal_rows = lay_out_signals(self._file, self._signals, self._axis)
        self._frame_rows = lay_out_frames(self._file, self._axis, self._n_q)
        self._file.create_group("statistics")
        self._file.create_group("events")

    def sample(self, at: float, values: Sequence[Floats]) -> None:
        """One sample of all signals."""
        assert len(values) == len(self._signals), f"{len(values)} values for {len(self._signals)} signals"
        self._at.append(at)
        self._rows.append(values)
        if time.monotonic() - self._flushed >= self._flush_seconds:
            self.flush()

    def frame(self, at: float, state: State) -> None:
        """One frame of all coordinates and velocities."""
        self._keep_frame(at, state.q, state.v)

    def _keep_frame(self, at: float, q: Floats, v: Floats) -> None:
        self._frames += 1
        self._frame_at.append(at)
        self._frame_q.append(np.array(q))
        self._frame_v.append(np.array(v))

    def flush(self) -> None:
        """Write what has come since the last flush; the file is valid and complete up to here afterwards.

        Raises:
            ResultFileError: there is no room for it; the file keeps what it had and can still be closed.
        """
        if not self._failed:
            size = room_for(self._signal_rows, len(self._at)) + room_for(self._frame_rows, len(self._frame_at))
            self._burst(self._write_pending, _MARGIN + size)

    def close(self, outcome: Outcome, statistics: Statistics) -> None:
        """Write what is pending, the outcome and the statistics, and close the file.

        After a failed write, which was reported when it happened, only the outcome and the statistics are written.
        """
        if not self._file:
            return
        try:
            self.flush()
        finally:
            with contextlib.ExitStack() as stack:
                stack.callback(self._close_file)
                if not self._damaged:
                    size = _MARGIN // 2 + sum(64 + len(event.name) + len(event.text) for event in outcome.events)
                    final = None if self._failed or not self._frames else outcome.final  # beside the last frame
                    size += 0 if final is None else room_for_final(final)
                    size += sum(512 + 8 * (2 * len(point.shape) + len(point.state.lam)) for point in outcome.critical_points)
                    self._burst(lambda: self._write_end(outcome, statistics, final), size)

    def discard(self) -> None:
        """Close and remove the file, for a run that ended before its first sample."""
        if self._file:
            self._close_file()
        self.path.unlink(missing_ok=True)

    def _burst(self, write: Callable[[], None], size: int) -> None:
        """Reserve ``size`` bytes at the end of the file, change the file and flush it.

        HDF5 does not survive a failed write, so the disk has to promise the room before HDF5 is asked to use it.
        """
        try:
            reserve(self.path, self._file.id.get_filesize(), size)
        except OSError as error:
            self._failed = True
            raise self._no_room(error) from error
        try:
            write()
            self._file.flush()
        except (OSError, RuntimeError) as error:  # h5py raises RuntimeError where HDF5 fails in its caches
            self._failed = self._damaged = True
            raise self._no_room(error) from error
        self._flushed = time.monotonic()

    def _no_room(self, error: Exception) -> ResultFileError:
        reached = f" beyond {self._axis} {self._at[0]:g}" if self._at else ""
        accepted = "free some space or choose another folder"
        return ResultFileError(f"result file '{self._shown}' cannot be written{reached}: {error}; {accepted}")

    def _close_file(self) -> None:
        """Close the file, whose content is flushed or already reported as lost, and give back the reserved room."""
        with contextlib.suppress(OSError, RuntimeError):
            size = self._file.id.get_filesize()
            self._file.close()
            if self.path.stat().st_size > size:
                os.truncate(self.path, size)

    def _write_pending(self) -> None:
        if self._at:
            for index, signal in enumerate(self._signals):
                if signal.name == self._axis:
                    continue
                column = np.asarray([row[index] for row in self._rows])
                append(self._signal_rows[signal.name], column if signal.labels else column.reshape(-1))
            append(self._signal_rows[self._axis], np.asarray(self._at))
            self._file.attrs["reached"] = self._at[-1]
        if self._frame_at:
            frames = self._frame_rows
            append(frames["q"], np.asarray(self._frame_q))
            append(frames["v"], np.asarray(self._frame_v))
            append(frames[self._axis], np.asarray(self._frame_at))
        for pending in (self._at, self._rows, self._frame_at, self._frame_q, self._frame_v):
            pending.clear()

    def _write_end(self, outcome: Outcome, statistics: Statistics, final: State | None) -> None:
        write_outcome(self._file, outcome.cause.name.lower(), outcome.reached, outcome.target, outcome.detail)
        write_start(self._file, outcome.start)
        write_events(self._file["events"], outcome.events)
        if outcome.critical_points:
            write_critical_points(self._file.create_group("critical_points"), outcome.critical_points)
        if final is not None:
            write_final(self._file.create_group("final"), final)
        group = self._file["statistics"]
        for name, value in statistics.as_dict().items():
            unit, label = ("s", name.removeprefix("seconds_") + " time") if name.startswith("seconds_") else ("1", name)
            group.create_dataset(name, data=value).attrs.update(plain({"units": unit, "long_name": label.replace("_", " ")}))


@accepts(path=PATH)
def write_result(result: Result, path: str | Path, *, title: str = "") -> Path:
    """Write a finished result to ``path``; an existing result file is replaced only when the new one is whole.

    Raises:
        ResultFileError: ``path`` is another kind of file, or cannot be written.
    """
    path = Path(path)
    refuse_unfit(path)
    signals, n_q = tuple(result.signals.values()), result.frame_q.shape[1] if result.frame_q.ndim == 2 else 0
    text, missing = model_text(result)
    with replaced(path, "result file") as partial:
        writer = ResultWriter(
            partial,
            signals,
            result.axis,
            n_q,
            model_text=text,
            model_missing=missing,
            title=title,
            overwrite=True,
            imperfection=result.imperfection,
            shown=path,
        )
        try:
            _write_all(writer, result)
        except ResultFileError:
            writer.discard()
            raise
    return path


def _write_all(writer: ResultWriter, result: Result) -> None:
    """Hand a finished result to its writer, and close it."""
    columns = [result.samples(name) for name in result.signals]
    for step, at in enumerate(result.at):
        writer.sample(float(at), [column[step] for column in columns])
    for at, q, v in zip(result.frame_at, result.frame_q, frame_velocities(result), strict=True):
        writer._keep_frame(float(at), q, v)
    final = result.final if len(result.frame_at) else None
    writer.close(replace(result.outcome, final=final), result.statistics)


def frame_velocities(result: Result) -> Floats:
    """Velocities of the frames, shape of ``frame_q``; NaN where a result does not keep them."""
    velocities = getattr(result, "frame_v", None)  # kept by result files; an optional extra of results in memory
    if velocities is None or np.shape(velocities) != result.frame_q.shape:
        return np.full(result.frame_q.shape, np.nan)
    return np.asarray(velocities)


def model_text(result: Result) -> tuple[str, str]:
    """The model file that describes the system of a result, empty when it cannot be written as one, and why it cannot."""
    stored = getattr(result, "model_text", None)  # results read from a file keep the text they were written with
    if stored is not None:
        return str(stored), str(getattr(result, "model_missing", ""))
    if result.model.description is None:
        return "", "the result is not that of a system"
    from lamella.io.writer import dumps  # the model file's schema is needed only here

    try:
        return dumps(result.model.description), ""
    except DeclarationError as error:  # forces written in Python and the like: the result is complete without its model file
        return "", str(error)
