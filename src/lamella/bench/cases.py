"""The benchmarks by name."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

from lamella.bench import array, contact, kernels, linear, motion, parameter_study, static
from lamella.bench.row import Row
from lamella.errors import ModelError, no_such


@dataclass(frozen=True)
class Case:
    """A benchmark: what ``--list`` shows, and what measures so many times and gives the rows of the table."""

    title: str
    run: Callable[[int], Iterator[Row]]


CASES = {
    "p1-static": Case("composite cantilever in equilibrium to 0.2 %, beside Exudyn, CalculiX and Kratos", static.run),
    "p1-motion": Case("composite cantilever under a sudden force, beside Exudyn and Kratos", motion.p1),
    "p2-motion": Case("plate pinned at its corners under a sudden force, beside Exudyn", motion.p2),
    "array-motion": Case("unfolding solar array, flexible and rigid", array.run),
    "kernels": Case("element kernels", kernels.run),
    "contact": Case("contact of a belt with three rollers", contact.run),
    "study": Case("a parameter study on two processes", parameter_study.run),
    "linear": Case("linear solvers on matrices like those of plates", linear.run),
}


def find_cases(names: Sequence[str]) -> dict[str, Case]:
    """The benchmarks called ``names``, ``_`` and ``-`` alike, or all of them.

    Raises:
        ModelError: a name that is none.
    """
    chosen = [name.replace("_", "-") for name in names]
    for name in chosen:
        if name not in CASES:
            raise ModelError(no_such("benchmark", name, CASES))
    return {name: CASES[name] for name in chosen} if chosen else dict(CASES)
