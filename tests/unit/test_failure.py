"""Failure criteria: points on the failure surface, invariance, reserve factors and messages."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lamella.errors import DeclarationError
from lamella.material.failure import (
    fibre_stress,
    principal_stresses,
    tsai_hill,
    tsai_hill_reserve,
    tsai_wu,
    tsai_wu_reserve,
    von_mises,
)
from lamella.material.isotropic import Isotropic
from lamella.material.lamina import Lamina
from lamella.material.laminate import Laminate
from lamella.material.recovery import failure_index, ply_stress

# T300/5208, Tsai and Hahn (1980)
PLY = Lamina(181e9, 10.3e9, 7.17e9, 0.28, 1600, Xt=1500e6, Xc=1500e6, Yt=40e6, Yc=246e6, S12=68e6)
UNEQUAL = Lamina(181e9, 10.3e9, 7.17e9, 0.28, 1600, Xt=1500e6, Xc=900e6, Yt=40e6, Yc=246e6, S12=68e6)
AT_FAILURE = np.array([[1500e6, 0, 0], [-900e6, 0, 0], [0, 40e6, 0], [0, -246e6, 0], [0, 0, 68e6], [0, 0, -68e6]])

component = st.floats(-1e9, 1e9).filter(lambda s: s == 0.0 or abs(s) > 1.0)
stresses = st.tuples(component, component, component).map(np.array)


@pytest.mark.parametrize("index", [tsai_hill, tsai_wu, tsai_hill_reserve, tsai_wu_reserve])
def test_each_strength_alone_is_failure(index) -> None:
    np.testing.assert_allclose(index(AT_FAILURE, UNEQUAL), 1.0, rtol=1e-12)


@given(stresses.filter(lambda s: np.abs(s).max() > 1e3))
def test_reserve_factors_lead_to_failure(stress: np.ndarray) -> None:
    reserve = tsai_wu_reserve(stress, UNEQUAL)
    assert tsai_wu(reserve * stress, UNEQUAL) == pytest.approx(1.0, rel=1e-9)  # cancellation between the terms costs digits
    if tsai_hill(stress, UNEQUAL) > 0.0:
        assert tsai_hill(tsai_hill_reserve(stress, UNEQUAL) * stress, UNEQUAL) == pytest.approx(1.0, rel=1e-9)


def test_reserve_without_stress_is_infinite() -> None:
    assert np.isinf(tsai_wu_reserve(np.zeros((2, 3)), PLY)).all()
    assert np.isinf(tsai_hill_reserve(np.zeros((2, 3)), PLY)).all()


@given(stresses)
def test_isotropic_criteria_are_von_mises(stress: np.ndarray) -> None:
    lamina = Isotropic(E=70e9, nu=0.3, rho=2700, strength=300e6).lamina
    expected = (von_mises(stress) / 300e6) ** 2
    assert tsai_hill(stress, lamina) == pytest.approx(expected, rel=1e-9, abs=1e-12)
    assert tsai_wu(stress, lamina) == pytest.approx(expected, rel=1e-9, abs=1e-12)


def test_von_mises_of_simple_states() -> None:
    states = np.array([[5.0, 0, 0], [0, 0, 2.0], [3.0, 3.0, 0], [1.0, -1.0, 0]])
    assert von_mises(states) == pytest.approx([5.0, 2 * np.sqrt(3), 3.0, np.sqrt(3)])


@given(stresses, st.floats(-360, 360))
def test_turning_the_axes_keeps_von_mises_and_principal_stresses(stress: np.ndarray, angle: float) -> None:
    turned = fibre_stress(stress, angle)
    rounding = 1e-12 * np.abs(stress).max() + 1e-300
    np.testing.assert_allclose(principal_stresses(turned), principal_stresses(stress), rtol=0, atol=10 * rounding)
    np.testing.assert_allclose(von_mises(turned), von_mises(stress), rtol=1e-7, atol=10 * rounding)


@given(stresses)
def test_principal_stresses_are_the_eigenvalues(stress: np.ndarray) -> None:
    s_x, s_y, t = stress
    eigenvalues = np.linalg.eigvalsh([[s_x, t], [t, s_y]])[::-1]
    np.testing.assert_allclose(principal_stresses(stress), eigenvalues, rtol=0, atol=1e-12 * np.abs(stress).max() + 1e-300)


def test_off_axis_strength_of_tsai_hill() -> None:
    """A strip pulled off its fibres fails at 1/sqrt(c^4/X^2 + (1/S^2 - 1/X^2) c^2 s^2 + s^4/Y^2) (Jones 1999, sec. 2.9)."""
    c2, s2 = np.cos(np.radians(30)) ** 2, np.sin(np.radians(30)) ** 2
    X, Y, S = 1500e6, 40e6, 68e6
    strength = (c2**2 / X**2 + (1 / S**2 - 1 / X**2) * c2 * s2 + s2**2 / Y**2) ** -0.5
    assert tsai_hill_reserve(fibre_stress(np.array([1.0, 0, 0]), 30), PLY) == pytest.approx(strength)


def test_ply_stress_in_both_axes_and_over_many_points() -> None:
    laminate = Laminate(PLY, (0, 90), 2e-3)
    strains = np.array([[1e-3, 0, 0, 0, 0, 0], [0, 0, 0, 0.5, 0, 0]])
    element = ply_stress(laminate, strains, 1, "top")
    fibre = ply_stress(laminate, strains, -1, "top", axes="fibre")
    Q22 = 10.3e9 / (1 - 0.28**2 * 10.3 / 181)
    assert element.shape == (2, 3)
    assert element[:, 0] == pytest.approx([Q22 * 1e-3, -Q22 * 1e-3 * 0.5])  # a positive curvature compresses the top
    np.testing.assert_allclose(fibre[:, 1], element[:, 0], rtol=1e-12)
    assert ply_stress(laminate, strains, 0, "bottom")[1, 0] > 0.0
    np.testing.assert_allclose(
        ply_stress(laminate, strains, 0, "top")[1], 0.0, atol=1e-6
    )  # the reference surface is not strained


@pytest.mark.parametrize("criterion", ["tsai-hill", "tsai-wu"])
def test_failure_index_of_a_ply(criterion) -> None:
    laminate = Laminate(PLY, (0, 90), 2e-3)
    strains = np.linspace(-1e-2, 1e-2, 24).reshape(4, 6)
    stress = ply_stress(laminate, strains, 1, "bottom", axes="fibre")
    expected = {"tsai-hill": tsai_hill, "tsai-wu": tsai_wu}[criterion](stress, PLY)
    np.testing.assert_array_equal(failure_index(laminate, strains, 1, "bottom", criterion), expected)


def test_missing_strengths_are_named() -> None:
    incomplete = Lamina(181e9, 10.3e9, 7.17e9, 0.28, 1600, Xt=1500e6, Xc=1500e6, Yt=40e6)
    with pytest.raises(
        DeclarationError, match=r"needs the strengths Yc, S12, which are not given; accepted are .*Isotropic: strength"
    ):
        failure_index(Laminate(incomplete, thickness=1e-3), np.zeros((1, 6)), 0)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"ply": 2}, r"Laminate: ply = 2; accepted is 0 \(bottom\) to 1 \(top\)"),
        ({"ply": -3}, "ply = -3; accepted is 0"),
        ({"ply": 0, "surface": "left"}, "surface = 'left'; accepted is bottom, middle, top"),
        ({"ply": 0, "axes": "global"}, "axes = 'global'; accepted is element, fibre"),
    ],
)
def test_impossible_places_are_refused(arguments: dict, message: str) -> None:
    with pytest.raises(DeclarationError, match=message):
        ply_stress(Laminate(PLY, (0, 90), 2e-3), np.zeros((1, 6)), **arguments)


def test_impossible_criterion_is_refused() -> None:
    with pytest.raises(DeclarationError, match="criterion = 'puck'; accepted is tsai-hill, tsai-wu"):
        failure_index(Laminate(PLY, (0, 90), 2e-3), np.zeros((1, 6)), 0, criterion="puck")  # type: ignore[arg-type]
