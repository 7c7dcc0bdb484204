"""What the two definitions of curvature and the reduced rule for in-plane forces mean, and which rules are refused."""

from __future__ import annotations

import numpy as np
import pytest
from shell_patch import SURFACES, dense, gathered_force, patch, section

import lamella as lm
from lamella.element import ELEMENTS
from lamella.element.packing import unpacked
from lamella.element.plate48.block import ShellBlock
from lamella.element.plate48.layout import gauss_tables
from lamella.element.plate48.recovery import ShellRecovery
from lamella.element.plate48.section import Section
from lamella.element.plate48.shape import shape_at_gauss_points
from lamella.element.plate48.surface import derivatives_at_points, reference_surface
from lamella.errors import DeclarationError, ModelError

PLATE48 = ELEMENTS["plate48"]
PLY = lm.Lamina(E1=181e9, E2=10.3e9, G12=7.17e9, nu12=0.28, rho=1600)
UNSYMMETRIC = lm.Laminate(PLY, angles=(0, 30, -70), thickness=(1e-3, 2e-3, 1.5e-3)).stiffness
SHEET = lm.Laminate(lm.Isotropic(E=70e9, nu=0.3, rho=2700), thickness=0.02).stiffness


@pytest.fixture
def rng():
    return np.random.default_rng(3)


# --- curvature --------------------------------------------------------------------------------------


def recovered(mesh, q, curvature):
    """Strains of both kinds at random points of all elements."""
    xi, eta = np.random.default_rng(1).random((2, len(mesh.coords)))
    return ShellRecovery(PLATE48, *mesh.tables, curvature=curvature).at(q, np.arange(len(mesh.coords)), xi, eta).strains


@pytest.mark.parametrize("surface", list(SURFACES))
def test_definitions_differ_by_the_square_of_the_stretch_of_area(rng, surface):
    """(kap + B)_cubed (J/J0)^2 = (kap + B)_unit, with (J/J0)^2 = det(I + 2 E) of the membrane strain."""
    mesh = patch(PLATE48, [0.0, 0.5, 1.2], [0.0, 0.4, 1.0], SURFACES[surface])
    q = 1.2 * mesh.rest + 0.02 * rng.standard_normal(mesh.rest.shape)
    unit, cubed = (recovered(mesh, q, name) for name in ("unit_normal", "cubed_normal"))
    np.testing.assert_array_equal(unit[:, :3], cubed[:, :3])
    # of a surface shrunk to a point nothing but -B is left in the unit definition: its curvature goes with the size
    B = -recovered(mesh, 1e-9 * mesh.rest, "unit_normal")[:, 3:]
    eps = unit[:, :3]
    squared = (1 + 2 * eps[:, 0]) * (1 + 2 * eps[:, 1]) - eps[:, 2] ** 2
    assert squared.min() > 1.5  # it stretches
    np.testing.assert_allclose((cubed[:, 3:] + B) * squared[:, None], unit[:, 3:] + B, atol=1e-7)


@pytest.mark.parametrize("curvature", ["unit_normal", "cubed_normal"])
@pytest.mark.parametrize("by_element", [False, True])
def test_the_constants_that_kernels_read_are_those_of_section_and_surface(rng, curvature, by_element):
    mesh = patch(PLATE48, [0.0, 0.5, 1.2, 1.9], [0.0, 0.4, 1.0, 1.7], SURFACES["cylinder"])
    n = len(mesh.coords)
    C = np.stack([section(rng) for _ in range(n)]) if by_element else section(rng)
    block = ShellBlock("strip", *mesh.tables, Section(C, curvature=curvature))
    (tables,) = gauss_tables(block, Section(C, curvature=curvature), 3)
    surface = reference_surface("strip", derivatives_at_points(shape_at_gauss_points(PLATE48, 3), block.rest))
    numbers = unpacked(tables.sections, n).reshape(n, 9, 27)
    upper = tables.stiffness[..., *np.triu_indices(6)]
    np.testing.assert_allclose(numbers[..., :21], upper, rtol=1e-12, atol=1e-12 * np.abs(upper).max())
    np.testing.assert_array_equal(numbers[..., 21:], surface.constants(True if curvature == "cubed_normal" else None))


