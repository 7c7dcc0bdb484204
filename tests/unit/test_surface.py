"""Reference surfaces: slopes are derivatives, ends meet, and what makes no surface is refused."""

from __future__ import annotations

import numpy as np
import pytest

import lamella as lm
from lamella.errors import DeclarationError, ModelError

RING = [(np.cos(a), np.sin(a)) for a in np.linspace(0.0, 2.0 * np.pi, 24, endpoint=False)]
SURFACES = {
    "cylinder": lm.CylinderSurface(radius=0.7, length=1.2, angle=(0.2, 1.9)),
    "belt": lm.BeltSurface(length=2.5, width=0.8),
    "cone": lm.ConeSurface(radii=(0.5, 0.9), height=1.1, angle=(-0.4, 1.0)),
    "sphere": lm.SphereSurface(radius=1.3, latitude=(-0.3, 1.1), angle=(0.0, 2.0)),
    "annulus": lm.AnnulusSurface(radii=(0.6, 1.0), closed=True),
    "pulleys": lm.PulleySurface(pulleys=[(0, 0, 0.1), (1.0, 0.1, 0.3), (0.4, 0.8, 0.2)], width=0.5),
    "points": lm.PointSurface([[(u, v, 0.1 * u * u - 0.2 * u * v) for u in np.linspace(0, 1, 7)] for v in np.linspace(0, 2, 6)]),
    "tube": lm.PointSurface([[(x, y, z) for x, y in RING] for z in (0.0, 0.4, 0.8)], closed="x"),
    "function": lm.FunctionSurface(lambda x, y: np.stack([x, y, 0.2 * np.sin(2 * x) * np.cos(y)], axis=1), lengths=(1.5, 1.0)),
}


@pytest.fixture(params=list(SURFACES))
def surface(request):
    return SURFACES[request.param]


def test_slopes_are_the_derivatives_of_the_position(surface):
    (l_x, l_y), h = surface.size, 1e-5
    x, y = np.array([0.3, 0.5, 0.8]) * l_x, np.array([0.4, 0.7, 0.2]) * l_y
    at = surface.at(x, y)
    np.testing.assert_allclose(at.r_x, (surface.at(x + h, y).r - surface.at(x - h, y).r) / (2 * h), atol=1e-8)
    np.testing.assert_allclose(at.r_y, (surface.at(x, y + h).r - surface.at(x, y - h).r) / (2 * h), atol=1e-8)
    np.testing.assert_allclose(at.r_xy, (surface.at(x, y + h).r_x - surface.at(x, y - h).r_x) / (2 * h), atol=1e-8)


def test_closed_surfaces_end_as_they_begin(surface):
    for axis in (0, 1):
        if surface.loops[axis]:
            inner = np.array([0.1, 0.6]) * surface.size[1 - axis]
            ends = [surface.at(*((np.full(2, end), inner)[:: 1 if axis == 0 else -1])) for end in (0.0, surface.size[axis])]
            for name in ("r", "r_x", "r_y", "r_xy"):
                np.testing.assert_allclose(getattr(ends[1], name), getattr(ends[0], name), atol=1e-9)


def test_parameters_are_arc_lengths_where_it_is_said():
    for name, place in (("cylinder", 0.4), ("belt", 0.2), ("pulleys", 0.2), ("sphere", 0.3 * 1.3)):  # the sphere at its equator
        at = SURFACES[name].at(np.array([0.3]), np.array([place]))
        assert np.linalg.norm(at.r_x) == pytest.approx(1.0, abs=1e-12)
        assert np.linalg.norm(at.r_y) == pytest.approx(1.0, abs=1e-12)


def test_normals_point_outward_and_up():
    for name in ("cylinder", "belt", "cone", "sphere"):
        at = SURFACES[name].at(np.array([0.3]), np.array([0.4]))
        assert np.cross(at.r_x, at.r_y)[0] @ (at.r[0] * [1, 1, 0]) > 0.0
    at = SURFACES["annulus"].at(np.array([0.1]), np.array([0.4]))
    np.testing.assert_allclose(np.cross(at.r_x, at.r_y)[0, :2], 0.0, atol=1e-15)
    assert np.cross(at.r_x, at.r_y)[0, 2] > 0.0


def test_points_of_a_circle_give_the_circle():
    at = SURFACES["tube"].at(np.linspace(0.0, SURFACES["tube"].size[0], 50), np.full(50, 0.3))
    np.testing.assert_allclose(np.hypot(at.r[:, 0], at.r[:, 1]), 1.0, atol=2e-6)  # spline of degree 5: h^6 / 6!
    np.testing.assert_allclose(at.r[:, 2], 0.3, atol=1e-12)


def test_a_belt_around_pulleys():
    """Open and equal: two strands and two half circles. Unequal: the closed form of an open belt drive."""
    assert lm.PulleySurface([(0, 0, 0.1), (0.4, 0, 0.1)], 0.05).size == pytest.approx((0.8 + 0.2 * np.pi, 0.05))
    R, r, d = 0.3, 0.1, 1.0
    beta = np.arcsin((R - r) / d)
    belt = lm.PulleySurface([(0, 0, R), (0, d, r)], 0.05)
    length = 2 * d * np.cos(beta) + np.pi * (R + r) + 2 * beta * (R - r)
    assert belt.size[0] == pytest.approx(length)
    at = belt.at(np.linspace(0.0, length, 201), np.zeros(201))
    apart = np.stack([np.hypot(at.r[:, 0], at.r[:, 1]) - R, np.hypot(at.r[:, 0], at.r[:, 1] - d) - r])
    assert apart.min() == pytest.approx(0.0, abs=1e-12)  # it enters none
    touching = np.abs(apart) < 1e-9
    np.testing.assert_allclose(
        touching.mean(axis=1), [(np.pi + 2 * beta) * R / length, (np.pi - 2 * beta) * r / length], atol=0.02
    )
    outward = np.cross(at.r_x, at.r_y)
    assert (np.sum(outward * (at.r - [0, 0.5, 0]), axis=1) > 0.0).all()


