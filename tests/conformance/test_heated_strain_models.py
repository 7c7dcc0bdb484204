"""Every strain model follows thermal strain: exact derivatives, free expansion, and agreement where strains are small."""

from __future__ import annotations

import numpy as np
import pytest
from shell_patch import SURFACES, dense, derivative, gathered_force, patch, random_rotation, section, turned

import lamella as lm
from lamella.element import ELEMENTS
from lamella.element.plate48.block import HEATED, STRAIN_MODELS, HeatedElements
from lamella.element.plate48.section import Section
from lamella.math.rotation import matrix_from_vector

XS, YS = [0.0, 0.5, 0.8, 1.5], [0.0, 0.4, 1.0, 1.3]  # nine elements: one full block of eight and one alone
MODELS = ("exact", "linear", "floating", "floating at x-", "corotational")
FRAMED = MODELS[2:]
PLAIN, OTHER = {}, {"curvature": "cubed_normal", "membrane_gauss": 3}  # how a section is measured and integrated


@pytest.fixture(params=list(SURFACES))
def mesh(request):
    return patch(ELEMENTS["plate48"], XS, YS, SURFACES[request.param])


@pytest.fixture
def rng():
    return np.random.default_rng(11)


class Heated:
    """A heated model of a patch: all coordinates are the vectors and, behind them, T_N and T_M of each node."""

    def __init__(self, name, mesh, stiffness, expansion):
        model, _, edge = name.partition(" at ")
        elastic = STRAIN_MODELS[model]("plate", *mesh.tables, stiffness, **({"frame_at": edge} if edge else {}))
        numbers = mesh.coords[:, ::12] // 12  # node numbers: twelve coordinates each
        fields = len(mesh.rest) + 2 * numbers
        temperatures = np.concatenate([fields, fields + 1], axis=1)
        elements = HeatedElements("plate", *mesh.tables, stiffness, 4, temperatures, expansion)
        self.blocks, self.n, self.n_T = HEATED[type(elastic)](elastic, elements), len(mesh.rest), 2 * len(mesh.nodes)

    def energy(self, q):
        return sum(block.energy(0.0, q) for block in self.blocks)

    def force(self, q):
        return sum(gathered_force(block, q) for block in self.blocks)

    def tangent(self, q, alpha_q):
        return sum(dense(block, q, alpha_q=alpha_q)[1] for block in self.blocks)


@pytest.fixture(params=[*((name, PLAIN) for name in MODELS), ("exact", OTHER), ("linear", OTHER), ("floating", OTHER)])
def heated(request, mesh, rng):
    name, options = request.param
    return Heated(name, mesh, Section(section(rng), **options), rng.standard_normal((3, 3)))


def state(mesh, rng, size=0.05):
    """A deformed and turned patch with temperatures that give strains of the same size."""
    q = mesh.rest + size * rng.standard_normal(mesh.rest.shape)
    q = turned(q, mesh.is_position, random_rotation(rng), rng.standard_normal(3))
    return np.concatenate([q, size * rng.standard_normal(2 * len(mesh.nodes))])


def test_force_is_the_derivative_of_the_energy(mesh, heated, rng):
    q, d = state(mesh, rng), np.concatenate([rng.standard_normal(heated.n), np.zeros(heated.n_T)])
    numeric = derivative(lambda h: heated.energy(q + h * d), 2e-4)
    assert heated.force(q) @ d == pytest.approx(numeric, rel=1e-9)


def test_tangent_is_the_derivative_of_the_force_by_shape_and_temperature(mesh, heated, rng):
    q = state(mesh, rng)
    d = rng.standard_normal(q.shape)
    for part in (d, np.concatenate([np.zeros(heated.n), d[heated.n :]])):
        numeric = derivative(lambda h, part=part: heated.force(q + h * part), 2e-4)
        np.testing.assert_allclose(heated.tangent(q, 0.7) @ part, 0.7 * numeric, atol=1e-9 * np.abs(numeric).max())


