"""Modes of free, held, stressed and constrained plates against beam theory and dense eigenvalues."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import linalg, optimize

import lamella as lm
from lamella.assembly.equations import Equations
from lamella.assembly.point import STATIC
from lamella.errors import DeclarationError, ModelError

SECTION = lm.Laminate(lm.Isotropic(E=2e9, nu=0.3, rho=1200.0), thickness=0.02)
E, RHO, H, L, B = 2e9, 1200.0, 0.01, 1.0, 0.1
STRIP = lm.Laminate(lm.Isotropic(E=E, nu=0.0, rho=RHO), thickness=H)


def free_plate(mesh, **changes):
    system = lm.System()
    system.add(lm.Plate("plate", (1.0, 0.8), (mesh, mesh), SECTION, **changes))
    return system


def dense_frequencies(model):
    equations = Equations(model, symmetric=False)
    _, _, k, _ = equations.linearise(equations.start(at_rest=True), STATIC)
    pattern = equations.matrix.pattern
    K, M = pattern.matrix(k.copy()).toarray(), pattern.matrix(equations.matrix.mass).toarray()
    values = linalg.eigh(K, M, eigvals_only=True)
    return np.sign(values) * np.sqrt(np.abs(values)) / (2 * np.pi)


@pytest.mark.parametrize("rotation", [(0, 0, 0), (0.3, 0.2, 0.1), (0, 0, np.pi / 2), (1.0, -2.0, 0.5)])
@pytest.mark.parametrize("mesh", [2, 4])
def test_free_plate_has_six_zero_modes_however_it_is_turned(mesh, rotation):
    model = free_plate(mesh, rotation=rotation, position=(3.0, -2.0, 1.0)).compile()
    found = lm.modes(model, 10).frequencies
    expected = dense_frequencies(model)[:10]
    # eigenvalues have the rounding of the highest one, 1e-16 (40 kHz)^2: 0.5 mHz of a rigid mode
    assert np.abs(found[:6]).max() < 1e-3
    np.testing.assert_allclose(found[6:], expected[6:], rtol=1e-6)


def strip(strain):
    """A strip simply supported at both ends and pulled to the axial strain given by a force along it."""
    system, plate = lm.System(), lm.Plate("strip", (L, B), (6, 1), STRIP)
    system.add(plate)
    system.add(lm.EdgeSupport("left", plate.edge("x-")))
    system.add(lm.EdgeSupport("right", plate.edge("x+"), axes="yz"))
    system.add(lm.EdgeForce("pull", plate.edge("x+"), (E * H * strain, 0, 0)))
    return system


def beam(strain, n=1):
    """Frequency of bending mode n of a pinned beam under the axial strain given [Hz]; negative when it has buckled."""
    wave = n * np.pi / L
    square = wave**2 / (RHO * H) * (E * H * strain + E * H**3 / 12 * wave**2)
    return np.sign(square) * np.sqrt(abs(square)) / (2 * np.pi)


def bending(modes, count):
    """The lowest frequencies of modes that move out of the plane without twisting."""
    shapes = modes.shapes.reshape(-1, 3, modes.shapes.shape[1])[modes.model.is_position]
    return modes.frequencies[[k for k in range(shapes.shape[2]) if _is_bending(shapes[:, :, k])]][:count]


def _is_bending(shape):
    low, high = np.array_split(shape, 2)  # nodes on y- and y+ of a mesh one element wide
    largest = np.abs(shape).max()
    return np.abs(shape[:, 2]).max() > 0.5 * largest and np.abs(low[:, 2] - high[:, 2]).max() < 1e-4 * largest


@pytest.mark.parametrize("strain", [-4e-5, 0.0, 3e-4])
def test_axial_strain_changes_the_frequencies_as_a_string_and_a_column(strain):
    """Below the critical strain (pi h / L)^2 / 12 = 8.2e-5 the frequency drops, under tension it rises."""
    system = strip(strain)
    state = lm.equilibrium(system).final if strain else None
    found = bending(lm.modes(system, 8, state=state), 2)
    # the interpolation stiffens the second mode by 1e-4, the strain changes length and stress by 3e-4 each
    np.testing.assert_allclose(found, [beam(strain), beam(strain, 2)], rtol=1.5e-3)


def test_straight_strip_beyond_its_critical_strain_is_unstable():
    strain = -1.2e-4
    system = strip(strain)
    result = lm.equilibrium(system)  # symmetry keeps it straight
    assert np.abs(result.final.q.reshape(-1, 3)[:, 2]).max() < 1e-9
    found = lm.modes(system, 6, state=result.final).frequencies
    assert found[0] == pytest.approx(beam(strain), rel=2e-3)
    assert found[0] < 0 < found[1]


def test_shapes_are_normalised_orthogonal_and_respect_the_supports():
    system, plate = lm.System(), lm.Plate("plate", (1.0, 0.8), (2, 2), SECTION)
    system.add(plate)
    system.add(lm.Clamp("root", plate.edge("x-")))
    modes = lm.modes(system, 5)
    gram = modes.shapes.T @ modes.model.mass @ modes.shapes
    np.testing.assert_allclose(gram, np.eye(5), atol=1e-9)
    held = np.concatenate([row.coords for row in modes.model.rows])
    assert np.abs(modes.shapes[held]).max() == 0.0
    np.testing.assert_allclose(modes.frequencies, dense_frequencies(modes.model)[:5], rtol=1e-7)


def test_displaced_moves_by_the_amplitude_asked_for():
    modes = lm.modes(free_plate(2), 8)
    moved = (modes.displaced(6, 0.03) - modes.state).reshape(-1, 3)[modes.model.is_position]
    assert np.linalg.norm(moved, axis=1).max() == pytest.approx(0.03)


def test_modes_with_multipliers_lie_on_the_constraint():
    """A plate hung on two rods: its modes keep the rods' lengths to first order."""
    system, plate, ground = lm.System(), lm.Plate("plate", (1.0, 0.8), (2, 2), SECTION), lm.Ground()
    system.add(plate)
    system.add(ground)
    system.add(lm.PointSupport("pin", plate.corner("x-y-")))
    system.add(lm.DistanceJoint("rod", ground.marker("peg", 1.0, 0.8, 1.0), plate.corner("x+y+")))
    system.add(lm.PointSupport("guide", plate.corner("x+y-"), axes="yz"))
    modes = lm.modes(system, 4)
    corner = modes.model.plates[0].locate((1.0, 0.8))
    upward = corner.position @ modes.shapes.reshape(-1, 3, 4)[corner.vectors, 2]
    assert np.abs(upward).max() < 1e-9 * np.abs(modes.shapes).max()


