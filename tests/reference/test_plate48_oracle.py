"""Plate48 against the slow energy of shell_oracle and against symbolic integration."""

from __future__ import annotations

import numpy as np
import pytest
import shell_oracle as oracle
import sympy

from lamella.element.packing import unpacked
from lamella.element.plate48.block import ShellBlock, ShellInertia
from lamella.element.plate48.entries import upper_entries
from lamella.element.plate48.recovery import ShellRecovery
from lamella.element.plate48.section import Section
from lamella.element.plate48.shape import Plate48, product_order

LENGTHS = (0.7, 0.4)
SCALE = np.repeat(Plate48().scales(*LENGTHS), 3)


def reference(kind, rng):
    """Flat rectangle, or the same with all coordinates disturbed: skewed, curved and twisted."""
    vectors = np.zeros((4, 4, 3))
    for node, (i, j) in enumerate(oracle.NODES):
        vectors[node, :3] = [[i * LENGTHS[0], j * LENGTHS[1], 0], [1, 0, 0], [0, 1, 0]]
    return vectors.reshape(48) + (0.1 * rng.standard_normal(48) if kind == "curved" else 0.0)


@pytest.fixture(params=[False, True], ids=["unit", "cubed"])
def cubed(request):
    return request.param


@pytest.fixture(params=[None, 3], ids=["one rule", "two rules"])
def options(request, cubed):
    """How the oracle is to measure curvature and to integrate the energy of the in-plane forces."""
    return {"cubed": cubed, "membrane_gauss": request.param}


def section(stiffness, cubed, membrane_gauss=None):
    return Section(stiffness, curvature="cubed_normal" if cubed else "unit_normal", membrane_gauss=membrane_gauss)


@pytest.fixture(params=["flat", "curved"])
def case(request):
    """The tables of one element, its reference, a large deformation, and the stiffness of an unsymmetric section."""
    rng = np.random.default_rng(11)
    rest = reference(request.param, rng)
    root = rng.standard_normal((6, 6))
    stiffness = root @ root.T
    R = np.linalg.qr(rng.standard_normal((3, 3)))[0]
    e = (rest.reshape(-1, 3) @ (R * np.sign(np.linalg.det(R))).T).reshape(-1) + 0.15 * rng.standard_normal(48)
    return ("plate", np.arange(48)[None], SCALE[None], rest[None]), rest, e, stiffness


def tangent(block, e, previous):
    """Force and full tangent in unscaled element coordinates."""
    f, k = np.empty(len(block.f_coords)), np.empty(len(block.k_rows))
    block.force_tangent(0.0, e, e, 1.0, 0.0, previous, f, k)
    order, (rows, columns) = product_order(), upper_entries()
    K = np.zeros((48, 48))
    K[order[rows], order[columns]] = unpacked(k * block.k_scale, 1)[0]
    force = np.zeros(48)
    force[order] = unpacked(f * block.f_scale, 1)[0]
    return force, K + K.T - np.diag(np.diag(K))


def test_energy_and_force(case, options):
    tables, rest, e, stiffness = case
    block = ShellBlock(*tables, section(stiffness, **options))
    f = tangent(block, e, e)[0]
    expected = oracle.force(e, rest, LENGTHS, stiffness, **options)
    assert block.energy(0.0, e) == pytest.approx(oracle.energy(e, rest, LENGTHS, stiffness, **options), rel=1e-13)
    np.testing.assert_allclose(f, expected, atol=1e-12 * np.abs(expected).max())


def test_tangent_against_differences_of_complex_steps(case, options):
    tables, rest, e, stiffness = case
    block = ShellBlock(*tables, section(stiffness, **options))
    K = tangent(block, e, e)[1]
    rng = np.random.default_rng(5)
    for _ in range(3):
        d = rng.standard_normal(48)
        numeric = oracle.directional_derivative(lambda h: oracle.force(e + h, rest, LENGTHS, stiffness, **options), d, 1e-4)
        np.testing.assert_allclose(K @ d, numeric, atol=1e-9 * np.abs(numeric).max())


