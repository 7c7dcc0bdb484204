"""Laminate: published numbers, invariants of lamination theory, signs, and messages for impossible data."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lamella.errors import DeclarationError
from lamella.material.isotropic import Isotropic
from lamella.material.lamina import Lamina, reduced_stiffness, rotated_expansion, rotated_stiffness, stress_transformation
from lamella.material.laminate import Laminate, Ply, thermal_resultants
from lamella.material.recovery import ply_stress, section_forces

T300 = Lamina(E1=181e9, E2=103e9, G12=7.7e9, nu12=0.28, rho=1560)
HOT = Lamina(E1=181e9, E2=10.3e9, G12=7.17e9, nu12=0.28, rho=1600, alpha1=0.02e-6, alpha2=22.5e-6)
STEEL = Isotropic(E=210e9, nu=0.3, rho=7850, alpha=12e-6)
OUTER = (-45, 45, -45, 45, 90, 0)

# The references carry nine digits (plates) or eight (solar array): half a unit of the last digit, relative.
NINE_DIGITS = 3e-9
EIGHT_DIGITS = 3e-8

angles = st.floats(-180, 180)
stacks = st.lists(st.tuples(angles, st.floats(1e-4, 1e-2)), min_size=1, max_size=6)


def laminate_of(stack: list[tuple[float, float]], material: Lamina = HOT, offset: float = 0.0) -> Laminate:
    return Laminate(plies=tuple(Ply(material, a, thickness=h) for a, h in stack), offset=offset)


def test_cross_ply_of_the_plate_examples() -> None:
    laminate = Laminate(T300, angles=(0, 90, 0), thickness=1.5e-3)
    A, D = laminate.A, laminate.D
    assert [A[0, 0], A[1, 1], A[0, 1], A[2, 2]] == pytest.approx(
        [2.43357228e8, 2.02536016e8, 4.52801449e7, 1.155e7], rel=NINE_DIGITS
    )
    assert [D[0, 0], D[1, 1], D[0, 1], D[2, 2]] == pytest.approx([52.4330157, 31.1719675, 8.49002717, 2.165625], rel=NINE_DIGITS)
    assert np.abs(laminate.B).max() < 1e-12 * A[0, 0] * laminate.h  # rounding
    assert laminate.mass_per_area == pytest.approx(2.34)


def test_unsymmetric_cross_ply_has_the_signs_of_the_reference() -> None:
    laminate = Laminate(T300, angles=(0, 90), thickness=1.5e-3)
    assert laminate.A[0, 0] == pytest.approx(2.22946622e8, rel=NINE_DIGITS)
    assert laminate.A[1, 1] == pytest.approx(2.22946622e8, rel=NINE_DIGITS)
    assert laminate.B[0, 0] == pytest.approx(-22961.932, rel=EIGHT_DIGITS)
    assert laminate.B[1, 1] == pytest.approx(22961.932, rel=EIGHT_DIGITS)
    assert laminate.D[0, 0] == pytest.approx(41.8024916, rel=NINE_DIGITS)


def test_symmetric_panel_of_the_solar_array() -> None:
    laminate = Laminate(T300, OUTER + OUTER[::-1], thickness=1.5e-3)
    A, D = laminate.A, laminate.D
    assert [A[0, 0], A[0, 1], A[2, 2]] == pytest.approx([1.71424463e8, 9.68023039e7, 6.30721590e7], rel=EIGHT_DIGITS)
    assert [D[0, 0], D[1, 1], D[0, 1], D[2, 2]] == pytest.approx(
        [27.5296578, 28.1674893, 22.4439452, 16.1195431], rel=EIGHT_DIGITS
    )
    assert [D[0, 2], D[1, 2]] == pytest.approx([-1.27566, -1.27566], rel=1e-5)  # six digits given


def test_antisymmetric_panel_of_the_solar_array() -> None:
    laminate = Laminate(T300, (-45, 45, -45, 45, 90, 0, 0, -90, -45, 45, -45, 45), thickness=1.5e-3)
    assert [laminate.B[0, 2], laminate.B[1, 2]] == pytest.approx([1275.663, 1275.663], rel=1e-6)  # seven digits given
    assert np.abs(laminate.D[:2, 2]).max() < 1e-12 * laminate.D[0, 0]


def test_stretching_a_0_90_strip_bends_it_towards_the_compliant_side() -> None:
    """The stiff 0 ply lies at the bottom, so a pull in the reference surface must bend the ends downwards: kap_x < 0."""
    strains = np.linalg.solve(Laminate(T300, (0, 90), 1.5e-3).stiffness, [1e4, 0, 0, 0, 0, 0])
    assert strains[0] > 0.0
    assert strains[3] < 0.0


def test_isotropic_sheet_has_the_textbook_stiffness() -> None:
    E, nu, h = 210e9, 0.3, 2e-3
    laminate = Laminate(Isotropic(E, nu, 7850), thickness=h)
    pattern = np.array([[1, nu, 0], [nu, 1, 0], [0, 0, (1 - nu) / 2]])
    np.testing.assert_allclose(laminate.A, E * h / (1 - nu**2) * pattern, rtol=1e-13)
    np.testing.assert_allclose(laminate.D, E * h**3 / 12 / (1 - nu**2) * pattern, rtol=1e-13)
    assert laminate.mass_per_area == pytest.approx(15.7)


@given(angles)
def test_rotation_keeps_the_invariants_of_a_ply(angle: float) -> None:
    Q, Dk = reduced_stiffness(HOT), rotated_stiffness(HOT, angle)
    rounding = 1e-12 * Q[0, 0]
    assert Dk[0, 0] + Dk[1, 1] + 2 * Dk[0, 1] == pytest.approx(Q[0, 0] + Q[1, 1] + 2 * Q[0, 1], abs=rounding)
    assert Dk[2, 2] - Dk[0, 1] == pytest.approx(Q[2, 2] - Q[0, 1], abs=rounding)
    np.testing.assert_allclose(Dk, Dk.T, rtol=0, atol=rounding)
    alpha = rotated_expansion(HOT, angle)
    assert alpha[0] + alpha[1] == pytest.approx(HOT.alpha1 + HOT.alpha2, rel=1e-12)


def test_transformation_turns_uniaxial_stress_into_the_fibre_axes() -> None:
    assert stress_transformation(30) @ [1, 0, 0] == pytest.approx([0.75, 0.25, -math.sqrt(3) / 4])


@given(stacks)
def test_section_is_stable_and_symmetric(stack: list[tuple[float, float]]) -> None:
    stiffness = laminate_of(stack, offset=1e-3).stiffness
    scale = 1.0 / np.sqrt(np.diag(stiffness))
    scaled = scale[:, None] * stiffness * scale
    np.testing.assert_allclose(scaled, scaled.T, atol=1e-12)
    assert np.linalg.eigvalsh(scaled).min() > 0.0


@given(stacks, st.floats(-5e-3, 5e-3))
def test_offset_shifts_the_stiffness_by_the_parallel_axis_rule(stack: list[tuple[float, float]], c: float) -> None:
    centred, shifted = laminate_of(stack), laminate_of(stack, offset=c)
    rounding = 1e-11 * np.abs(shifted.D).max()
    expected_D = centred.D + 2 * c * centred.B + c**2 * centred.A
    np.testing.assert_allclose(
        shifted.B, centred.B + c * centred.A, rtol=0, atol=1e-11 * np.abs(centred.A).max() * (abs(c) + centred.h)
    )
    np.testing.assert_allclose(shifted.D, expected_D, rtol=0, atol=rounding + 1e-11 * np.abs(centred.D).max())


@given(stacks)
def test_turning_the_stack_upside_down_changes_the_sign_of_the_coupling(stack: list[tuple[float, float]]) -> None:
    up, down = laminate_of(stack), laminate_of(stack[::-1])
    np.testing.assert_allclose(down.B, -up.B, rtol=0, atol=1e-12 * np.abs(up.A).max() * up.h)
    np.testing.assert_allclose(down.D, up.D, rtol=0, atol=1e-12 * np.abs(up.D).max())


@given(stacks, st.lists(st.floats(-1e-2, 1e-2), min_size=6, max_size=6), st.floats(-100, 100), st.floats(-1e4, 1e4))
def test_ply_stresses_integrate_to_the_section_forces(
    stack: list[tuple[float, float]], strains: list[float], T_N: float, T_M: float
) -> None:
    """N = integral sigma dz, M = -integral z sigma dz; Simpson's rule is exact for the quadratic z sigma."""
    laminate, strain = laminate_of(stack, offset=3e-4), np.array(strains)
    N, M = np.zeros(3), np.zeros(3)
    for k in range(len(stack)):
        bottom, top = laminate.z[k : k + 2]
        rule = (("bottom", bottom, 1 / 6), ("middle", (bottom + top) / 2, 4 / 6), ("top", top, 1 / 6))
        for surface, z, weight in rule:
            sigma = ply_stress(laminate, strain, k, surface, T_N=T_N, T_M=T_M)  # type: ignore[arg-type]
            N += (top - bottom) * weight * sigma
            M -= (top - bottom) * weight * z * sigma
    largest = 1e-12 * 200e9 * (1e-2 + 1e-2 * laminate.h + 1e-2) * laminate.h  # rounding of stresses of this size
    np.testing.assert_allclose(section_forces(laminate, strain, T_N, T_M), [*N, *M], rtol=1e-9, atol=largest)


