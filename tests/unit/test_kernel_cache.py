"""Kernels from the cache: callers that are compiled later take them in as they do kernels just compiled."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

KERNELS = """
from lamella._jit import njit

@njit
def squared(x):
    return x * x

@njit
def sum_of_squares(x, y):
    return squared(x) + squared(y)
"""
FIRST = "import kernels; print(kernels.squared(3.0))"
SECOND = """
import kernels
print(kernels.squared(3.0), sum(kernels.squared.stats.cache_hits.values()))
print(kernels.sum_of_squares(3.0, 4.0), sum(kernels.sum_of_squares.stats.cache_hits.values()))
"""


def test_a_kernel_from_the_cache_is_called_by_one_compiled_later(tmp_path: Path) -> None:
    (tmp_path / "kernels.py").write_text(KERNELS)
    environment = {**os.environ, "XDG_CACHE_HOME": str(tmp_path)}

    def run(text: str) -> list[str]:
        found = subprocess.run([sys.executable, "-c", text], cwd=tmp_path, env=environment, capture_output=True, text=True)
        assert found.returncode == 0, found.stderr
        return found.stdout.split()

    assert run(FIRST) == ["9.0"]
    assert run(SECOND) == ["9.0", "1", "25.0", "0"]
    assert run(SECOND) == ["9.0", "1", "25.0", "1"]