def test_definitions_agree_without_stretch():
    """A flat strip bent on a cylinder: bending energies differ as J^-4, by what is left of membrane strain on the mesh."""
    xs, ys = np.linspace(0.0, 2.0, 9), [0.0, 0.5]
    flat, bent = patch(PLATE48, xs, ys), patch(PLATE48, xs, ys, SURFACES["cylinder"])
    C = np.zeros((6, 6))
    C[3:, 3:] = SHEET[3:, 3:]
    unit, cubed = (
        ShellBlock("strip", *flat.tables, Section(C, curvature=name)).energy(0.0, bent.rest)
        for name in ("unit_normal", "cubed_normal")
    )
    xi = np.linspace(0.0, 1.0, 101)
    eps = ShellRecovery(PLATE48, *flat.tables).at(bent.rest, np.zeros(101, int), xi, 0.5 * np.ones(101)).strains[:, 0]
    assert 0 < np.abs(eps).max() < 1e-4
    assert (1 + 2 * eps.max()) ** -2 < cubed / unit < (1 + 2 * eps.min()) ** -2
    assert unit == pytest.approx(0.5 * C[3, 3] / 1.3**2 * 2.0 * 0.5, rel=1e-3)


def test_pictures_and_stresses_take_the_curvature_of_the_plate():
    sheet = lm.Laminate(lm.Isotropic(E=70e9, nu=0.3, rho=2700), thickness=0.02)

    def curvatures(curvature):
        system = lm.System()
        system.add(lm.Plate("wing", (2.0, 0.5), (4, 1), sheet, curvature=curvature))
        model = system.compile()
        q = 1.5 * patch(PLATE48, np.linspace(0.0, 2.0, 5), [0.0, 0.5], SURFACES["cylinder"]).rest
        return model.plates[0].sample(q).strains[..., 3]

    np.testing.assert_allclose(curvatures("unit_normal"), 1.5 / 1.3, rtol=2e-2)  # cubics bend unevenly, 1 / 32 of (l/R)^2
    np.testing.assert_allclose(curvatures("cubed_normal"), 1.5**-3 / 1.3, rtol=2e-2)


def test_tangents_at_the_reference_differ_only_where_it_is_curved_or_stressed():
    def tangents(surface, **options):
        mesh = patch(PLATE48, [0.0, 0.5, 1.2], [0.0, 0.4], SURFACES[surface])
        sections = (Section(UNSYMMETRIC, curvature=name, **options) for name in ("unit_normal", "cubed_normal"))
        return (dense(ShellBlock("p", *mesh.tables, material), mesh.rest)[1] for material in sections)

    unit, cubed = tangents("flat")
    np.testing.assert_allclose(cubed, unit, atol=1e-13 * np.abs(unit).max())
    for surface, options in (("cylinder", {}), ("flat", {"prestrain": np.array([1e-3, 0.0, 0.0])})):
        unit, cubed = tangents(surface, **options)
        assert np.abs(cubed - unit).max() > 1e-7 * np.abs(unit).max()


# --- integration --------------------------------------------------------------------------------------


def test_parts_of_a_section_add_up_and_are_never_negative():
    whole = Section(UNSYMMETRIC, membrane_gauss=3)
    (bending, n), (in_plane, fewer) = whole.parts(4)
    assert (n, fewer) == (4, 3)
    scale = np.sqrt(np.diag(UNSYMMETRIC))
    for part in (bending, in_plane):
        eigenvalues = np.linalg.eigvalsh(part.stiffness / scale / scale[:, None])
        assert eigenvalues[:3] == pytest.approx(0.0, abs=1e-14)
        assert eigenvalues[3] > 1e-3
    np.testing.assert_allclose(bending.stiffness + in_plane.stiffness, UNSYMMETRIC, rtol=1e-15)
    (bending, _), (in_plane, _) = Section(SHEET, membrane_gauss=3).parts(4)
    assert not bending.stiffness[:3].any()
    assert not in_plane.stiffness[3:].any()


def test_as_many_points_as_for_the_rest_is_one_rule(rng):
    mesh, C = patch(PLATE48, [0.0, 0.5, 1.2], [0.0, 0.4], SURFACES["twisted"]), section(rng)
    q = mesh.rest + 0.05 * rng.standard_normal(mesh.rest.shape)
    same, one, fewer = (gathered_force(ShellBlock("p", *mesh.tables, Section(C, membrane_gauss=n), 4), q) for n in (4, None, 3))
    np.testing.assert_array_equal(same, one)
    assert np.abs(fewer - one).max() > 1e-6 * np.abs(one).max()


