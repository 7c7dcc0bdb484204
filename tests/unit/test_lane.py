"""Lanes compute for several numbers what the same expression computes for one; packing puts elements into their places."""

from __future__ import annotations

import gc
import subprocess
import sys

import numba
import numpy as np
import pytest

from lamella._jit import CACHE_FOLDER, inlined, inner, njit, watched
from lamella.assembly.operator import SumOperator
from lamella.element.packing import packed, packed_indices, packed_targets, unpacked
from lamella.lane import (
    WIDTH,
    aligned,
    chosen,
    fetch_at,
    load,
    load_at,
    load_singles,
    number_at,
    power,
    put_at,
    spread,
    spread_singles,
    sqrt,
    store,
    store_at,
    store_singles,
    total,
)


@inlined
def expression(a, b):
    return (
        a + b, a - b, a * b, a / b, -a, sqrt(b), a + 2.0, 2.0 + a, a - 2.0, 2.0 - a, a * 2.0, 2.0 * a, a / 2.0, 2.0 / a,
        a * b + sqrt(b) / (1.0 - a),
    )  # fmt: skip


@njit
def evaluate(a, b, out):
    u, v = load(a, 0), load_at(b, 3)
    results = expression(u, v)
    for k in range(15):
        store(out, k, results[k])
    store(out, 15, spread(1.5))
    store_at(out, 16 * WIDTH, 2.5)
    out[17 * WIDTH] = total(u)
    put_at(out, 17 * WIDTH + 1, number_at(b, WIDTH + 2))


@njit
def evaluate_number(a, b):
    return expression(a, b)


@njit
def evaluate_singles(a, integers, factor, out):
    x, y = load_singles(a, 1), load_singles(integers, 2)
    result = factor * x * y - x + 2.0 * y - spread_singles(0.25)
    store_singles(out, 3, result)
    return total(result)


def test_lanes_of_single_numbers():
    """Twice as many numbers at once, of float32 and int16, with numbers that are rounded to single precision."""
    rng = np.random.default_rng(1)
    a, integers = rng.standard_normal(2 * WIDTH + 1).astype(np.float32), np.arange(-2, 2 * WIDTH, dtype=np.int16)
    out, x, y = np.zeros(2 * WIDTH + 4, np.float32), a[1:], np.arange(2 * WIDTH)
    whole = evaluate_singles(a, integers, 1.0 / 3.0, out)
    expected = x.astype(float) * y / 3.0 - x + 2.0 * y - 0.25
    np.testing.assert_allclose(out[3:-1], expected, rtol=0.0, atol=4.0 * np.finfo(np.float32).eps * np.abs(expected).max())
    assert not out[:3].any()
    assert not out[-1]
    assert whole == pytest.approx(expected.sum(), rel=1e-6)
    assert whole == np.float32(whole)


def test_lane_arithmetic_equals_that_of_numbers():
    rng = np.random.default_rng(0)
    a, b = rng.standard_normal(WIDTH), rng.uniform(0.5, 2.0, WIDTH + 3)
    out = np.empty(17 * WIDTH + 2)
    evaluate(a, b, out)
    # a fused multiply-add rounds once instead of twice
    results = out[: 15 * WIDTH].reshape(15, WIDTH)
    np.testing.assert_allclose(results, expression(a, b[3:]), rtol=4e-15)
    np.testing.assert_allclose(evaluate_number(a[0], b[3]), results[:, 0], rtol=4e-15)
    assert (out[15 * WIDTH : 16 * WIDTH] == 1.5).all()
    assert (out[16 * WIDTH : 17 * WIDTH] == 2.5).all()
    assert out[-2] == pytest.approx(a.sum(), abs=1e-15 * WIDTH)
    assert out[-1] == b[-1]


@njit
def through(numbers, out, back):
    fetch_at(numbers, 10**6)
    store(out, 0, load(numbers, 1))
    store(out, 1, load_at(numbers, 3))
    out[2 * WIDTH] = number_at(numbers, WIDTH + 2)
    store(back, 0, load(out, 0) / 3.0)
    store_at(back, WIDTH + 1, load(out, 1) / 3.0)


def test_single_precision_is_widened_when_it_is_read_and_rounded_when_it_is_written():
    singles = np.random.default_rng(1).standard_normal(2 * WIDTH + 1).astype(np.float32)
    out, back = np.empty(2 * WIDTH + 1), np.full(2 * WIDTH + 2, -1.0, np.float32)
    through(singles, out, back)
    np.testing.assert_array_equal(out, [*singles[WIDTH : 2 * WIDTH], *singles[3 : WIDTH + 3], singles[WIDTH + 2]])
    thirds = (out[: 2 * WIDTH] / 3.0).astype(np.float32)
    np.testing.assert_array_equal(back, [*thirds[:WIDTH], -1.0, *thirds[WIDTH:], -1.0])


def test_integers_become_numbers_when_they_are_read_and_are_cut_when_they_are_written():
    integers = np.random.default_rng(1).integers(-(2**15), 2**15, 2 * WIDTH + 1).astype(np.int16)
    out, back = np.empty(2 * WIDTH + 1), np.full(2 * WIDTH + 2, -1, np.int16)
    through(integers, out, back)
    np.testing.assert_array_equal(out, [*integers[WIDTH : 2 * WIDTH], *integers[3 : WIDTH + 3], integers[WIDTH + 2]])
    thirds = np.trunc(out[: 2 * WIDTH] / 3.0)
    np.testing.assert_array_equal(back, [*thirds[:WIDTH], -1, *thirds[WIDTH:], -1])


