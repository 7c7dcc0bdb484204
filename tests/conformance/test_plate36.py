"""Plate36 beside Plate48: the same surface and mechanics in fewer coordinates, and plates of it in systems."""

from __future__ import annotations

import numpy as np
import pytest
from shell_patch import SURFACES, dense, patch, section

import lamella as lm
from lamella.element import ELEMENTS
from lamella.element.plate36.shape import expansion
from lamella.element.shells import SHELLS
from lamella.errors import DeclarationError
from lamella.inertia import vector_mass, whole_mass
from lamella.io.model_file import loads

PLATE36, PLATE48 = ELEMENTS["plate36"], ELEMENTS["plate48"]
SIZE = (0.4, 0.3)
ALUMINIUM = lm.Laminate(lm.Isotropic(E=70e9, nu=0.3, rho=2700.0), thickness=2e-3)


@pytest.fixture
def rng():
    return np.random.default_rng(5)


def test_its_functions_are_among_those_of_plate48(rng):
    xi, eta = rng.random((2, 30))
    np.testing.assert_allclose(PLATE48.shape(xi, eta) @ expansion(), PLATE36.shape(xi, eta), atol=2e-14)


POWERS = [(0, 0), (1, 0), (0, 1), (2, 0), (1, 1), (0, 2), (3, 0), (2, 1), (1, 2), (0, 3), (3, 1), (1, 3)]


@pytest.mark.parametrize(("m", "n", "exact"), [*((m, n, True) for m, n in POWERS), (2, 2, False)])
def test_it_reproduces_twelve_polynomials(rng, m, n, exact):
    values = []
    for x, y in PLATE36.nodes:
        values += [x**m * y**n, m * x ** max(m - 1, 0) * y**n, n * x**m * y ** max(n - 1, 0)]
    xi, eta = rng.random((2, 20))
    error = np.abs(PLATE36.shape(xi, eta)[0] @ np.array(values, float) - xi**m * eta**n).max()
    assert (error < 1e-14) == exact


def pair(surface):
    """One element of each kind with the same reference surface, and P between their unscaled coordinates."""
    short = patch(PLATE36, [0.0, 0.7], [0.0, 0.4], SURFACES[surface])
    full = patch(PLATE48, [0.0, 0.7], [0.0, 0.4], SURFACES[surface])
    scale36, scale48 = np.empty(36), np.empty(48)
    scale36[short.coords[0]], scale48[full.coords[0]] = short.scale[0], full.scale[0]
    P = np.zeros((48, 36))
    P[np.ix_(full.coords[0], short.coords[0])] = np.kron(expansion(), np.eye(3))
    P = P * scale36 / scale48[:, None]
    full.rest = P @ short.rest
    full.reference = full.rest[full.coords]
    return short, full, P


@pytest.mark.parametrize("surface", list(SURFACES))
@pytest.mark.parametrize("model", ["exact", "linear", "viscous"])
def test_force_and_tangent_are_those_of_plate48_condensed(rng, surface, model):
    short, full, P = pair(surface)
    C, others = section(rng), (0.3,) if model == "viscous" else ()
    blocks = []
    for mesh in (short, full):
        shell = SHELLS[mesh.element.name]
        make = shell.viscous if model == "viscous" else shell.strain_models[model]
        blocks.append(make("plate", *mesh.tables, C, *others))
    q, v, before = (short.rest + 0.05 * rng.standard_normal(36) for _ in range(3))
    f36, K36 = dense(blocks[0], q, v, 0.8, 0.6, before)
    f48, K48 = dense(blocks[1], P @ q, P @ v, 0.8, 0.6, P @ before)
    np.testing.assert_allclose(f36, P.T @ f48, atol=1e-12 * np.abs(f36).max())
    np.testing.assert_allclose(K36, P.T @ K48 @ P, atol=1e-12 * np.abs(K36).max())