def test_free_heated_sheet_expands_without_force() -> None:
    laminate = Laminate(STEEL, thickness=2e-3)
    strains = np.array(
        [12e-6 * 50, 12e-6 * 50, 0, -12e-6 * 3e3, -12e-6 * 3e3, 0]
    )  # E(z) = alpha (T_N + z T_M) needs kap = -alpha T_M
    forces = section_forces(laminate, strains, T_N=50.0, T_M=3e3)
    assert np.abs(forces).max() < 1e-12 * laminate.A[0, 0]


def test_thermal_resultants_of_many_points() -> None:
    laminate = Laminate(HOT, (0, 90), 2e-3)
    T_N, T_M = np.array([10.0, 0.0]), np.array([0.0, 500.0])
    N_T, M_T = thermal_resultants(laminate, T_N, T_M)
    assert N_T.shape == M_T.shape == (2, 3)
    stress = np.einsum("kij,kj->ki", laminate.Dk, laminate.alpha)  # plies of 1 mm at z = -0.5 and 0.5 mm
    np.testing.assert_allclose(N_T[0], 10.0 * 1e-3 * stress.sum(0), rtol=1e-12)
    np.testing.assert_allclose(M_T[0], 10.0 * 0.5e-6 * (stress[1] - stress[0]), rtol=1e-12, atol=1e-15)
    np.testing.assert_allclose(M_T[1], 500.0 * 1e-9 / 3 * stress.sum(0), rtol=1e-12)