@njit
def choose(a, b, out):
    u, v = load(a, 0), load(b, 0)
    store(out, 0, chosen(u, v, -1.0))
    store(out, 1, power(v, 0.7))
    out[2 * WIDTH] = chosen(a[0], b[0], -1.0) + power(b[0], 0.7)


def test_lane_chooses_and_raises_to_a_power_place_by_place():
    a, b = np.where(np.arange(WIDTH) % 2, 1.0, -1.0), np.linspace(0.5, 3.0, WIDTH)
    a[2], out = np.nan, np.empty(2 * WIDTH + 1)
    choose(a, b, out)
    np.testing.assert_array_equal(out[:WIDTH], chosen(a, b, -1.0))
    assert (out[:WIDTH] == np.where(np.arange(WIDTH) % 2, b, -1.0)).all()
    np.testing.assert_allclose(out[WIDTH : 2 * WIDTH], power(b, 0.7), rtol=1e-15)
    assert out[-1] == pytest.approx(-1.0 + 0.5**0.7, rel=1e-15)


def test_lane_keeps_nan_and_infinity_in_their_place():
    a, b = np.ones(WIDTH), np.ones(WIDTH + 3)
    a[2], b[3 + 1] = np.nan, np.inf
    out = np.empty(17 * WIDTH + 2)
    evaluate(a, b, out)
    assert np.flatnonzero(np.isnan(out[:WIDTH])).tolist() == [2]
    assert np.flatnonzero(np.isinf(out[:WIDTH])).tolist() == [1]


@pytest.mark.parametrize("n", [1, 7, 8, 9, 16])
def test_packing_repeats_the_last_element_and_hides_it_from_the_assembly(n):
    values = np.random.default_rng(n).standard_normal((n, 3))
    coords = np.arange(3 * n).reshape(n, 3)
    flat, indices, targets = packed(values), packed_indices(coords), packed_targets(coords)
    assert flat.size == indices.size == targets.size == -(-n // WIDTH) * WIDTH * 3
    np.testing.assert_array_equal(unpacked(flat, n), values)
    np.testing.assert_array_equal(unpacked(targets, n), coords)
    assert np.count_nonzero(targets < 0) == flat.size - 3 * n
    assert indices.min() >= 0
    assert indices.max() == coords.max()
    assert set(flat) == set(values.reshape(-1))


def test_work_space_starts_a_cache_line():
    assert all(aligned(n).ctypes.data % 64 == 0 and aligned(n).size == n for n in (1, 5, 1000))


class Heard:
    """The kernels that a watch was told of."""

    def __init__(self) -> None:
        self.names: list[str] = []
        self.ended = 0

    def begin(self, name: str) -> None:
        self.names.append(name)

    def end(self) -> None:
        self.ended += 1


@inner
def one_more(x):
    return x + 1.0


def test_a_watch_hears_of_kernels_but_not_of_their_parts_and_of_none_that_is_compiled():
    def _sum(x, y):
        return one_more(x) + y

    fresh = numba.njit(_sum)  # without a cache, in which an earlier run would have left it
    heard = Heard()
    with watched(heard):
        fresh(1.0, 2.0)
        fresh(2.0, 3.0)
    assert heard.names == ["test_lane.sum"]
    assert heard.ended == 1
    fresh(1, 2)  # compiled for integers, but nobody watches any more
    assert heard.ended == 1


def test_an_array_with_gaps_is_refused():
    """Kernels count the entries from the first one: they would read what lies between."""
    both, x = SumOperator(np.arange(3), np.arange(3), np.ones(3), 3), np.arange(6.0)
    np.testing.assert_array_equal(both(x[:3]), x[:3])
    for gaps in (x[::2], np.asfortranarray(x.reshape(3, 2))[:, 0][::2]):
        with pytest.raises(numba.TypingError, match="an array without gaps"):
            both(gaps)


def test_python_calls_an_inner_function_as_it_stands():
    assert one_more(1.0) == 2.0


def test_arrays_are_found_first_and_other_sequences_still():
    @numba.njit
    def picked(a, names, pairs):
        a[0] = a[1] + pairs[1]
        return names[1] + str(len(pairs))

    a = np.array([0.0, 1.0])
    assert picked(a, ("x", "y"), (1.0, 2.0)) == "y2"
    assert a[0] == 3.0


@pytest.mark.parametrize("enabled", [True, False])
def test_garbage_is_left_until_a_kernel_is_compiled(enabled):
    states = []

    class Look(Heard):
        def begin(self, name):
            states.append(gc.isenabled())

    def failing(x):
        return x.nothing

    was = gc.isenabled()
    (gc.enable if enabled else gc.disable)()
    try:
        with watched(Look()), pytest.raises(numba.TypingError):
            numba.njit(failing)(1.0)
        states.append(gc.isenabled())
    finally:
        (gc.enable if was else gc.disable)()
    assert states == [False, enabled]


CODE = """
import numpy as np
from lamella._jit import watched
from lamella.element.plate48.kernels import energy
names = []
class Watch:
    def begin(self, name): names.append(name)
    def end(self): pass
with watched(Watch()):
    energy(np.zeros(1), np.zeros(0, int), np.zeros(0), np.zeros(0), np.zeros(0), 4, None, np.zeros(0), np.zeros(0))
import sys
print(len(names), "numba.typed.dictobject" in sys.modules)
"""


def test_second_process_finds_compiled_kernels_in_the_cache():
    counts = [subprocess.run([sys.executable, "-c", CODE], capture_output=True, text=True, check=True).stdout for _ in range(2)]
    assert counts[1].strip() == "0 False"  # and reads them without Numba's tables of functions and types
    assert any(CACHE_FOLDER.rglob("*.nbi"))
