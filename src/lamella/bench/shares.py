"""Where the time of a run goes, as a profiler sees it."""

from __future__ import annotations

import cProfile
import pstats
from collections import defaultdict
from collections.abc import Callable, Iterator

from lamella.bench.row import Row

PARTS = {
    "factorisation": ("multifrontal.py", "factorise"),
    "solution": ("multifrontal.py", "solve"),
    "element tangents": ("kernels.py", "force_tangent"),
    "element forces": ("kernels.py", "force"),
    "sums and mass": ("operator.py", "onto"),
    "recording": ("result.py", "sample"),
}
"""Name of a part to file and function that does it."""


def shares(case: str, code: str, call: Callable[[], object]) -> Iterator[Row]:
    """Parts of the time of a call, with what they call, in per cent; what is left is Python between them."""
    profile = cProfile.Profile()
    profile.runcall(call)
    stats = pstats.Stats(profile)
    times: defaultdict[tuple[str, str], float] = defaultdict(float)
    for (path, _, name), row in stats.stats.items():  # pyright: ignore
        times[path.replace("\\", "/").rsplit("/", 1)[-1], name] += row[3]
    for part, key in PARTS.items():
        if key in times:
            percent = 100.0 * times[key] / stats.total_tt  # pyright: ignore
            yield Row(case=case, code=code, what=part, time=percent, unit="% of the run")