def constrained_eigenvalues(model, state):
    """omega^2 of (K - omega^2 M) phi + J^T mu = 0, J phi = 0, from dense matrices, by size."""
    equations = Equations(model, symmetric=False)
    point = equations.point_of(state, state.t)
    point.at_rest, point.factor = True, 1.0
    _, _, k, j = equations.linearise(point, STATIC)
    pattern = equations.matrix.pattern
    K, M, J = (x.toarray() for x in (pattern.matrix(k), pattern.matrix(equations.matrix.mass), pattern.jacobian(j)))
    Z = equations.magnitude[:, None] * linalg.null_space(J * equations.magnitude)
    values = linalg.eigvals(Z.T @ K @ Z, Z.T @ M @ Z)
    return values[np.argsort(np.abs(values))]


@pytest.mark.parametrize("load", ["body", "follower", "moment"])
def test_modes_about_a_loaded_point_of_a_plate(load):
    """The axes at the point have neither mass nor stiffness; the stiffness of the loads is not symmetric."""
    system, plate = lm.System(), lm.Plate("plate", (1.0, 0.8), (2, 2), SECTION)
    system.add(plate)
    system.add(lm.Clamp("root", plate.edge("x-")))
    tip = plate.marker("tip", 1.0, 0.3)
    if load == "body":
        bob = system.add(lm.RigidBody("bob", mass=3.0, inertia=(0.2, 0.1, 0.1), position=(1.0, 0.3, 0.0)))
        system.add(lm.FixedJoint("bolt", tip, bob.origin))
    elif load == "follower":
        system.add(lm.PointForce("load", tip, (0.0, 0.0, 2000.0), follower=True))
    else:
        system.add(lm.PointMoment("load", tip, (300.0, -700.0, 500.0), follower=True))
    model = system.compile()
    still = lm.equilibrium(model).final
    expected = constrained_eigenvalues(model, still)[:4]
    assert not expected.imag.any()
    modes = lm.modes(model, 4, state=None if load == "body" else still)  # the body alone has its equilibrium there
    np.testing.assert_allclose((2 * np.pi * modes.frequencies) ** 2, expected.real, rtol=1e-6)


