"""Threads: the same bits for any number of them, none where a model is small, and what a wrong number says."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from functools import partial

import numpy as np
import pytest
from test_linear import pattern_of, plate_like

import lamella as lm
from lamella import threads
from lamella.assembly.equations import Equations
from lamella.bench.gradients import Work
from lamella.differentiation.neighbours import neighbours_of
from lamella.element.block import Range
from lamella.element.plate48.layout import seen
from lamella.errors import ModelError
from lamella.lane import WIDTH, aligned
from lamella.result import Result
from lamella.solve.layout import layout_of
from lamella.solve.multifrontal import Multifrontal
from lamella.solve.schedule import Schedule, row_ranges
from lamella.sweep.processes import ONE_THREAD
from lamella.verification.p1_motion.case import cantilever

MOTION = lm.GeneralizedAlpha(dt=2e-3, rho_inf=0.9)
SHEET = lm.Laminate(lm.Isotropic(E=70e9, nu=0.3, rho=2700.0, alpha=2e-5, k=200.0, c=900.0), thickness=2e-3)


@pytest.fixture(autouse=True)
def number_is_restored() -> Iterator[None]:
    yield
    threads.use(None)


def damped(element: str) -> lm.System:
    system = lm.System()
    plate = system.add(lm.Plate("plate", (1.0, 0.6), (7, 5), SHEET, element=element, damping=1e-4))
    system.add(lm.Clamp("root", plate.edge("x-")))
    system.add(lm.PointForce("pull", plate.marker("tip", 1.0, 0.6), (0, 0, 8.0)))
    return system


def heated() -> lm.System:
    system = lm.System()
    plate = system.add(lm.Plate("plate", (0.5, 0.2), (8, 4), SHEET))
    system.add(lm.Clamp("root", plate.edge("x-")))
    system.add(lm.TemperatureField("field", plate, reference=290.0))
    system.add(lm.HeatFlux("lamp", plate, side="top", flux=800.0))
    return system


def moved(system: lm.System, integrator: lm.GeneralizedAlpha = MOTION) -> Result:
    return lm.simulate(system, 3 * integrator.dt, integrator)


COMPUTED = {
    "static": lambda: lm.equilibrium(cantilever(8)),
    "motion": lambda: moved(cantilever(8)),
    "in-plane points apart": lambda: moved(_reduced()),
    "damped": lambda: moved(damped("plate48")),
    "damped plate36": lambda: moved(damped("plate36")),
    "heat": lambda: moved(heated(), lm.GeneralizedAlpha(dt=0.1, rho_inf=0.5)),
}


def _reduced() -> lm.System:
    system = lm.System()
    plate = system.add(lm.Plate("plate", (1.0, 0.6), (7, 5), SHEET, n_gauss=4, membrane_gauss=3))
    system.add(lm.Clamp("root", plate.edge("x-")))
    system.add(lm.PointForce("pull", plate.marker("tip", 1.0, 0.6), (0, 0, 8.0)))
    return system


@pytest.mark.usefixtures("always_cut")
@pytest.mark.parametrize("what", COMPUTED)
def test_results_are_the_same_to_the_last_bit(what: str, monkeypatch: pytest.MonkeyPatch) -> None:
    found, cut, run = [], [0], threads.run

    def counted(calls, **how):
        cut[0] += len(calls) > 1
        return run(calls, **how)

    monkeypatch.setattr(threads, "run", counted)
    for count in (1, 2, 3):
        threads.use(count)
        cut[0] = 0
        state = COMPUTED[what]().final
        assert count == 1 or cut[0] > 10
        found.append((state.q, state.v, state.a, state.lam))
    for other in found[1:]:
        for one, same in zip(found[0], other, strict=True):
            np.testing.assert_array_equal(one, same)


@pytest.mark.usefixtures("always_cut")
@pytest.mark.parametrize("shape", [(12, 12), (30, 3), (2, 2)])
def test_factorisation_by_subtrees(shape: tuple[int, int]) -> None:
    """Factor and solution are those of one thread; an indefinite matrix has its signs, a singular one its free coordinate."""
    k = plate_like(*shape)
    for index in (5, 20):
        k[index, index] *= -1.0
    pattern, values, _ = pattern_of(k)
    singular = values.copy()
    singular[(pattern.rows == 14) | (pattern.indices == 14)] = 0.0
    right, found = np.sin(np.arange(len(k))), []
    for count in (1, 2, 4):
        threads.use(count)
        factor = Multifrontal(pattern)
        assert (len(factor._plan.subtrees) > 1) == (count > 1 and shape != (2, 2))
        done = factor.factorise(values), factor.negative_pivots, factor.solve(right), factor.solve(np.stack([right, -right], 1))
        found.append((*done, factor.factorise(singular)))
    assert found[0][0] == -1
    assert found[0][1] == np.count_nonzero(np.linalg.eigvalsh(k) < 0)
    assert found[0][4] == 14
    for other in found[1:]:
        for one, same in zip(found[0], other, strict=True):
            np.testing.assert_array_equal(one, same)


@pytest.mark.usefixtures("always_cut")
def test_subtrees_hold_all_children_and_share_no_updates() -> None:
    layout = layout_of(pattern_of(plate_like(12, 12))[0])
    plan = Schedule(layout, 2)
    inside = [set(range(*subtree)) for subtree in plan.subtrees]
    assert len(inside) > 1
    assert sorted([*(f for one in inside for f in one), *plan.above]) == list(range(len(layout.fronts) - 1))
    used: list[set[int]] = []
    for one in inside:
        used.append(set())
        for f in one:
            child = layout.fronts[f, 9]
            while child >= 0:
                assert child in one
                child = layout.fronts[child, 10]
            start, size = plan.fronts[f, 6], plan.fronts[f, 5] ** 2
            used[-1] |= set(range(start, start + size, 16))
    assert sum(map(len, used)) == len(set().union(*used))
    last = plan.fronts[:-1, 6] + plan.fronts[:-1, 5] ** 2
    assert last.max() <= plan.update_size


@pytest.mark.usefixtures("always_cut")
@pytest.mark.parametrize(("rows", "columns"), [(8, 8), (320, 320), (304, 40), (200, 4), (64, 0), (0, 0)])
def test_row_ranges_cover_a_triangle_once(rows: int, columns: int) -> None:
    threads.use(3)
    ranges = sorted(row_ranges(rows, columns, 96))
    assert [row for ends in ranges for row in range(*ends)] == (list(range(rows)) if columns else [])


@pytest.mark.usefixtures("always_cut")
@pytest.mark.parametrize("damping", [0.0, 1e-3])
def test_threads_change_no_bit_of_what_forces_change_by(damping: float) -> None:
    """A stiffness goes through the block's own kernel with other tables, a length through one of its own."""
    work = Work("plate", 3, (7, 5), damping)
    base = Equations(work.plate().compile())
    point = base.start()
    point.u += 1e-3 * base.magnitude * np.sin(np.arange(base.n_u))
    point.ud = base.magnitude * np.cos(np.arange(base.n_u))
    for name in ("E1", "length"):
        value = work.values[name]
        beside = neighbours_of(name, base, value, value, lambda x, name=name: work.plate(**{name: x}))
        found = []
        for count in (1, 2, 3):
            threads.use(count)
            found.append(beside.residual(point, point.ud, point.udd)[0])
        assert np.abs(found[0]).max() > 0.0
        for other in found[1:]:
            np.testing.assert_array_equal(other, found[0])