def test_without_heat_nothing_changes(mesh, rng):
    C = section(rng)
    q = np.concatenate([state(mesh, rng)[: len(mesh.rest)], np.zeros(2 * len(mesh.nodes))])
    for name in ("exact", "linear", "floating", "corotational"):
        cold = STRAIN_MODELS[name]("plate", *mesh.tables, C)
        warm = Heated(name, mesh, C, rng.standard_normal((3, 3)))
        f = gathered_force(cold, q)
        np.testing.assert_allclose(warm.force(q), f, atol=1e-13 * np.abs(f).max())
        assert warm.energy(q) == pytest.approx(cold.energy(0.0, q), rel=1e-13)


@pytest.mark.parametrize(
    ("name", "options"), [*((name, PLAIN) for name in MODELS[1:]), ("linear", OTHER), ("corotational", OTHER)]
)
def test_models_agree_with_exact_strains_to_first_order(mesh, rng, name, options):
    """Forces differ by the square, energies by the cube, of small deformations and temperatures of one size."""
    C, expansion = Section(section(rng), **options), rng.standard_normal((3, 3))
    exact, small = Heated("exact", mesh, C, expansion), Heated(name, mesh, C, expansion)
    d = np.concatenate([0.0 * mesh.rest, np.zeros(small.n_T)]) + rng.standard_normal(small.n + small.n_T)
    rest = np.concatenate([mesh.rest, np.zeros(small.n_T)])
    forces, energies = [], []
    for h in (2e-5, 1e-5):
        q = rest + h * d
        forces.append(np.abs(exact.force(q) - small.force(q)).max())
        energies.append(abs(exact.energy(q) - small.energy(q)))
    assert forces[0] / forces[1] == pytest.approx(4.0, rel=0.01)
    assert energies[0] / energies[1] == pytest.approx(8.0, rel=0.02)


@pytest.mark.parametrize("name", FRAMED)
def test_heat_turns_with_the_frame(mesh, rng, name):
    heated, q = Heated(name, mesh, section(rng), rng.standard_normal((3, 3))), state(mesh, rng)
    R, n = random_rotation(rng), len(mesh.rest)
    after = np.concatenate([turned(q[:n], mesh.is_position, R, np.array([1.0, -2.0, 0.5])), q[n:]])
    expected = heated.force(q)
    expected[:n] = (expected[:n].reshape(-1, 3) @ R.T).reshape(-1)
    np.testing.assert_allclose(heated.force(after), expected, atol=1e-11 * np.abs(expected).max())
    assert heated.energy(after) == pytest.approx(heated.energy(q), rel=1e-11)


# --- sheets -----------------------------------------------------------------------------------------


E, NU, ALPHA, THICKNESS = 70e9, 0.3, 23e-6, 0.01
SHEET = lm.Laminate(lm.Isotropic(E=E, nu=NU, rho=2700.0, alpha=ALPHA, k=200.0, c=900.0), thickness=THICKNESS)


@pytest.mark.parametrize("name", MODELS[1:])
def test_a_free_sheet_expands_and_curves_without_stress(rng, name):
    """u = alpha T_N (x, y) and w = -alpha T_M (x^2 + y^2) / 2, turned at will: eps = alpha T_N, kap = -alpha T_M."""
    mesh = patch(ELEMENTS["plate48"], XS, YS)
    heated = Heated(name, mesh, SHEET.stiffness, SHEET.thermal_moments)
    T_N, T_M = 40.0, 300.0
    x, y = np.array(mesh.nodes).T
    grown = (1.0 + ALPHA * T_N) * mesh.rest.reshape(-1, 4, 3)
    if name == "linear":
        bend = -ALPHA * T_M
        grown[:, 0, 2], grown[:, 1, 2], grown[:, 2, 2] = bend * (x**2 + y**2) / 2, bend * x, bend * y
    else:
        T_M = 0.0  # a frame turns with the mean slope: second order in the bending, which is seen below
    q = np.concatenate([grown.reshape(-1), np.tile([T_N, T_M], len(mesh.nodes))])
    if name != "linear":
        q[: heated.n] = turned(q[: heated.n], mesh.is_position, random_rotation(rng), np.array([3.0, 1.0, -2.0]))
    held = np.concatenate([mesh.rest, q[heated.n :]])
    # rounding of displacements, 1e-16 of 1.5 m, beside alpha T_N = 9e-4 of it; energies are differences of larger ones
    assert np.abs(heated.force(q)).max() < 1e-11 * np.abs(heated.force(held)).max()
    assert abs(heated.energy(q)) < 1e-11 * heated.energy(held)
    held_energy = E * THICKNESS / (1 - NU) * (ALPHA * T_N) ** 2 + E * THICKNESS**3 / (12 * (1 - NU)) * (ALPHA * T_M) ** 2
    assert heated.energy(held) == pytest.approx(held_energy * XS[-1] * YS[-1], rel=1e-12)