@pytest.mark.parametrize("load", [10.0, 19.5, 20.6])
def test_column_under_a_force_that_follows_its_end_flutters(load):
    """Two frequencies come together at P = 20.05 EI/L^2 (Beck 1952); below, with a^2 and b^2 = sqrt(p^2/4 + w^2) +- p/2,

    p^2 + 2 w^2 + p w sinh b sin a + 2 w^2 cosh b cos a = 0.
    """
    system, plate = lm.System(), lm.Plate("column", (L, B), (8, 1), STRIP)
    system.add(plate)
    system.add(lm.Clamp("root", plate.edge("x-"), kind="restrained"))
    bending = E * B * H**3 / 12
    system.add(lm.PointForce("load", plate.marker("end", L, 0.5 * B), (-load * bending / L**2, 0.0, 0.0), follower=True))
    modes = lm.modes(system, 2, state=lm.equilibrium(system).final)

    def equation(w):
        a, b = (np.sqrt(np.sqrt(load**2 / 4 + w**2) + sign * load / 2) for sign in (1.0, -1.0))
        return load**2 + 2 * w**2 + load * w * np.sinh(b) * np.sin(a) + 2 * w**2 * np.cosh(b) * np.cos(a)

    found = 2 * np.pi * modes.frequencies * np.sqrt(RHO * H * B / bending) * L**2
    if load > 20.05:
        assert found[0] == pytest.approx(-found[1], rel=1e-6)  # one grows, one decays
        assert found[1] == pytest.approx(11.0, rel=0.05)
        assert np.abs(modes.quadrature).max() > 1e-3 * np.abs(modes.shapes).max()
    else:
        places = np.linspace(1.0, 30.0, 3000)
        change = np.flatnonzero(np.diff(np.sign(equation(places))))
        np.testing.assert_allclose(found, [optimize.brentq(equation, *places[[k, k + 1]]) for k in change[:2]], rtol=5e-3)
        assert modes.quadrature is None


def test_rigid_bodies_alone_have_zero_modes():
    """Nothing is elastic there, so that no frequency sets the scale."""
    system = lm.System()
    for name in ("hub", "arm"):
        system.add(lm.RigidBody(name, mass=0.5, inertia=(2e-3, 3e-3, 4e-3)))
    modes = lm.modes(system, 11)
    assert np.abs(modes.frequencies).max() < 1e-6
    assert np.linalg.matrix_rank(modes.shapes.reshape(len(modes.shapes), -1), tol=1e-6 * np.abs(modes.shapes).max()) == 11


def test_wheels_on_one_axis_have_the_modes_of_a_shaft():
    """Neither turns a vector of ones, which moves no wheel about an axis through its centre."""
    system, place = lm.System(), lm.Ground().origin
    inertias, stiffnesses = np.array([1.5, 1.4, 1.3, 1.2]), np.array([7.0, 6.0, 5.0])
    for k, inertia in enumerate(inertias):
        wheel = system.add(lm.RigidBody(f"wheel{k}", mass=1.0, inertia=(1.0, 1.0, inertia)))
        joint = system.add(lm.RevoluteJoint(f"joint{k}", place, wheel.origin))
        if k:
            system.add(lm.TorsionSpring(f"shaft{k}", joint, stiffnesses[k - 1]))
        place = wheel.origin
    K = np.zeros((4, 4))
    for k, stiffness in enumerate(stiffnesses):
        K[k : k + 2, k : k + 2] += stiffness * np.array([[1.0, -1.0], [-1.0, 1.0]])
    expected = np.sqrt(np.abs(linalg.eigh(K, np.diag(inertias), eigvals_only=True))) / (2 * np.pi)
    found = lm.modes(system, 3).frequencies
    assert abs(found[0]) < 1e-6  # the root of rounding
    np.testing.assert_allclose(found[1:], expected[1:3], rtol=1e-9)


@pytest.mark.parametrize("n", [0, -3, 10_000])
def test_impossible_number_of_modes_is_refused(n):
    with pytest.raises(DeclarationError, match=r"modes: n = .*accepted is 1 to"):
        lm.modes(free_plate(1), n)


def test_a_mechanism_that_moves_in_one_way_is_told_what_gives_its_frequency():
    system, ground = lm.System(), lm.Ground()
    bob = system.add(lm.RigidBody("bob", mass=1.0, inertia=(1.0, 1.0, 1.0)))
    system.add(lm.RevoluteJoint("pin", ground.origin, bob.origin, axis=(0, 1, 0)))
    with pytest.raises(ModelError, match=r"can move in one way; accepted are two or more, and linearise"):
        lm.modes(system, 1)
    with pytest.raises(ModelError, match="has 1 degrees of freedom; accepted are three or more"):
        lm.buckling(system, 1)