@pytest.mark.parametrize("surface", list(SURFACES))
def test_mass_is_that_of_plate48_condensed(surface):
    short, full, P = pair(surface)
    masses = []
    for mesh in (short, full):
        inertia = SHELLS[mesh.element.name].inertia("plate", mesh.tables, 2.5)
        masses.append(whole_mass(vector_mass([inertia], len(mesh.rest) // 3), len(mesh.rest)).toarray())
    np.testing.assert_allclose(masses[0], P.T @ masses[1] @ P, atol=1e-15)


def plate(element, name="plate", n=6, **given):
    return lm.Plate(name, SIZE, (n, n), ALUMINIUM, element=element, **given)


def two_plates(element, n):
    """A hub carries a panel, a second one is hinged to it by a spring; pressure, edge load and gravity, at rest."""
    system = lm.System()
    hub = system.add(lm.RigidBody("hub", mass=1.0, inertia=(0.1, 0.1, 0.1)))
    left, right = plate(element, "left", n), plate(element, "right", n, position=(SIZE[0], 0.0, 0.0))
    for item in (left, right):
        system.add(item)
    ground = system.add(lm.Ground())
    system.add(lm.FixedJoint("base", ground.origin, hub.origin))
    system.add(lm.FixedJoint("mount", hub.origin, left.edge("x-"), kind="restrained"))
    hinge = system.add(lm.EdgeHinge("hinge", left.edge("x+"), right.edge("x-")))
    system.add(lm.TorsionSpring("spring", hinge, stiffness=20.0))
    system.add(lm.Pressure("pressure", left, 20.0))
    system.add(lm.EdgeMoment("moment", right.edge("x+"), bending=-0.5))
    system.add(lm.EdgeForce("force", right.edge("y+"), (0.0, 0.0, 0.5)))
    system.add(lm.Gravity("gravity"))
    right.marker("tip", *SIZE)
    return lm.equilibrium(system)


def test_joints_and_loads_act_as_on_plate48():
    results = {(name, n): two_plates(name, n) for name in ("plate48", "plate36") for n in (4, 8)}
    fine = results["plate48", 8]
    force, tip = fine["mount.force"].values, fine["tip.position"].values
    assert np.abs(tip - [2 * SIZE[0], SIZE[1], 0.0]).max() > 0.02
    errors = {key: np.abs(result["tip.position"].values - tip).max() for key, result in results.items()}
    assert errors["plate36", 8] < 0.02 * np.abs(tip - [2 * SIZE[0], SIZE[1], 0.0]).max()  # h^2 of the frequencies of plates
    assert errors["plate36", 8] < 0.5 * errors["plate36", 4]
    for result in results.values():  # equilibrium of what hangs on the hub, whatever the mesh; pressure follows the surface
        np.testing.assert_allclose(result["mount.force"].values, force, atol=5e-3 * np.abs(force).max())


@pytest.mark.parametrize("kind", ["full", "restrained", "sliding"])
def test_clamps_hold_its_edges(kind):
    system, body = lm.System(), plate("plate36", n=3, rotation=(0.3, 0.1, -0.2))
    system.add(body)
    system.add(lm.Clamp("root", body.edge("x-"), kind=kind))
    system.add(lm.Gravity("gravity"))
    result = lm.equilibrium(system)
    weight = 2700.0 * 2e-3 * SIZE[0] * SIZE[1] * 9.81
    np.testing.assert_allclose(result["root.force"].values, [0.0, 0.0, weight], atol=1e-8 * weight)


def test_a_rigid_panel_of_it_swings_as_one_of_plate48():
    paths = []
    for element in ("plate48", "plate36"):
        system, body = lm.System(), plate(element, n=2, strain="rigid")
        system.add(body)
        body.marker("end", *SIZE)
        system.add(lm.PointSupport("pin", body.corner("x-y-")))
        system.add(lm.Gravity("gravity"))
        paths.append(lm.simulate(system, 0.2, lm.GeneralizedAlpha(dt=5e-3))["end.position"].values)
    np.testing.assert_allclose(paths[1], paths[0], atol=1e-9)


MODEL = """\
lamella: 1
materials: {sheet: {type: isotropic, E: 70 GPa, nu: 0.3, rho: 2700}}
system:
  plate: {type: plate, size: [0.4, 0.3], mesh: [2, 2], laminate: {ply: sheet, thickness: 2 mm}, element: plate36}
  root: {type: clamp, on: plate.x-}
"""


def test_a_model_file_names_it():
    model = loads(MODEL).system.compile()
    assert len(model.q0) == 9 * 9  # nodes times coordinates
    assert model.plates[0].element is PLATE36


def test_temperatures_are_refused():
    sheet = lm.Laminate(lm.Isotropic(E=70e9, nu=0.3, rho=2700.0, alpha=2e-5, k=200.0, c=900.0), thickness=2e-3)
    system = lm.System()
    body = system.add(lm.Plate("panel", SIZE, (1, 1), sheet, element="plate36"))
    system.add(lm.TemperatureField("heat", body))
    with pytest.raises(DeclarationError, match=r"'heat': plate 'panel' has the element 'plate36'; accepted.*is 'plate48'"):
        lm.modes(system, 1)