def test_geometric_part_takes_extrapolated_resultants(case, cubed):
    """(K_mixed - K) d = D_d grad sum w (N_lin - N) . s, with N_lin from the strains' linear extrapolation."""
    tables, rest, e, stiffness = case
    block = ShellBlock(*tables, section(stiffness, cubed))
    rng = np.random.default_rng(6)
    before, d = e - 0.03 * rng.standard_normal(48), rng.standard_normal(48)

    def excess(xi, eta):
        s_before = oracle.local_strains(before + 1e-30j * (e - before), rest, LENGTHS, xi, eta, cubed=cubed)[0]
        return stiffness @ (
            s_before.real + s_before.imag / 1e-30 - oracle.local_strains(e, rest, LENGTHS, xi, eta, cubed=cubed)[0]
        )

    forces = [(xi, eta, w, excess(xi, eta)) for xi, eta, w in oracle.gauss_grid(4)]

    def potential(state):
        total = 0.0
        for xi, eta, w, n in forces:
            s, area = oracle.local_strains(state, rest, LENGTHS, xi, eta, cubed=cubed)
            total = total + w * area * (s @ n) * LENGTHS[0] * LENGTHS[1]
        return total

    expected = oracle.directional_derivative(lambda h: oracle.complex_gradient(potential, e + h), d, 1e-4)
    f, K_mixed = tangent(block, e, before)
    np.testing.assert_allclose(f, tangent(block, e, e)[0], rtol=1e-15)
    np.testing.assert_allclose((K_mixed - tangent(block, e, e)[1]) @ d, expected, atol=1e-9 * np.abs(expected).max())


def test_recovered_strains_and_normal(case, cubed):
    _, rest, e, stiffness = case
    curvature = section(stiffness, cubed).curvature
    recovery = ShellRecovery(Plate48(), np.arange(48)[None], SCALE[None], rest[None], curvature=curvature)
    xi, eta = np.array([0.0, 0.3, 1.0]), np.array([0.5, 0.9, 0.0])
    found = recovery.at(e, np.zeros(3, int), xi, eta)
    for k in range(3):
        expected = oracle.local_strains(e, rest, LENGTHS, xi[k], eta[k], cubed=cubed)[0]
        derivatives = oracle.surface(e, LENGTHS, xi[k], eta[k])
        np.testing.assert_allclose(found.strains[k], expected, atol=1e-12 * np.abs(expected).max())
        np.testing.assert_allclose(found.n[k], oracle.forms(derivatives)[3], atol=1e-13)
        np.testing.assert_allclose(found.r[k], derivatives[0, 0], atol=1e-14)


def test_mass_of_a_rectangle_equals_symbolic_integration():
    s, a, b = sympy.symbols("s a b", positive=True)

    def products(length):
        phi = [1 - 3 * s**2 + 2 * s**3, length * (s - 2 * s**2 + s**3), 3 * s**2 - 2 * s**3, length * (s**3 - s**2)]
        return [[sympy.integrate(sympy.expand(u * v), (s, 0, 1)) * length for v in phi] for u in phi]

    in_x, in_y = products(a), products(b)
    numbers = [(2 * i + dx, 2 * j + dy) for i, j in oracle.NODES for dx, dy in [(0, 0), (1, 0), (0, 1), (1, 1)]]
    values = {a: sympy.Rational(7, 10), b: sympy.Rational(4, 10)}
    expected = np.array([[float((in_x[p][u] * in_y[q][w]).subs(values)) for u, w in numbers] for p, q in numbers])
    i, j, masses = ShellInertia("p", np.arange(48)[None], SCALE[None], reference("flat", None)[None], 3.0).mass()
    m = np.zeros((16, 16))
    m[i, j] = masses
    np.testing.assert_allclose(m, 3.0 * expected, atol=1e-15)
