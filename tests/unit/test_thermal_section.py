"""Thermal data of plies and sections: closed forms, invariants, signs, and messages for what is missing."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import lamella as lm
from lamella.errors import DeclarationError
from lamella.material.isotropic import Isotropic
from lamella.material.lamina import Lamina, conductivities
from lamella.material.laminate import Laminate, Ply, thermal_resultants
from lamella.material.recovery import Surface, ply_stress, section_forces

CARBON = Lamina(
    E1=181e9, E2=10.3e9, G12=7.17e9, nu12=0.28, rho=1600, alpha1=-0.5e-6, alpha2=22.5e-6, k1=5.0, k2=0.7, k3=0.5, c=900.0
)
SHEET = Isotropic(E=1.93e9, nu=0.3, rho=36.8, alpha=2.3e-5, k=1.5, c=921.0)
h = 0.0103

angles = st.floats(-180, 180)
stacks = st.lists(st.tuples(angles, st.floats(1e-4, 1e-2)), min_size=1, max_size=6)


def laminate_of(stack: list[tuple[float, float]], **options: float) -> Laminate:
    return Laminate(CARBON, tuple(angle for angle, _ in stack), tuple(thickness for _, thickness in stack), **options)


def test_isotropic_sheet_has_the_closed_forms() -> None:
    """N_T = E h alpha T_N / (1 - nu), M_T = E h^3 alpha T_M / (12 (1 - nu)); rho c h, rho c h^3 / 12; k h, k h^3 / 12."""
    sheet = Laminate(SHEET, thickness=h)
    stress = SHEET.E * SHEET.alpha / (1 - SHEET.nu) * np.array([1, 1, 0])
    moments = np.array([h, 0.0, h**3 / 12])
    rounding = {"rtol": 1e-13, "atol": 1e-15 * h}  # z is known to 1e-16 h, and the odd moment is a difference of its squares
    np.testing.assert_allclose(sheet.thermal_moments, np.outer(moments, stress), rtol=1e-13, atol=1e-15 * h * stress[0])
    np.testing.assert_allclose(sheet.heat_capacity / (SHEET.rho * SHEET.c), moments, **rounding)
    np.testing.assert_allclose(sheet.conductivity / 1.5, np.einsum("p,ij->pij", moments, np.eye(2)), **rounding)
    assert sheet.conductivity_through == pytest.approx(1.5 * h, rel=1e-14)


def test_offset_shifts_the_moments() -> None:
    """Steiner: the moments about a surface a distance d below the middle are h, h d and h^3/12 + h d^2."""
    sheet, d = Laminate(SHEET, thickness=h, offset=0.02), 0.02
    moments = np.array([h, h * d, h**3 / 12 + h * d**2])
    np.testing.assert_allclose(sheet.heat_capacity, SHEET.rho * SHEET.c * moments, rtol=1e-12)
    np.testing.assert_allclose(sheet.conductivity[:, 0, 0], 1.5 * moments, rtol=1e-12)
    np.testing.assert_allclose(sheet.thermal_moments[:, 0], SHEET.E * SHEET.alpha / (1 - SHEET.nu) * moments, rtol=1e-12)


def test_sandwich_sums_its_layers() -> None:
    """Conduction through the thickness takes the arithmetic mean: the temperature is linear in z."""
    face, core = Isotropic(E=70e9, nu=0.3, rho=2700, k=200.0, c=900.0), Isotropic(E=1e6, nu=0.3, rho=50, k=0.05, c=1200.0)
    t, b = 1e-3, 20e-3
    section = Laminate(plies=(Ply(face, thickness=t), Ply(core, thickness=b), Ply(face, thickness=t)))
    assert section.heat_capacity[0] == pytest.approx(2 * 2700 * 900 * t + 50 * 1200 * b, rel=1e-13)
    outer = (b / 2 + t) ** 3 - (b / 2) ** 3
    expected = 2 / 3 * (2700 * 900 * outer + 50 * 1200 * (b / 2) ** 3)
    assert section.heat_capacity[2] == pytest.approx(expected, rel=1e-12)
    assert section.conductivity[0, 0, 0] == pytest.approx(2 * 200 * t + 0.05 * b, rel=1e-13)
    assert section.conductivity_through == pytest.approx(2 * 200 * t + 0.05 * b, rel=1e-13)


@given(stacks)
def test_symmetric_laminate_does_not_couple(stack: list[tuple[float, float]]) -> None:
    section = laminate_of([*stack, *stack[::-1]])
    for moments in (section.thermal_moments, section.heat_capacity, section.conductivity):
        assert np.abs(moments[1]).max() <= 1e-14 * section.h * np.abs(moments[0]).max()  # z is known to 1e-16 h


def test_cross_ply_bends_with_opposite_signs() -> None:
    """[0/90]: the plies exchange x and y, and Dk alpha_k is larger along the fibres' transverse direction."""
    section = Laminate(CARBON, (0, 90), 2e-3)
    a1, k1 = section.thermal_moments[1], section.conductivity[1]
    nu21 = CARBON.nu12 * CARBON.E2 / CARBON.E1
    along = CARBON.E1 * (CARBON.alpha1 + nu21 * CARBON.alpha2) / (1 - CARBON.nu12 * nu21)
    across = CARBON.E2 * (CARBON.nu12 * CARBON.alpha1 + CARBON.alpha2) / (1 - CARBON.nu12 * nu21)
    moment = (1e-3) ** 2 / 2 * (across - along)  # the upper ply has its transverse direction along x
    np.testing.assert_allclose(a1, [moment, -moment, 0], rtol=1e-12, atol=1e-12 * abs(moment))
    np.testing.assert_allclose(k1, (1e-3) ** 2 / 2 * np.diag([0.7 - 5.0, 5.0 - 0.7]), atol=1e-20)
    assert section.conductivity_through == pytest.approx(0.5 * 2e-3)


