"""Lanes compute for several numbers what the same expression computes for one; packing puts elements into their places."""

from __future__ import annotations

import subprocess
import sys

import numpy as np
import pytest

from lamella._jit import CACHE_FOLDER, announced, inlined, njit
from lamella.element.packing import packed, packed_indices, packed_targets, unpacked
from lamella.lane import WIDTH, aligned, chosen, load, load_at, number_at, power, spread, sqrt, store, store_at, total


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
    out[17 * WIDTH + 1] = number_at(b, WIDTH + 2)


@njit
def evaluate_number(a, b):
    return expression(a, b)


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


def test_first_compilation_is_announced_once_and_cached_kernels_are_silent():
    @njit
    def fresh(x):
        return x + 1.0

    said: list[str] = []
    with announced(said.append):
        fresh(1.0)
        fresh(2.0)
    assert len(said) <= 1  # nothing when an earlier run of this test left it in the cache
    evaluate_number(1.0, 2.0)  # compiled here at the latest
    with announced(said.append):
        evaluate_number(1.0, 2.0)
    assert len(said) <= 1


CODE = """
import numpy as np
from lamella._jit import announced
from lamella.element.plate48.kernels import energy
said = []
with announced(said.append):
    energy(np.zeros(1), np.zeros(0, int), np.zeros(0), np.zeros(0), np.zeros(0), 4, None, np.zeros(0), np.zeros(0))
print(len(said))
"""


def test_second_process_finds_compiled_kernels_in_the_cache():
    counts = [subprocess.run([sys.executable, "-c", CODE], capture_output=True, text=True, check=True).stdout for _ in range(2)]
    assert counts[1].strip() == "0"
    assert any(CACHE_FOLDER.rglob("*.nbi"))
