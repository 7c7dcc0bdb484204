"""The table of a study: a row for each run, in the order of the design."""

from __future__ import annotations

import importlib.util
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from lamella.errors import DeclarationError
from lamella.roles import Floats
from lamella.study.outputs import write_rows
from lamella.sweep.parameter import columns_of, label_of
from lamella.sweep.study import ParameterStudy
from lamella.sweep.task import Row
from lamella.whole import replaced


@dataclass(frozen=True)
class StudyResult:
    """What a study gave.

    ``result["deflection"]`` is an output or a parameter over all runs, in the order of the design; NaN where a run failed.

    Args:
        study: what was asked for.
        units: of the outputs, by name.
        rows: of the runs, in the order of the design.
        files: what was written.
    """

    study: ParameterStudy
    units: Mapping[str, str]
    rows: Sequence[Row]
    files: Sequence[Path] = ()

    @cached_property
    def parameters(self) -> dict[str, tuple[str, list[float] | list[str]]]:
        """Unit and values of each parameter; text where they are not numbers with one unit."""
        return columns_of(self.study.rows(), list(self.study.parameters))

    @property
    def failures(self) -> list[Row]:
        """The runs that gave nothing."""
        return [row for row in self.rows if row.status != "ok"]

    @property
    def ok(self) -> np.ndarray:
        """Whether each run gave its outputs."""
        return np.array([row.status == "ok" for row in self.rows])

    def __getitem__(self, name: str) -> Floats:
        if name in self.units:
            return np.array([row.values.get(name, np.nan) for row in self.rows])
        if name in self.parameters:
            return np.asarray(self.parameters[name][1])
        known = ", ".join((*self.parameters, *self.units))
        raise DeclarationError("study", f"no output or parameter '{name}'", f"there are {known}")

    def label(self, name: str) -> str:
        """A name with its unit in brackets, where it has one."""
        unit = self.units[name] if name in self.units else self.parameters[name][0]
        return label_of(name, unit)

    def columns(self) -> dict[str, list[object]]:
        """The table, column by column."""
        table: dict[str, list[object]] = {"run": [row.number for row in self.rows]}
        table |= {self.label(name): [*values] for name, (_, values) in self.parameters.items()}
        table |= {self.label(name): [row.values.get(name) for row in self.rows] for name in self.units}
        table["status"], table["message"] = [row.status for row in self.rows], [row.message for row in self.rows]
        return table


def write_tables(columns: Mapping[str, Sequence[object]], folder: Path, name: str) -> list[Path]:
    """Write columns as ``name.csv``, and as ``name.parquet`` where pyarrow is installed.

    Raises:
        ResultFileError: one cannot be written.
    """
    files = [write_rows(folder / f"{name}.csv", list(columns), zip(*columns.values(), strict=True))]
    if importlib.util.find_spec("pyarrow") is not None:
        import pyarrow
        import pyarrow.parquet

        path = folder / f"{name}.parquet"
        table = pyarrow.Table.from_arrays([arrow(values) for values in columns.values()], names=list(columns))
        with replaced(path) as partial:
            pyarrow.parquet.write_table(table, partial)
        files.append(path)
    return files


def arrow(values: Sequence[object]) -> Any:
    """An array of Arrow with text, whole numbers or numbers, and null for None.

    It is put together from its buffers, since ``pyarrow.array`` imports pandas where that is installed, 0.25 s.
    """
    import pyarrow

    present = [value is not None for value in values]
    data: list[Any]
    if any(isinstance(value, str) for value in values):
        texts = [str(value).encode() if there else b"" for value, there in zip(values, present, strict=True)]
        kind, data = pyarrow.string(), [np.cumsum([0, *map(len, texts)], dtype=np.int32), b"".join(texts)]
    else:
        whole = all(isinstance(value, (int, np.integer)) for value in values)
        numbers: Any = [value if there else np.nan for value, there in zip(values, present, strict=True)]
        kind = pyarrow.int64() if whole else pyarrow.float64()
        data = [np.array(numbers, np.int64 if whole else np.float64)]
    valid = np.packbits(np.array(present, bool), bitorder="little")
    return pyarrow.Array.from_buffers(kind, len(values), [pyarrow.py_buffer(part) for part in (valid, *data)])