def test_ways_to_give_the_same_stack() -> None:
    equal = Laminate(HOT, (0, 90), 2e-3)
    each = Laminate(HOT, (0, "90 deg"), ("1 mm", 1e-3))  # type: ignore[arg-type]
    plies = Laminate(plies=(Ply(HOT, 0, thickness=1e-3), Ply(HOT, 90, thickness=1e-3)))
    as_in_file = Laminate(
        ply={
            "E1": "181 GPa",
            "E2": "10.3 GPa",
            "G12": "7.17 GPa",
            "nu12": 0.28,
            "rho": 1600,
            "alpha1": 0.02e-6,
            "alpha2": 22.5e-6,
        },  # type: ignore[arg-type]
        angles=[0, f"{math.pi / 2} rad"],  # type: ignore[arg-type]
        thickness="2 mm",  # type: ignore[arg-type]
    )
    for other in (each, plies, as_in_file):
        np.testing.assert_allclose(other.stiffness, equal.stiffness, rtol=1e-12, atol=1e-6)  # 90 deg and pi/2 differ by rounding
        assert other.h == pytest.approx(2e-3)


def test_sandwich_of_two_materials_from_a_file() -> None:
    face = {"material": {"E": "70 GPa", "nu": 0.33, "rho": 2700}, "thickness": "0.5 mm"}
    core = {"material": {"E": "70 MPa", "nu": 0.3, "rho": 50}, "thickness": "10 mm"}
    laminate = Laminate(plies=[face, core, face])  # type: ignore[arg-type]
    assert laminate.h == pytest.approx(11e-3)
    assert laminate.mass_per_area == pytest.approx(2 * 2700 * 0.5e-3 + 50 * 10e-3)
    np.testing.assert_allclose(laminate.z, [-5.5e-3, -5e-3, 5e-3, 5.5e-3])