def test_tables_that_are_gone_leave_nothing_to_others() -> None:
    """What a range keeps of tables is theirs alone, also where others come to stand at the place of some that are gone."""
    blocks = Range(0, 1, 2)
    for number in range(50):
        table = aligned(2 * 48 * WIDTH)
        table[:] = number
        arguments = (np.zeros(2 * 48 * WIDTH, np.int64), table, table, table, 4, None)
        assert seen(arguments, blocks)[1][0] == number
        del table, arguments


def test_small_models_are_left_to_one_thread(monkeypatch: pytest.MonkeyPatch) -> None:
    def refused(*_):
        raise AssertionError("a thread was started")

    monkeypatch.setattr(threads, "Helpers", refused)
    threads.use(2)
    moved(cantilever(6))


def test_large_models_are_not() -> None:
    threads.use(2)
    equations = Equations(cantilever(24).compile())
    assert len(equations.matrix._bounds) > 2
    assert len(Multifrontal(equations.matrix.pattern)._plan.subtrees) > 1
    lm.equilibrium(equations)
    assert threads._helpers is not None


def test_calls_are_shared_and_their_results_in_order() -> None:
    threads.use(2)
    names: dict[int, str] = {}
    met = threading.Barrier(2, timeout=20.0)  # two calls wait for each other: they run at the same time

    def call(i: int) -> int:
        names[i] = threading.current_thread().name
        if i < 2:
            met.wait()
        return i * i

    assert threads.run([partial(call, i) for i in range(6)]) == [0, 1, 4, 9, 16, 25]
    own = threading.current_thread().name
    assert own in (names[0], names[1])
    assert any(names[i].startswith("lamella") for i in (0, 1))


def test_a_thread_that_is_late_is_not_waited_for() -> None:
    """The thread's only other work holds it up until all calls are made: the caller makes them itself."""
    threads.use(2)
    threads.run([lambda: None, lambda: None])
    assert threads._helpers is not None
    begun, over = threading.Event(), threading.Event()
    threads._helpers.hand(lambda: (begun.set(), over.wait(20.0)))
    assert begun.wait(20.0)
    assert threads.run([threading.get_ident for _ in range(5)]) == [threading.get_ident()] * 5
    over.set()


@pytest.mark.parametrize("place", [0, 3])
def test_an_error_ends_all_before_it_is_raised(place: int) -> None:
    threads.use(2)
    running = []

    def call(i: int) -> None:
        if i == place:
            raise ZeroDivisionError
        running.append(i)
        running.remove(i)

    with pytest.raises(ZeroDivisionError):
        threads.run([partial(call, i) for i in range(6)])
    assert not running


@pytest.mark.parametrize("text", ["0", "-1", "two", "1.5", "²"])
def test_a_wrong_number_in_the_environment(text: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("LAMELLA_THREADS", text)
    threads.use(None)
    with pytest.raises(ModelError, match=f"LAMELLA_THREADS = '{text}' is not accepted; choose a whole number from 1"):
        threads.number()


def test_the_number_is_the_users_else_the_environments_else_one(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("LAMELLA_THREADS", "5")
    threads.use(None)
    assert threads.number() == 5
    threads.use(3)
    assert threads.number() == 3
    monkeypatch.delenv("LAMELLA_THREADS")
    threads.use(None)
    assert threads.number() == 1
    with pytest.raises(ModelError, match="threads: 0 is not accepted"):
        threads.use(0)


def test_workers_of_studies_take_one_thread() -> None:
    assert ONE_THREAD[threads.VARIABLE] == "1"