def strip(name, turn=(0.0, 0.0, 0.0), T_M=150.0, T_N=20.0):
    """Displacement [m] of the end of a heated strip, held so that it may grow, in its own axes."""
    model, _, edge = name.partition(" at ")
    R, system = matrix_from_vector(np.array(turn)), lm.System()
    body = system.add(lm.Plate("strip", (1.0, 0.1), (8, 1), SHEET, rotation=turn, strain=model, frame_at=edge or "mean"))
    system.add(lm.Clamp("root", body.edge("x-"), kind="sliding"))
    system.add(lm.TemperatureField("warmth", body))
    system.add(lm.PrescribedTemperature("sun", body, T_N, T_M))
    body.marker("end", 1.0, 0.05)
    result = lm.equilibrium(system, newton=lm.Newton(tolerance=1e-12))
    return result["end.position"].values @ R - (1.0, 0.05, 0.0)


def test_a_strip_grows_and_bends_alike_in_all_models():
    """u = alpha T_N L along, w = -alpha T_M L^2 / 2 across.

    The root cannot curve across and bends by 1 + nu along instead, over less than a width b: less than 2 nu b / L more in all.
    """
    expected = strip("linear")
    assert expected[0] == pytest.approx(ALPHA * 20.0, rel=1e-2)
    assert 1.0 < expected[2] / (-ALPHA * 150.0 / 2) < 1.0 + 2 * NU * 0.1
    for name in MODELS:
        found = strip(name)
        # the slope at the end, 3.5e-3, shortens a strip that bends exactly by its square: half a millionth of the length
        atol = 1e-9 if name in ("linear", "floating at x-") else 1e-5
        np.testing.assert_allclose(found, expected, atol=atol)
        if name in FRAMED:
            np.testing.assert_allclose(strip(name, (0.7, -1.9, 0.4)), found, atol=1e-9)


@pytest.mark.parametrize("name", MODELS)
def test_energy_balance_counts_what_heat_puts_in(name):
    """A strip that is warmed on one side within a few periods swings; the balance closes with the square of the step.

    Where everything is linear the trapezoidal rule, rho_inf = 1, keeps it but for what Newton's tolerance leaves.
    """
    model, _, edge = name.partition(" at ")
    worst = []
    for dt in (2e-3, 1e-3):
        system = lm.System()
        body = system.add(lm.Plate("strip", (1.0, 0.2), (2, 1), SHEET, strain=model, frame_at=edge or "mean"))
        system.add(lm.Clamp("root", body.edge("x-"), kind="restrained"))
        system.add(lm.TemperatureField("warmth", body))
        system.add(lm.PrescribedTemperature("sun", body, 1.0, 1000.0, lm.SmoothStep(t_end=0.1)))
        result = lm.simulate(system, 0.2, lm.GeneralizedAlpha(dt=dt, rho_inf=1.0, newton=lm.Newton(tolerance=1e-10)))
        worst.append(np.abs(result["energy.balance"].values).max() / result["energy.kinetic"].values.max())
    if name in ("linear", "floating at x-"):
        assert max(worst) < 1e-9
    else:
        assert worst[0] / worst[1] > 3.0
        assert worst[1] < 0.05
