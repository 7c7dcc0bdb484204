"""Times of lamella's parts, of a set-up and of a motion, to be compared with those of earlier versions: ``make history``."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import pytest

import lamella as lm
from lamella.bench import contact, kernels, linear
from lamella.solve.linear import linear_solver
from lamella.verification.p1_motion.case import cantilever


def measure(benchmark: Any, call: Callable[[], object]) -> None:
    """Time a call that has been made before, so that nothing is compiled meanwhile."""
    call()
    benchmark(call)


@pytest.mark.parametrize("what", ["energy", "force", "force + tangent", "viscous force + tangent"])
@pytest.mark.parametrize("element", ["plate48", "plate36"])
def test_element_kernels(benchmark: Any, element: str, what: str) -> None:
    """40 elements with 4 x 4 points."""
    measure(benchmark, kernels.calls(element)[what])


@pytest.mark.parametrize("what", ["force", "force + tangent"])
def test_contact(benchmark: Any, what: str) -> None:
    """A belt of 40 elements and three rollers."""
    measure(benchmark, contact.calls()[0][what])


@pytest.mark.parametrize("what", ["factorise", "solve"])
@pytest.mark.parametrize("nodes", [(7, 7), (2, 41), (25, 25)])
def test_linear_solver(benchmark: Any, nodes: tuple[int, int], what: str) -> None:
    """Matrices like those of plates, by the solver that is chosen for them."""
    pattern, k = linear.plate_like(*nodes)
    measure(benchmark, linear.calls(linear_solver(pattern), k)[what])


def test_equilibrium(benchmark: Any) -> None:
    """From the description of a plate of 10 x 10 elements to its equilibrium."""
    result = benchmark.pedantic(lambda: lm.equilibrium(cantilever(10)), rounds=20, warmup_rounds=2)
    benchmark.extra_info["iterations"] = result.statistics.newton_iterations
    assert result["C.position"][2] == pytest.approx(-0.1116, rel=1e-3)


def test_motion(benchmark: Any) -> None:
    """100 steps of a plate of 6 x 6 elements under a sudden force, with its set-up."""
    result = benchmark.pedantic(lambda: lm.simulate(cantilever(6), 0.1, lm.GeneralizedAlpha(dt=1e-3)), rounds=10, warmup_rounds=1)
    benchmark.extra_info["iterations"] = result.statistics.newton_iterations
    benchmark.extra_info["factorisations"] = result.statistics.factorisations
    assert result.statistics.steps == 100
