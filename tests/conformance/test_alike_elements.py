"""Elements that are alike read the constants of one block; others, and those that are heated, have their own."""

from __future__ import annotations

import numpy as np
import pytest
from shell_patch import SURFACES, dense, gathered_force, patch

import lamella as lm
from lamella.assembly.equations import Equations
from lamella.element.plate48.block import SHELL
from lamella.element.plate48.inertia import ShellInertia
from lamella.element.plate48.section import Section
from lamella.element.plate48.shape import PLATE48, Plate48
from lamella.element.plate48.surface import ReferenceSurface
from lamella.lane import WIDTH, aligned

BLOCKS = {"elastic": SHELL.strain_models["exact"], "viscous": SHELL.viscous, "both": SHELL.damped}
OPTIONS = {"unit": {}, "cubed": {"curvature": "cubed_normal"}, "fewer points": {"membrane_gauss": 3}}
EVEN = np.linspace(0.0, 1.2, 6), np.linspace(0.0, 0.7, 4)
"""Fifteen elements, whose last block is not full."""
BLOCKS_OF_ALL = -(-15 // WIDTH)
STRETCHED = EVEN[0] * np.array([1.0, 1.0, 1.0, 1.0, 1.0, 1.0 + 1e-9]), EVEN[1]
SHEET = lm.Laminate(lm.Isotropic(E=70e9, nu=0.3, rho=2700.0, alpha=2e-5, k=200.0, c=900.0), thickness=2e-3)


def blocks_of_constants(block):
    return [arguments[2].size // (arguments[4] ** 2 * 27 * WIDTH) for arguments in block.arguments]


def made(kind, mesh, section):
    return BLOCKS[kind]("plate", *mesh.tables, section, *(() if kind == "elastic" else (0.3,)))


@pytest.mark.parametrize("surface", ["flat", "cylinder"])
@pytest.mark.parametrize("option", OPTIONS)
@pytest.mark.parametrize("kind", BLOCKS)
def test_one_block_of_constants_serves_all(kind, option, surface, monkeypatch):
    rng = np.random.default_rng(4)
    mesh = patch(PLATE48, *EVEN, SURFACES[surface])
    A = rng.standard_normal((6, 6))
    section = Section(A @ A.T + np.eye(6), **OPTIONS[option])
    shared = made(kind, mesh, section)
    with monkeypatch.context() as patched:
        patched.setattr(Plate48, "repeats", lambda self, coordinates: False)
        patched.setattr(ReferenceSurface, "repeats", False)
        apart = made(kind, mesh, section)
    assert set(blocks_of_constants(shared)) == {1}
    assert set(blocks_of_constants(apart)) == {BLOCKS_OF_ALL}
    q = mesh.rest + 0.02 * rng.standard_normal(mesh.rest.shape)
    v, x = rng.standard_normal((2, len(q)))
    (f, k), (expected, tangent) = (dense(block, q, v, 1.3, 0.7) for block in (shared, apart))
    np.testing.assert_allclose(f, expected, atol=1e-12 * np.abs(expected).max())
    np.testing.assert_allclose(k, tangent, atol=1e-12 * np.abs(tangent).max())
    products = []
    for block in (shared, apart):
        operator, y = block.tangent(), aligned(len(block.f_coords))
        operator.look(0.0, q, v, 1.3, 0.7)
        operator.multiply(x, y)
        products.append(y)
    np.testing.assert_allclose(*products, atol=1e-12 * np.abs(products[1]).max())
    if kind == "elastic":
        assert shared.energy(0.0, q) == pytest.approx(apart.energy(0.0, q), rel=1e-12)


@pytest.mark.parametrize("lines", [EVEN, STRETCHED, (1e3 + EVEN[0], EVEN[1])], ids=["alike", "longer", "far away"])
@pytest.mark.parametrize("surface", ["flat", "cylinder"])
def test_masses_of_elements_that_are_alike(surface, lines, monkeypatch):
    coords, scale, reference = patch(PLATE48, *lines, SURFACES[surface]).tables

    def masses(density):
        return ShellInertia("plate", coords, scale, reference, density).mass()

    one, several = masses(4.0), masses(4.0 + np.arange(15.0))
    monkeypatch.setattr(Plate48, "repeats", lambda self, coordinates: False)
    for found, expected in ((one, masses(4.0)), (several, masses(4.0 + np.arange(15.0)))):
        for part, other in zip(found, expected, strict=True):
            np.testing.assert_allclose(part, other, rtol=1e-11, atol=1e-14)
    assert np.sum(one[2].reshape(15, 16, 16)[1]) != pytest.approx(np.sum(several[2].reshape(15, 16, 16)[1]))


def test_what_counts_as_alike():
    """A displacement does, but for rounding; a rotation, another length by a billionth, and an imperfection of 1e-9 do not."""
    (_, scale, flat), (_, _, moved) = patch(PLATE48, *EVEN).tables, patch(PLATE48, *EVEN, SURFACES["cylinder"]).tables
    assert PLATE48.repeats(flat * scale)
    assert PLATE48.repeats((flat + np.tile([10.0, 20.0, 0.0] + [0.0] * 9, 4)) * scale)
    assert not PLATE48.repeats(moved * scale)
    _, longer, stretched = patch(PLATE48, *STRETCHED).tables
    assert not PLATE48.repeats(stretched * longer)
    flat = flat.copy()
    flat[7, 2] += 1e-9
    assert not PLATE48.repeats(flat * scale)


@pytest.mark.parametrize(
    ("lines", "surface"),
    [(STRETCHED, "flat"), (EVEN, "twisted"), ((EVEN[0] ** 2, EVEN[1]), "flat")],
    ids=["longer", "twisted", "graded"],
)
def test_elements_that_differ_have_constants_of_their_own(lines, surface):
    mesh = patch(PLATE48, *lines, SURFACES[surface])
    block = made("elastic", mesh, Section(np.eye(6)))
    assert blocks_of_constants(block) == [BLOCKS_OF_ALL]
    rest = gathered_force(block, mesh.rest)
    assert np.abs(rest).max() < 1e-13


def test_sections_of_their_own_too():
    mesh = patch(PLATE48, *EVEN)
    block = made("elastic", mesh, Section(np.stack([(1.0 + e) * np.eye(6) for e in range(15)])))
    assert blocks_of_constants(block) == [BLOCKS_OF_ALL]


def test_a_place_far_away_does_not_tell_elements_apart():
    """Coordinates of some hundred element lengths have so much rounding that elements differ by 1e-14 of their size."""
    far = patch(PLATE48, EVEN[0] + 100.0, EVEN[1] - 70.0)
    assert not np.array_equal(np.diff(EVEN[0] + 100.0), np.diff(EVEN[0]))
    assert blocks_of_constants(made("elastic", far, Section(np.eye(6)))) == [1]


def test_heated_elements_have_their_own():
    """Their constants follow the temperatures, which differ."""
    system = lm.System()
    plate = system.add(lm.Plate("plate", (0.5, 0.2), (8, 4), SHEET))
    system.add(lm.Clamp("root", plate.edge("x-")))
    system.add(lm.TemperatureField("field", plate, reference=290.0))
    (block,) = [
        block for block in Equations(system.compile()).model.forces if hasattr(block, "temperatures") and hasattr(block, "parts")
    ]
    assert blocks_of_constants(block) == [32 // WIDTH]
