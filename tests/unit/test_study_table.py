"""Columns of a study's table as Arrow has them."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

import pytest

from lamella.sweep.table import arrow

pyarrow = pytest.importorskip("pyarrow")


@pytest.mark.parametrize(
    ("values", "kind"),
    [
        ([1, 2, 3], "int64"),
        ([0.1, None, -1e300, 5e-324, 2], "double"),
        ([*range(20), None, 0.5], "double"),
        (["ok", "", None, "Übermaß, \n 中"], "string"),
        ([None, None], "double"),
        ([], "int64"),
    ],
)
def test_arrays_of_arrow_hold_the_values(values: Sequence[object], kind: str) -> None:
    array = arrow(values)
    array.validate(full=True)
    assert str(array.type) == kind
    assert array.to_pylist() == list(values)
    assert array.null_count == sum(value is None for value in values)


def test_tables_do_without_pandas(tmp_path: Path) -> None:
    code = """
import sys
from pathlib import Path
from lamella.sweep.table import write_tables
write_tables({"run": [1, 2], "z [m]": [0.5, None], "status": ["ok", "failed"]}, Path(sys.argv[1]), "table")
assert "pyarrow.parquet" in sys.modules
assert not {"pandas", "scipy.stats"} & set(sys.modules)
"""

    subprocess.run([sys.executable, "-c", code, str(tmp_path)], check=True)
