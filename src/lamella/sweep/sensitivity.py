"""How much each parameter of a study matters for each output."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from lamella.roles import Floats
from lamella.sweep.designs import LatinHypercubeDesign, SaltelliDesign, SobolDesign
from lamella.sweep.table import StudyResult

CONFIDENCE = 0.95
RESAMPLES = 999
FEWEST = 4
"""Runs or points below which nothing is said."""


@dataclass(frozen=True)
class Sensitivity:
    """A measure of one parameter's effect on one output.

    Args:
        output: name of the output.
        parameter: name of the parameter.
        measure: ``first order`` and ``total`` index of Sobol, or ``rank correlation`` of Spearman.
        value: of the measure; an index is a share of the output's variance, a correlation lies between -1 and 1.
        low, high: ends of its interval of 95 % confidence.
    """

    output: str
    parameter: str
    measure: str
    value: float
    low: float
    high: float


def sensitivities(result: StudyResult) -> list[Sensitivity]:
    """All measures that the design allows; none for grids and lists.

    Failed runs are left out; of a Saltelli design all runs that share a point of the base sample with one, which leaves an
    unbiased sample only if what fails does not depend on the parameters.
    """
    design = result.study.design
    if isinstance(design, SaltelliDesign):
        return [item for name in result.units for item in _sobol(result, name, design.base)]
    if isinstance(design, (LatinHypercubeDesign, SobolDesign)):
        return [item for name in result.units for item in _rank(result, name)]
    return []


def points_used(result: StudyResult) -> int:
    """Runs that the measures are of; of a Saltelli design, points of the base sample."""
    design = result.study.design
    return int(_whole(result, design.base).sum() if isinstance(design, SaltelliDesign) else result.ok.sum())


def _whole(result: StudyResult, base: int) -> np.ndarray:
    """Points of the base sample all of whose runs are ok, shape (base,)."""
    return np.asarray(result.ok.reshape(-1, base).all(axis=0))


def sobol_indices(f_A: Floats, f_B: Floats, f_AB: Floats) -> tuple[Floats, Floats]:
    """First-order and total indices of Sobol, each of shape (d,).

    ::

        S_i = mean f_B (f_AB_i - f_A) / var f,    S_Ti = mean (f_A - f_AB_i)^2 / (2 var f)

    as ``scipy.stats.sobol_indices`` has them, which takes no other number of points than powers of two: failed runs leave others.

    Args:
        f_A, f_B: values at the points of A and of B, shape (n,).
        f_AB: values at A with column i from B, shape (d, n).

    Source: Saltelli et al. (2010), table 2 b and f, doi 10.1016/j.cpc.2009.09.018.
    """
    both = np.concatenate([f_A, f_B])
    mean, variance = both.mean(), both.var()
    first = np.mean((f_B - mean) * (f_AB - f_A), axis=1)  # the mean is taken off for the least scatter
    total = 0.5 * np.mean((f_A - f_AB) ** 2, axis=1)
    return first / variance, total / variance


def _sobol(result: StudyResult, output: str, base: int) -> list[Sensitivity]:
    """First-order and total indices with bootstrap intervals over the points of the base sample."""
    values = result[output].reshape(-1, base)[:, _whole(result, base)]
    count = values.shape[1]
    if count < FEWEST or np.ptp(values[:2]) == 0.0:
        return []

    def indices(chosen: Floats) -> Floats:
        return np.array(sobol_indices(chosen[0], chosen[1], chosen[2:]))

    random = np.random.default_rng(0)
    found = indices(values)
    again = np.array([indices(values[:, random.integers(count, size=count)]) for _ in range(RESAMPLES)])
    low, high = np.quantile(again, [0.5 - 0.5 * CONFIDENCE, 0.5 + 0.5 * CONFIDENCE], axis=0)
    return [
        Sensitivity(output, parameter, measure, *(float(table[kind, index]) for table in (found, low, high)))
        for index, parameter in enumerate(result.study.parameters)
        for kind, measure in enumerate(("first order", "total"))
    ]


def _rank(result: StudyResult, output: str) -> list[Sensitivity]:
    """Spearman's rank correlation, with intervals by Fisher's transformation (Bonett and Wright 2000)."""
    ok = result.ok
    count = int(ok.sum())
    if count < FEWEST or np.ptp(result[output][ok]) == 0.0:
        return []
    from scipy import stats  # takes a third of a second, and most designs have no sensitivities

    rows = []
    for parameter in result.study.parameters:
        value = float(stats.spearmanr(result[parameter][ok], result[output][ok])[0])  # pyright: ignore[reportArgumentType]
        half = stats.norm.ppf(0.5 + 0.5 * CONFIDENCE) * np.sqrt((1.0 + 0.5 * value**2) / (count - 3))
        centre = np.arctanh(np.clip(value, -1.0 + 1e-12, 1.0 - 1e-12))
        rows.append(
            Sensitivity(
                output, parameter, "rank correlation", value, float(np.tanh(centre - half)), float(np.tanh(centre + half))
            )
        )
    return rows