def test_arrays_cannot_be_changed_and_are_made_once() -> None:
    laminate = Laminate(HOT, (0, 90), 2e-3)
    assert laminate.A is laminate.A
    for array in (laminate.A, laminate.B, laminate.D, laminate.Dk, laminate.z, laminate.stiffness, laminate.alpha):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 0.0


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"ply": T300, "thickness": 0}, r"Laminate: thickness\.total = 0; accepted is a value greater than 0"),
        ({"ply": T300, "thickness": -1e-3}, r"thickness\.total = -0\.001; accepted is a value greater than 0"),
        ({"ply": T300, "angles": (0, 90), "thickness": (1e-3, 0)}, r"thickness\.each\.1 = 0; accepted is a value greater than 0"),
        (
            {"ply": T300, "angles": (0, 90), "thickness": (1, 2, 3)},
            "3 thicknesses for 2 angles; accepted is one thickness per angle",
        ),
        (
            {"ply": T300, "thickness": 1e-3, "offset": -2},
            "offset = -2 m; accepted is at most 1000 times the thickness of 0.001 m",
        ),
        ({"ply": T300, "thickness": math.nan}, "nan is not finite; accepted is a number in m"),
        ({"ply": T300, "thickness": "2 kg"}, "'2 kg' has the unit kg, which does not convert to m"),
        ({"ply": T300}, "'thickness' is missing; accepted is the total thickness"),
        ({"ply": T300, "angles": (), "thickness": 1}, "no ply in angles; accepted is at least one"),
        ({"ply": T300, "angles": ("1 mm",), "thickness": 1}, r"angles\.0 = '1 mm'; .*accepted is a number in deg"),
        ({"ply": 5, "thickness": 1}, "ply = 5; accepted is a Lamina .* or an Isotropic"),
        ({"ply": {"E": -1, "nu": 0.3, "rho": 1}, "thickness": 1}, r"ply\.isotropic\.E = -1; accepted is a value greater than 0"),
        ({"ply": {"E1": 1, "E2": 1, "G12": 1, "rho": 1}, "thickness": 1}, r"'ply\.lamina\.nu12' is missing"),
        ({"thickness": 1}, "no ply; accepted is ply with angles and thickness, or plies"),
        ({"plies": ()}, "no ply in plies; accepted is at least one"),
        ({"ply": T300, "plies": (Ply(T300, thickness=1),)}, "'plies' stands alone"),
        ({"plies": (Ply(T300, thickness=1),), "thickness": 1}, "'plies' stands alone"),
        ({"ply": T300, "thickness": 1, "ofset": 2}, "unknown argument 'ofset'"),
    ],
)
def test_impossible_laminates_are_refused(arguments: dict[str, object], message: str) -> None:
    with pytest.raises(DeclarationError, match=message):
        Laminate(**arguments)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"E1": 0}, "Lamina: E1 = 0; accepted is a value greater than 0"),
        ({"G12": -1}, "Lamina: G12 = -1; accepted is a value greater than 0"),
        ({"rho": 0}, "Lamina: rho = 0; accepted is a value greater than 0"),
        ({"E2": math.inf}, "inf is not finite"),
        ({"nu12": math.nan}, "nan is not finite"),
        ({"nu12": 1.5}, r"nu12 = 1\.5; accepted is abs\(nu12\) < sqrt\(E1 / E2\) = 1\.326"),
        ({"nu12": -1.5}, r"nu12 = -1\.5; accepted is abs"),
        ({"Xt": -5}, "Lamina: Xt = -5; accepted is a value greater than 0"),
    ],
)
def test_impossible_plies_are_refused(changed: dict[str, float], message: str) -> None:
    with pytest.raises(DeclarationError, match=message):
        Lamina(**{"E1": 181e9, "E2": 103e9, "G12": 7.7e9, "nu12": 0.28, "rho": 1560, **changed})


@pytest.mark.parametrize("nu", [-1.0, 0.51, 3.0])
def test_impossible_poisson_ratio_is_refused(nu: float) -> None:
    with pytest.raises(DeclarationError, match=r"Isotropic: nu = .*; accepted is a value greater than -1 and at most 0\.5"):
        Isotropic(E=1e9, nu=nu, rho=1)


def test_incompressible_sheet_is_accepted() -> None:
    assert pytest.approx(1e9 / 3) == Isotropic(E=1e9, nu=0.5, rho=1).G