def zero_modes(mesh, *blocks):
    """Number of motions without energy at the reference, in scaled coordinates; there is a wide gap above rounding."""
    scale = np.zeros(len(mesh.rest))
    scale[mesh.coords] = mesh.scale
    K = sum(dense(block, mesh.rest)[1] for block in blocks) / scale / scale[:, None]
    values = np.abs(np.linalg.eigvalsh(K))
    number = int((values < 1e-13 * values.max()).sum())
    assert values[np.argsort(values)][number] > 1e-9 * values.max()
    return number


@pytest.mark.parametrize("surface", ["flat", "cylinder", "twisted"])
@pytest.mark.parametrize("counts", [(2, 1), (1, 2), (6, 1), (3, 3)])
def test_free_plates_have_six_motions_without_energy(surface, counts):
    mesh = patch(PLATE48, np.linspace(0, 1.5, counts[0] + 1), np.linspace(0, 1, counts[1] + 1), SURFACES[surface])
    for n_gauss, fewer in ((4, 3), (5, 3), (5, 4), (3, None)):
        assert zero_modes(mesh, ShellBlock("p", *mesh.tables, Section(SHEET, membrane_gauss=fewer), n_gauss)) == 6


def test_why_smaller_rules_are_refused():
    """3 x 3 points have 27 strains for the 29 deformations of one element in its plane; 2 x 2 leave 21 motions on any mesh."""

    def number(counts, points):
        mesh = patch(PLATE48, np.linspace(0, 1.5, counts[0] + 1), np.linspace(0, 1, counts[1] + 1))
        (bending, _), (in_plane, _) = Section(SHEET, membrane_gauss=points).parts(4)
        return zero_modes(mesh, ShellBlock("p", *mesh.tables, bending, 4), ShellBlock("p", *mesh.tables, in_plane, points))

    assert number((1, 1), 3) == 6 + 3
    assert number((3, 3), 2) == number((5, 4), 2) == 6 + 21


def test_rules_and_definitions_that_do_not_exist_are_refused_with_one_message():
    mesh = patch(PLATE48, [0.0, 1.0, 2.0], [0.0, 1.0])

    def block(n_gauss=4, stiffness=SHEET, **options):
        return ShellBlock("wing", *mesh.tables, Section(stiffness, **options), n_gauss)

    with pytest.raises(ModelError, match="wing: membrane_gauss = 2 with n_gauss = 4; accepted is 3 to n_gauss"):
        block(membrane_gauss=2)
    with pytest.raises(ModelError, match="wing: membrane_gauss = 4 with n_gauss = 3; accepted is 3 to n_gauss"):
        block(3, membrane_gauss=4)
    with pytest.raises(ModelError, match="wing: curvature = 'none'; accepted is unit_normal or cubed_normal"):
        block(curvature="none")
    with pytest.raises(ModelError, match="wing: the membrane stiffness A is singular, which membrane_gauss = 3 cannot split"):
        block(stiffness=np.diag([0.0, 1.0, 1.0, 1.0, 1.0, 1.0]), membrane_gauss=3)


def test_plates_refuse_rules_that_leave_motions_without_stiffness():
    sheet = lm.Laminate(lm.Isotropic(E=70e9, nu=0.3, rho=2700), thickness=0.02)
    with pytest.raises(DeclarationError, match="Plate 'wing': membrane_gauss = 4 with n_gauss = 3; accepted is a number up to 3"):
        lm.Plate("wing", (1.0, 1.0), (2, 2), sheet, n_gauss=3, membrane_gauss=4)
    with pytest.raises(DeclarationError, match="Plate 'wing': membrane_gauss = 3 on a single element"):
        lm.Plate("wing", (1.0, 1.0), (1, 1), sheet, membrane_gauss=3)
    with pytest.raises(DeclarationError, match="membrane_gauss"):
        lm.Plate("wing", (1.0, 1.0), (2, 2), sheet, membrane_gauss=2)
    assert lm.Plate("wing", (1.0, 1.0), (1, 1), sheet, membrane_gauss=4).membrane_gauss == 4