@given(stacks, angles)
def test_conductivity_turns_as_a_tensor(stack: list[tuple[float, float]], turn: float) -> None:
    c, s = math.cos(math.radians(turn)), math.sin(math.radians(turn))
    R = np.array([[c, -s], [s, c]])
    section, turned = laminate_of(stack), laminate_of([(angle + turn, thickness) for angle, thickness in stack])
    for before, after, size in zip(section.conductivity, turned.conductivity, (1, section.h, section.h**2), strict=True):
        np.testing.assert_allclose(after, R @ before @ R.T, atol=1e-13 * 5.0 * section.h * size)
    np.testing.assert_allclose(section.conductivity[0], section.conductivity[0].T)
    assert np.linalg.eigvalsh(section.conductivity[0]).min() >= 0.7 * section.h * (1 - 1e-13)


@given(stacks)
def test_quarter_turn_exchanges_the_axes(stack: list[tuple[float, float]]) -> None:
    section, turned = laminate_of(stack), laminate_of([(angle + 90, thickness) for angle, thickness in stack])
    exchanged = section.thermal_moments[:, [1, 0, 2]] * [1, 1, -1]
    size = np.abs(section.thermal_moments).max(axis=1, keepdims=True) + section.h * np.abs(section.thermal_moments[0]).max()
    assert (np.abs(turned.thermal_moments - exchanged) <= 1e-12 * size).all()
    for before, after in zip(section.conductivity, turned.conductivity, strict=True):
        np.testing.assert_allclose(after[[1, 0]][:, [1, 0]] * [[1, -1], [-1, 1]], before, atol=1e-13 * section.h)


@given(stacks, st.floats(0, 2 * math.pi))
def test_free_laminate_deforms_until_its_stresses_balance(stack: list[tuple[float, float]], mixture: float) -> None:
    """[[A, -B], [-B, D]] (eps, kap) = (N_T, -M_T) leaves neither force nor moment, though the plies are stressed."""
    section = laminate_of(stack, offset=2e-4)
    T_N, T_M = 100.0 * math.cos(mixture), 100.0 * math.sin(mixture) / section.h
    N_T, M_T = thermal_resultants(section, T_N, T_M)
    scale = np.repeat([1.0, 1.0 / section.h], 3)  # balances membrane and bending, else the solution loses ten digits
    strains = scale * np.linalg.solve(scale[:, None] * section.stiffness * scale, scale * np.concatenate([N_T, -M_T]))
    N, M = np.zeros(3), np.zeros(3)
    for k in range(len(stack)):
        bottom, top = section.z[k : k + 2]
        rule: tuple[tuple[Surface, float, float], ...] = (
            ("bottom", bottom, 1 / 6),
            ("middle", (bottom + top) / 2, 4 / 6),
            ("top", top, 1 / 6),
        )
        for surface, z, weight in rule:  # Simpson's rule is exact for the quadratic z sigma
            sigma = ply_stress(section, strains, k, surface, T_N=T_N, T_M=T_M)
            N += (top - bottom) * weight * sigma
            M -= (top - bottom) * weight * z * sigma
    size = 181e9 * 22.5e-6 * 100.0 * section.h  # of the parts that balance
    assert np.abs(N).max() <= 1e-10 * size
    assert np.abs(M).max() <= 1e-10 * size * (section.h + 2e-4)
    np.testing.assert_allclose(section_forces(section, strains, T_N, T_M)[:3], N, atol=1e-10 * size)


