"""Steady spin: centrifugal force on every body, modes with the Coriolis force, and what is refused."""

from __future__ import annotations

import numpy as np
import pytest

import lamella as lm
from lamella.errors import DeclarationError, ModelError
from lamella.verification.spinning_ring import case

SECTION = lm.Laminate(lm.Isotropic(E=70e9, nu=0.3, rho=2700.0), thickness=2e-3)
SPEED = 30.0


def strip(omega=(0.0, 0.0, SPEED), **changes):
    system, plate = lm.System(), lm.Plate("strip", (1.0, 0.1), (4, 1), SECTION, position=(0.5, -0.05, 0.0))
    system.add(plate)
    system.add(lm.Clamp("root", plate.edge("x-")))
    system.add(lm.SteadySpin("spin", omega, **changes))
    return system


@pytest.mark.parametrize("centre", [(0.0, 0.0, 0.0), (0.2, 0.0, 5.0)])
def test_root_carries_mass_times_radius_times_speed_squared(centre):
    result = lm.equilibrium(strip(centre=centre))
    mass = 2700.0 * 2e-3 * 0.1
    expected = -mass * SPEED**2 * (1.0 - centre[0])
    # the strip grows by rho omega^2 L^2 / E = 3e-5 of its length
    assert float(result["root.force"][0]) == pytest.approx(expected, rel=1e-4)


def test_work_is_the_change_of_the_centrifugal_potential():
    result = lm.equilibrium(strip(), steps=400)
    # the trapezoidal rule is exact for a force that is linear in the load factor, here up to the stretch
    assert float(result["work.loads"]) == pytest.approx(float(result["energy.strain"]), rel=1e-4)


def test_roots_of_a_whirling_strip():
    """A square rod between springs would give omega_0 plus and minus Omega; the general pencil is checked against a dense one."""
    from scipy import linalg, sparse

    from lamella.solve.eigen import gyroscopic

    rng = np.random.default_rng(1)
    root = rng.standard_normal((12, 12))
    K, M = root @ root.T + 12 * np.eye(12), np.diag(rng.uniform(1.0, 2.0, 12))
    G = 3.0 * (root - root.T)
    zero, one = np.zeros((12, 12)), np.eye(12)
    exact = linalg.eigvals(np.block([[zero, one], [-K, -G]]), np.block([[one, zero], [zero, M]]))
    exact = np.sort(exact.imag[exact.imag > 0])[:3]
    empty = sparse.csr_array((0, 12))
    roots, shapes = gyroscopic(*(sparse.csc_array(x) for x in (K, G, M)), empty, 3, np.ones(12))
    np.testing.assert_allclose(roots.imag, exact, rtol=1e-9)
    np.testing.assert_allclose(roots.real, 0.0, atol=1e-9 * exact[0])
    for s, phi in zip(roots, shapes.T, strict=True):
        assert np.abs(K @ phi + s * (G @ phi) + s**2 * (M @ phi)).max() < 1e-7 * np.abs(K @ phi).max()


def test_free_mode_of_a_strip_on_its_axis_keeps_its_frequency_apart_from_the_coriolis_force():
    """About its own long axis a thin strip has next to no centrifugal force; shapes rotate, with a part out of phase."""
    system, plate = lm.System(), lm.Plate("strip", (1.0, 0.1), (4, 1), SECTION, position=(0.0, -0.05, 0.0))
    system.add(plate)
    system.add(lm.Clamp("root", plate.edge("x-")))
    still = lm.modes(system, 4).frequencies
    system.add(lm.SteadySpin("spin", (1e-3, 0.0, 0.0)))
    state = lm.equilibrium(system).final
    modes = lm.modes(system, 4, state=state)
    np.testing.assert_allclose(modes.frequencies, still, rtol=1e-6)  # quadratic in Omega / omega = 6e-5
    gram = modes.shapes.T @ (modes.model.mass @ modes.shapes) + modes.quadrature.T @ (modes.model.mass @ modes.quadrature)
    np.testing.assert_allclose(np.diag(gram), 1.0, rtol=1e-9)


def test_motion_and_modes_about_the_reference_are_refused():
    with pytest.raises(ModelError, match="frame that spins"):
        lm.simulate(strip(), 0.1, lm.GeneralizedAlpha(1e-2))
    with pytest.raises(ModelError, match=r"accepted is state=equilibrium\(system\).final"):
        lm.modes(strip(), 1)


def test_bad_spins_are_refused():
    with pytest.raises(DeclarationError, match=r"SteadySpin 'spin': angular_velocity = .*other than 0"):
        lm.SteadySpin("spin", (0.0, 0.0, 0.0))
    system = strip()
    system.add(lm.SteadySpin("again", (0.0, 0.0, 1.0)))
    with pytest.raises(DeclarationError, match="spins already"):
        system.compile()


def test_the_modes_of_a_free_ring_that_turns_do_not_seem_to_grow() -> None:
    """Rigid motions have multiple roots, whose rounding once made those of elastic modes grow by 1e-5 to 1e-2 of their size."""
    system = case.belt(case.MESH)
    system.add(lm.SteadySpin("spin", (0.0, 0.0, case.SPIN)))
    found = lm.modes(system, 24, state=case.spun(case.SPIN).final).frequencies
    elastic = found[np.abs(found) > 1.01 * case.SPIN / (2 * np.pi)]  # above a drift, which is seen to turn the other way
    assert len(elastic) >= 12
    assert np.all(elastic > 0.0)
    assert len(np.unique(elastic.round(6))) == len(elastic)
