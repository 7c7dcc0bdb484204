"""Designs: at which values of its parameters a model is run."""

from __future__ import annotations

import itertools
import math
from abc import ABC, abstractmethod
from collections.abc import Mapping
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import Field

from lamella.declaration import declaration
from lamella.roles import Floats
from lamella.sweep.parameter import Parameter, check_value

MOST_RUNS = 100_000
"""Largest number of runs in a study: more are a slip of the pen."""

Runs = Annotated[int, Field(ge=2)]
Seed = Annotated[int, Field(ge=0)]
Row = dict[str, Any]
Parameters = Mapping[str, Parameter]


class Design(ABC):
    """A rule that says at which values the parameters are taken.

    1. It is frozen data, and the same data give the same runs in the same order.
    2. ``runs_of`` is found without making the runs.
    3. ``rows`` gives every parameter a value in every run.
    """

    @abstractmethod
    def runs_of(self, parameters: Parameters) -> int:
        """Number of runs."""

    @abstractmethod
    def rows(self, parameters: Parameters) -> list[Row]:
        """The value of each parameter, run by run.

        Raises:
            ValueError: a parameter does not say what this design needs; the message begins with its name.
        """


@declaration
class GridDesign(Design):
    """All combinations of the parameters' values; the last parameter varies fastest."""

    kind: Literal["grid"] = "grid"

    def runs_of(self, parameters: Parameters) -> int:
        return math.prod(_of(name, parameter.grid_size) for name, parameter in parameters.items())

    def rows(self, parameters: Parameters) -> list[Row]:
        return [dict(zip(parameters, point, strict=True)) for point in itertools.product(*_grids(parameters))]


@declaration
class ListDesign(Design):
    """Runs written out one by one.

    Args:
        runs: the value of each parameter, a mapping for each run.
    """

    runs: tuple[dict[str, Any], ...]
    kind: Literal["list"] = "list"

    def runs_of(self, parameters: Parameters) -> int:
        return len(self.runs)

    def rows(self, parameters: Parameters) -> list[Row]:
        for name, parameter in parameters.items():
            if parameter.values is not None or parameter.range is not None:
                raise ValueError(f"{name}: a list of runs gives the values; accepted is 'path' alone")
        for number, row in enumerate(self.runs):
            if set(row) != set(parameters):
                given, wanted = ", ".join(row) or "none", ", ".join(parameters)
                raise ValueError(f"runs[{number}] gives {given}; accepted is a value for each of {wanted}")
            for name, value in row.items():
                check_value(value, f"runs[{number}]: {name}")
        return [{name: row[name] for name in parameters} for row in self.runs]


@declaration
class LatinHypercubeDesign(Design):
    """Random values over the ranges, each range cut into as many equal parts as there are runs, with one value in each.

    Source: McKay, Beckman and Conover (1979), by SciPy's ``qmc.LatinHypercube``.

    Args:
        runs: number of runs.
        seed: of the random numbers; the same seed gives the same values.
    """

    runs: Runs
    seed: Seed
    kind: Literal["latin_hypercube"] = "latin_hypercube"

    def runs_of(self, parameters: Parameters) -> int:
        return self.runs

    def rows(self, parameters: Parameters) -> list[Row]:
        from scipy.stats import qmc  # a third of a second that grids and lists do without

        random = np.random.default_rng(self.seed)
        sampler = qmc.LatinHypercube(len(parameters), seed=random)  # pyright: ignore[reportCallIssue] -- rng from SciPy 1.15 on
        return _sampled(parameters, sampler.random(self.runs))


@declaration
class SobolDesign(Design):
    """Sobol's sequence over the ranges, scrambled: fills them more evenly than random values do.

    Source: Sobol (1967), Owen (1998), by SciPy's ``qmc.Sobol``.

    Args:
        runs: number of runs, a power of two; with others the sequence loses its balance.
        seed: of the scrambling.
    """

    runs: Runs
    seed: Seed
    kind: Literal["sobol"] = "sobol"

    def __post_init__(self) -> None:
        """Refuse numbers that are no power of two."""
        _check_power("runs", self.runs)

    def runs_of(self, parameters: Parameters) -> int:
        return self.runs

    def rows(self, parameters: Parameters) -> list[Row]:
        return _sampled(parameters, _sobol(len(parameters), self.runs, self.seed))


@declaration
class SaltelliDesign(Design):
    """Values from which Sobol's indices of sensitivity are found: ``base`` (d + 2) runs with d parameters.

    Two independent samples A and B of ``base`` points, and for each parameter A with that column from B, by which the variance of
    an output is shared among the parameters. Source: Saltelli et al. (2010), doi 10.1016/j.cpc.2009.09.018.

    Args:
        base: number of points in A and in B, a power of two.
        seed: of the random numbers.
    """

    base: Runs
    seed: Seed
    kind: Literal["saltelli"] = "saltelli"

    def __post_init__(self) -> None:
        """Refuse numbers that are no power of two."""
        _check_power("base", self.base)

    def runs_of(self, parameters: Parameters) -> int:
        return self.base * (len(parameters) + 2)

    def rows(self, parameters: Parameters) -> list[Row]:
        count = len(parameters)
        both = _sobol(2 * count, self.base, self.seed)
        A, B = both[:, :count], both[:, count:]
        mixed = [np.where(np.arange(count) == index, B, A) for index in range(count)]
        return _sampled(parameters, np.vstack([A, B, *mixed]))


def design_rows(design: Design, parameters: Parameters) -> list[Row]:
    """The runs of a design.

    Raises:
        ValueError: there is no run, there are too many, or a parameter does not say what the design needs.
    """
    number = design.runs_of(parameters)
    if number < 1 or not parameters:
        raise ValueError("the design is empty; accepted is at least one parameter and one run")
    if number > MOST_RUNS:
        raise ValueError(f"the design has {number} runs; accepted are at most {MOST_RUNS}")
    return design.rows(parameters)


def _grids(parameters: Parameters) -> list[list[Any]]:
    return [list(_of(name, parameter.grid)) for name, parameter in parameters.items()]


def _sampled(parameters: Parameters, shares: Floats) -> list[Row]:
    for name, parameter in parameters.items():
        if parameter.range is None or parameter.count is not None:
            raise ValueError(f"{name}: this design draws values from a range; accepted is 'range' without 'values' and 'count'")
    columns = [parameter.at(shares[:, index]) for index, parameter in enumerate(parameters.values())]
    return [dict(zip(parameters, values, strict=True)) for values in zip(*columns, strict=True)]


def _of(name: str, values: Any) -> Any:
    """What ``values`` returns, its errors naming the parameter."""
    try:
        return values()
    except ValueError as error:
        raise ValueError(f"{name}: {error}") from error


def _sobol(dimensions: int, runs: int, seed: int) -> Floats:
    from scipy.stats import qmc

    sampler = qmc.Sobol(dimensions, seed=np.random.default_rng(seed))  # pyright: ignore[reportCallIssue] -- rng from SciPy 1.15 on
    return np.asarray(sampler.random(runs))


def _check_power(name: str, number: int) -> None:
    if number & (number - 1):
        near = 1 << (number.bit_length() - 1)
        raise ValueError(f"{name} = {number}; accepted is a power of two, such as {near} or {2 * near}")