@pytest.mark.parametrize(
    ("make", "said"),
    [
        (lambda: lm.PulleySurface([(0, 0, 0.1)], 0.1), "accepted are two or more"),
        (lambda: lm.PulleySurface([(0, 0, 0.1), (0.15, 0, 0.1)], 0.1), "pulleys 1 and 2 overlap: 0.15 m"),
        (lambda: lm.PulleySurface([(0, 0, 0.1), (0, 1, 0.1), (1, 0, 0.1)], 0.1), "counter-clockwise order"),
        (lambda: lm.CylinderSurface(radius=0.0, length=1.0), "radius = 0"),
        (lambda: lm.CylinderSurface(radius=1.0, length=1.0, angle=(1.0, 0.5)), "an angle that grows"),
        (lambda: lm.CylinderSurface(radius=1.0, length=1.0, angle=(0.0, 7.0)), "up to one turn"),
        (lambda: lm.CylinderSurface(radius=1.0, length=1.0, angle=(0.0, 6.0), closed=True), "its ends do not meet"),
        (lambda: lm.SphereSurface(radius=1.0, latitude=(0.0, np.pi / 2)), "without the poles"),
        (lambda: lm.AnnulusSurface(radii=(1.0, 0.5)), "the inner radius, then the outer"),
        (lambda: lm.PointSurface([[(0, 0, 0), (1, 0, 0)], [(0, 1, 0)]]), "rows of 1 and of 2 points"),
        (lambda: lm.PointSurface([[(0, 0, 0)], [(0, 1, 0)]]), "1 points along x"),
        (lambda: lm.PointSurface([[(0, 0, 0), (0, 0, 0)], [(0, 1, 0), (0, 1, 0)]]), "coincide"),
        (lambda: lm.FunctionSurface(lambda x, y: x, (1.0, 1.0)), "returned the shape"),
        (lambda: lm.FunctionSurface(lambda x, y: np.stack([x, y, np.abs(x - 0.3)], 1), (1.0, 1.0)), "not smooth"),
        (lambda: lm.FunctionSurface(lambda x, y: 1 / 0, (1.0, 1.0)), "the function failed"),
        (lambda: lm.FunctionSurface(lambda x, y: np.stack([x, y, x / 0.0 * 0], 1), (1.0, 1.0)), "not finite"),
    ],
)
@pytest.mark.filterwarnings("ignore::RuntimeWarning")
def test_what_makes_no_surface_is_refused(make, said):
    with pytest.raises(DeclarationError, match=said):
        make()


# --- shells on surfaces ---------------------------------------------------------------------------

SECTION = lm.Laminate(lm.Isotropic(E=1e7, nu=0.3, rho=1000.0), thickness=0.01)


def shell(surface, mesh=(8, 4), **options):
    system = lm.System()
    system.add(lm.Shell("shell", surface, mesh, SECTION, **options))
    return system.compile()


def test_the_mass_of_a_shell_is_that_of_its_area():
    for surface, exact in (
        (SURFACES["belt"], 2.5 * 0.8),
        (SURFACES["cone"], 0.5 * (0.5 + 0.9) * 1.4 * np.hypot(0.4, 1.1)),
        (SURFACES["sphere"], 1.3**2 * 2.0 * (np.sin(1.1) + np.sin(0.3))),
        (SURFACES["annulus"], np.pi * (1.0 - 0.36)),
    ):
        model = shell(surface, (16, 16))
        uniform = np.zeros(model.n_q)
        mesh = model.plates[0]
        uniform[0::3][: len(mesh.is_position)] = mesh.is_position
        assert uniform @ (model.mass @ uniform) / (SECTION.mass_per_area) == pytest.approx(
            exact, rel=1e-4
        )  # cubics for arcs of 23 deg


def test_a_closed_shell_has_no_edge_there():
    belt = lm.Shell("belt", SURFACES["belt"], (12, 2), SECTION)
    with pytest.raises(DeclarationError, match=r"closed along x; its edges are y- and y\+"):
        belt.edge("x-")
    assert len(shell(SURFACES["belt"], (12, 2)).plates[0].edge_nodes("y+")) == 12


def test_bad_shells_are_refused():
    fold = lm.FunctionSurface(lambda x, y: np.stack([x * (1 - x), y, 0 * x], axis=1), (1.0, 1.0))
    with pytest.raises(DeclarationError, match=r"the surface (folds|degenerates).* at x = "):
        shell(fold)
    open_ended = lm.FunctionSurface(lambda x, y: np.stack([x, y, 0 * x], axis=1), (1.0, 1.0), closed="x")
    with pytest.raises(DeclarationError, match=r"its ends do not meet at .* 1 m apart"):
        shell(open_ended)
    with pytest.raises(DeclarationError, match="at least 3"):
        shell(SURFACES["belt"], (2, 1))
    with pytest.raises(ModelError, match=r"the ply direction .* is normal to the surface near"):
        shell(lm.CylinderSurface(1.0, 1.0, angle=(-0.5, 0.5)), (4, 2), ply_direction=(1.0, 0.0, 0.0))
    with pytest.raises(DeclarationError, match="4 rows of 8"):
        shell(SURFACES["cone"], thickness_factors=[[1.0]])
    with pytest.raises(DeclarationError, match="prestrain with the strain model 'linear'"):
        shell(SURFACES["cone"], prestrain=(1e-3, 0, 0), strain="linear")
