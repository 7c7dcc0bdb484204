"""The benchmarks by name."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

from lamella.bench import array, contact, gradients, in_threads, kernels, linear, motion, parameter_study, scale, static, work
from lamella.bench.picture import Picture
from lamella.bench.row import Row
from lamella.errors import ModelError, no_such


@dataclass(frozen=True)
class Case:
    """A benchmark: what ``--list`` shows, what measures so many times and gives the table, and its picture of errors."""

    title: str
    run: Callable[[int], Iterator[Row]]
    picture: Picture | None = None


STATIC = Picture("Cantilever plate in equilibrium: error over work", "elements along a side", static.GOAL)
MOTION = Picture("Cantilever plate under a sudden force, 0.2 s: error over work", "steps")
SETTLING = Picture("Cantilever plate until it rests, 6 s: error over work", "steps")
CASES = {
    "p1-static": Case("composite cantilever in equilibrium to 0.2 %, beside Exudyn, CalculiX and Kratos", static.run, STATIC),
    "p1-motion": Case("composite cantilever under a sudden force, beside Exudyn and Kratos", motion.p1),
    "p2-motion": Case("plate pinned at its corners under a sudden force, beside Exudyn", motion.p2),
    "array-motion": Case("unfolding solar array, flexible and rigid", array.run),
    "p1-motion-work": Case("the first 0.2 s of p1-motion, fixed steps and step control", work.p1, MOTION),
    "settling-work": Case("the cantilever until it rests, fixed steps and step control", work.settling, SETTLING),
    "kernels": Case("element kernels", kernels.run),
    "contact": Case("contact of a belt with three rollers", contact.run),
    "study": Case("a parameter study on two processes", parameter_study.run),
    "gradients": Case("derivatives by one parameter and by several, beside what they are of", gradients.run),
    "scale": Case("cost over size: a plate and a belt of up to 50 000 coordinates", scale.run),
    "threads": Case("one thread and two: parts of a step on 1600 elements, and steps of small and large plates", in_threads.run),
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
