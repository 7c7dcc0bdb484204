"""Kernels from the cache: callers that are compiled later take them in as they do kernels just compiled."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import lamella

KERNELS = """
from lamella._jit import njit

@njit
def squared(x):
    return x * x

@njit
def sum_of_squares(x, y):
    return squared(x) + squared(y)

@njit
def shifted(x):
    parts = [x[i:i + 2] + 1.0 for i in range(2)]
    return parts[0] + parts[1]
"""
FIRST = "import kernels; print(kernels.squared(3.0))"
ARRAYS = """
import kernels, numpy
from numba.core.runtime import rtsys
print(*kernels.shifted(numpy.arange(3.0)), sum(kernels.shifted.stats.cache_hits.values()), rtsys._init)
"""
SECOND = """
import kernels
print(kernels.squared(3.0), sum(kernels.squared.stats.cache_hits.values()))
print(kernels.sum_of_squares(3.0, 4.0), sum(kernels.sum_of_squares.stats.cache_hits.values()))
"""


def run(folder: Path, text: str) -> list[str]:
    """What a process prints that finds the kernels and their cache in a folder."""
    (folder / "kernels.py").write_text(KERNELS)
    os.utime(folder / "kernels.py", (0, 0))  # the cache of a file that is written again would be that of another one
    environment = {**os.environ, "XDG_CACHE_HOME": str(folder), "PYTHONPATH": str(Path(lamella.__file__).parents[1])}
    found = subprocess.run([sys.executable, "-c", text], cwd=folder, env=environment, capture_output=True, text=True)
    assert found.returncode == 0, found.stderr
    return found.stdout.split()


def test_a_kernel_from_the_cache_is_called_by_one_compiled_later(tmp_path: Path) -> None:
    assert run(tmp_path, FIRST) == ["9.0"]
    assert run(tmp_path, SECOND) == ["9.0", "1", "25.0", "0"]
    assert run(tmp_path, SECOND) == ["9.0", "1", "25.0", "1"]


def test_the_cache_needs_no_folder_for_temporary_files(tmp_path: Path) -> None:
    """Where ``/tmp`` is full or cannot be written, Python raises FileNotFoundError."""
    without = "import tempfile; tempfile._get_default_tempdir = lambda *_: open('/none/such'); "
    assert run(tmp_path, without + FIRST) == ["9.0"]


def test_a_kernel_from_the_cache_makes_and_releases_arrays(tmp_path: Path) -> None:
    assert run(tmp_path, ARRAYS) == ["3.0", "5.0", "0", "True"]
    assert run(tmp_path, ARRAYS) == ["3.0", "5.0", "1", "False"]  # Numba has compiled nothing, not even its own functions