def test_sample_recovers_stress_less_thermal_strain() -> None:
    """A plate at rest that is heated and held: sigma = -E alpha dT / (1 - nu) at each height, von Mises its size."""
    material = dataclasses.replace(SHEET, strength=1e7)
    system = lm.System()
    plate = system.add(lm.Plate("plate", (1.0, 0.5), (2, 1), Laminate(material, thickness=h)))
    system.add(lm.Clamp("root", plate.edge("x-")))
    model = system.compile()
    held = dataclasses.replace(model.plates[0].sample(model.q0, per_element=1), T_N=np.full((2, 3), 40.0), T_M=150.0)
    for surface, z in (("bottom", -h / 2), ("middle", 0.0), ("top", h / 2)):
        stress = -SHEET.E * SHEET.alpha / (1 - SHEET.nu) * (40.0 + 150.0 * z)
        np.testing.assert_allclose(held.stress(0, surface)[..., :2], stress, rtol=1e-10)
        np.testing.assert_allclose(held.von_mises(0, surface), abs(stress), rtol=1e-10)
        np.testing.assert_allclose(held.failure_index(0, surface, "tsai-hill"), (stress / 1e7) ** 2, rtol=1e-10)
    resultant, moment = held.section_forces()[..., 0], held.section_forces()[..., 3]
    np.testing.assert_allclose(resultant, -SHEET.E * h * SHEET.alpha * 40.0 / (1 - SHEET.nu), rtol=1e-10)
    np.testing.assert_allclose(moment, SHEET.E * h**3 * SHEET.alpha * 150.0 / (12 * (1 - SHEET.nu)), rtol=1e-9)


def test_units_of_a_model_file() -> None:
    given = {"E1": 1e9, "E2": 1e9, "G12": 1e9, "nu12": 0.3, "rho": 1e3}
    ply = Lamina(**given, k1="4 W/(m K)", k2="500 mW/m/K", c="0.9 kJ/(kg K)", alpha1="-0.5 ppm/K")  # type: ignore[arg-type]
    assert (ply.k1, ply.k2, ply.c, ply.alpha1) == pytest.approx((4.0, 0.5, 900.0, -0.5e-6))
    assert conductivities(ply) == (4.0, 0.5, 0.5)
    assert conductivities(CARBON).k3 == 0.5
    assert conductivities(SHEET.lamina) == (1.5, 1.5, 1.5)


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"k1": 0}, "Lamina: k1 = 0; accepted is a value greater than 0"),
        ({"k2": -1}, "Lamina: k2 = -1; accepted is a value greater than 0"),
        ({"k3": -0.1}, r"Lamina: k3 = -0\.1; accepted is a value greater than 0"),
        ({"c": 0.0}, r"Lamina: c = 0\.0; accepted is a value greater than 0"),
        ({"c": math.nan}, r"nan is not finite; accepted is a number in J/\(kg\*K\)"),
        ({"alpha2": math.inf}, "inf is not finite; accepted is a number in 1/K"),
        ({"k1": "1 W/m"}, r"'1 W/m' has the unit .*, which does not convert to W/\(m\*K\)"),
        ({"k2": None}, "k1 = 5 and k3 = 0.5 alone; accepted are k1 along and k2 across the fibres together"),
        ({"k1": None, "k2": None}, "k3 = 0.5 alone; accepted are k1"),
        ({"k1": None, "k3": None}, "k2 = 0.7 alone; accepted are k1"),
    ],
)
def test_impossible_thermal_data_are_refused(changed: dict[str, object], message: str) -> None:
    with pytest.raises(DeclarationError, match=message):
        Lamina(**{**{field.name: getattr(CARBON, field.name) for field in dataclasses.fields(CARBON)}, **changed})


@pytest.mark.parametrize(("name", "value"), [("k", -1.0), ("k", 0.0), ("c", -5.0), ("c", 0.0)])
def test_impossible_thermal_data_of_a_sheet_are_refused(name: str, value: float) -> None:
    with pytest.raises(DeclarationError, match=f"Isotropic: {name} = {value}; accepted is a value greater than 0"):
        Isotropic(E=1e9, nu=0.3, rho=1e3, **{name: value})


def test_missing_data_are_named_with_their_ply() -> None:
    cold = dataclasses.replace(CARBON, k1=None, k2=None, k3=None, c=None)
    section = Laminate(plies=(Ply(CARBON, thickness=1e-3), Ply(cold, thickness=1e-3)))
    for datum in ("conductivity", "conductivity_through"):
        with pytest.raises(DeclarationError, match=r"Lamina of ply 1 .*thermal conductivity, which is not given; accepted are"):
            getattr(section, datum)
    with pytest.raises(DeclarationError, match=r"Lamina of ply 1 .*the specific heat c, which is not given; accepted is"):
        _ = section.heat_capacity
    with pytest.raises(DeclarationError, match=r"Isotropic of ply 0 .*thermal conductivity"):
        _ = Laminate(Isotropic(E=1e9, nu=0.3, rho=1e3), thickness=1e-3).conductivity
