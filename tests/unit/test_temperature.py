"""Temperatures as coordinates: numbering, names, values at points, given temperatures and their heat, steady states, modes."""

from __future__ import annotations

import numpy as np
import pytest

import lamella as lm
from lamella.assembly.equations import Equations
from lamella.dofs import Build
from lamella.errors import ModelError
from lamella.thermal.mesh import ElementSum

E, ALPHA, K, C, RHO, H = 70e9, 2e-5, 200.0, 900.0, 2700.0, 2e-3
SHEET = lm.Laminate(lm.Isotropic(E=E, nu=0.0, rho=RHO, alpha=ALPHA, k=K, c=C), thickness=H)
SIZE = (0.5, 0.2)


def held(mesh=(4, 2), kind="sliding", reference=290.0, **options):
    system = lm.System()
    plate = system.add(lm.Plate("plate", SIZE, mesh, SHEET, **options))
    system.add(lm.Clamp("root", plate.edge("x-"), kind=kind))
    system.add(lm.TemperatureField("heat", plate, reference=reference))
    return system, plate


def two_panels():
    """Two panels with fields, one of them on a joint that adds vectors of its own."""
    system, ground = lm.System(), lm.Ground()
    plates = [lm.Plate(f"p{k}", SIZE, (2, 1), SHEET, position=(k * SIZE[0], 0, 0)) for k in range(2)]
    fields = [lm.TemperatureField(f"f{k}", plate, reference=280.0 + k, initial_gradient=7.0) for k, plate in enumerate(plates)]
    pin = lm.RevoluteJoint("pin", ground.origin, plates[0].marker("foot", 0.0, 0.0), axis=(0, 1, 0))
    weld = lm.FixedJoint("weld", plates[0].marker("a", SIZE[0], 0.1), plates[1].marker("b", 0.0, 0.1))
    for item in (fields[0], ground, *plates, pin, weld, fields[1]):  # whatever the order in which they are added
        system.add(item)
    return system.compile()


def test_weights_are_collected_node_by_node():
    coords, weights, q = np.array([[4, 5, 8], [5, 9, 4], [8, 4, 5]]), np.array([0.5, -2.0, 3.0]), np.arange(12.0) ** 2
    assert ElementSum(coords, weights)(q) == (q[coords] @ weights).sum()  # of small halves, exactly


def test_temperatures_lie_behind_all_vectors():
    model = two_panels()
    n = model.n_motion
    assert n > 3 * 2 * 6 * 4  # vectors of the nodes, and those that joints add
    first, second = model.fields
    assert (first.name, second.name) == ("f0", "f1")
    assert (first.first, second.first, model.n_q) == (n, n + 12, n + 24)
    np.testing.assert_array_equal(model.q0[n:].reshape(-1, 2), [[0.0, 7.0]] * 12)
    np.testing.assert_allclose(model.magnitude[n:].reshape(-1, 2), [[100.0, 100.0 / H]] * 12)
    assert Equations(model).n_motion + 24 == Equations(model).n_u
    assert not model.mass[n:].nnz


def test_vectors_behind_a_field_are_refused():
    build = Build()
    plate = lm.Plate("plate", SIZE, (1, 1), SHEET)
    plate.contribute(build)
    lm.TemperatureField("heat", plate).contribute(build)
    with pytest.raises(ModelError, match="vectors of 'late' would be numbered behind the field 'heat'"):
        build.vectors("late", np.zeros((1, 3)), np.zeros((1, 3)), np.array([True]), np.ones(1))


def test_temperatures_are_named_by_their_node():
    model = two_panels()
    second = model.fields[1]
    assert model.describe(second.first) == "temperature T_N at node (0, 0) of plate 'p1'"
    assert model.describe(second.first + 9) == "temperature T_M at node (1, 1) of plate 'p1'"
    assert model.describe(model.fields[0].first + 11) == "temperature T_M at node (2, 1) of plate 'p0'"
    assert "plate" in model.describe(0)


def test_temperatures_are_bilinear_between_nodes():
    model = held(mesh=(4, 2))[0].compile()
    (field,) = model.fields
    x, y = np.meshgrid(np.linspace(0, SIZE[0], 5), np.linspace(0, SIZE[1], 3))  # the nodes
    q = model.q0.copy()
    q[field.first :: 2], q[field.first + 1 :: 2] = (1 + 2 * x - 3 * y + 5 * x * y).ravel(), (4 - x * y).ravel()
    at_x, at_y = np.array([0.0, 0.07, 0.31, SIZE[0]]), np.array([SIZE[1], 0.03, 0.15, 0.0])
    mean, gradient = field.at(q, at_x, at_y)
    np.testing.assert_allclose(mean, 1 + 2 * at_x - 3 * at_y + 5 * at_x * at_y, rtol=1e-13)
    np.testing.assert_allclose(gradient, 4 - at_x * at_y, rtol=1e-13)


def test_integrals_of_an_element():
    one, mixed, slopes = held(mesh=(4, 2))[0].compile().fields[0].integrals()
    lx, ly = SIZE[0] / 4, SIZE[1] / 2
    np.testing.assert_allclose(one, lx * ly / 4)
    np.testing.assert_allclose(mixed.sum(axis=1), one)
    x, y = lx * np.array([0, 1, 0, 1]), ly * np.array([0, 0, 1, 1])
    by_x = np.array([[1.0, 0.0], [0.0, 0.0]])  # dx/dx_i dx/dx_j
    np.testing.assert_allclose(np.einsum("a,ijab,b->ij", x, slopes, x), lx * ly * by_x, atol=1e-16)
    np.testing.assert_allclose(np.einsum("a,ijab,b->ij", x, slopes, y), lx * ly * by_x[[1, 0]].T, atol=1e-16)
    np.testing.assert_allclose(slopes.sum(axis=-1), 0.0, atol=1e-14)


def test_heat_flows_between_edges_that_are_held():
    system, plate = held()
    system.add(lm.PrescribedTemperature("hot", plate.edge("x-"), 350.0))
    system.add(lm.PrescribedTemperature("cold", plate.edge("x+"), 300.0))
    result = lm.equilibrium(system, steps=[0.5, 1.0])
    flow = K * H * SIZE[1] * 50.0 / SIZE[0]
    assert float(result["hot.heat"]) == pytest.approx(flow, rel=1e-10)  # linear between nodes, in the element
    assert float(result["cold.heat"]) == pytest.approx(-flow, rel=1e-10)
    np.testing.assert_allclose(result.history("heat.mean"), [290.0, 307.5, 325.0], rtol=1e-12)  # with the load factor


def test_heat_that_warms_a_whole_plate():
    system, plate = held(strain="rigid")
    system.add(lm.PrescribedTemperature("oven", plate, 390.0, gradient=None, profile=lm.Ramp(t_end=50.0)))
    result = lm.simulate(system, 20.0, lm.GeneralizedAlpha(dt=2.0))
    warmed = RHO * C * H * SIZE[0] * SIZE[1] * 2.0  # 2 K/s
    np.testing.assert_allclose(result["oven.heat"].values[1:], warmed, rtol=1e-10)
    assert float(result["heat.heat"][-1]) == pytest.approx(20.0 * warmed, rel=1e-12)


@pytest.mark.parametrize(("gradient", "found"), [(0.0, 0.0), (5.0, 5.0), (None, 250.0 * H / (2 * K * H))])
def test_gradient_of_a_held_plate_is_given_or_free(gradient, found):
    system, plate = held()
    plate.marker("middle", 0.2, 0.1)
    system.add(lm.PrescribedTemperature("oven", plate, 320.0, gradient=gradient))
    system.add(lm.HeatFlux("lamp", plate, "top", 250.0))
    system.add(lm.HeatFlux("cooler", plate, "bottom", 0.0))
    result = lm.equilibrium(system)
    assert float(result["middle.T_N"]) == pytest.approx(30.0, rel=1e-12)
    assert float(result["middle.T_M"]) == pytest.approx(found, rel=1e-10)


def test_steady_state_of_a_source_is_a_parabola_at_every_load_factor():
    system, plate = held(mesh=(8, 1))
    plate.marker("middle", 0.25, 0.1)
    plate.marker("quarter", 0.125, 0.1)
    system.add(lm.HeatSource("heater", plate, 1e6))
    for side in ("x-", "x+"):
        system.add(lm.PrescribedTemperature(side, plate.edge(side), 290.0))
    result = lm.equilibrium(system, steps=[0.25, 1.0])
    top = 1e6 * SIZE[0] ** 2 / (8 * K)
    np.testing.assert_allclose(result.history("middle.T_N"), top * np.array([0.0, 0.25, 1.0]), rtol=1e-9)  # exact at nodes
    np.testing.assert_allclose(result.history("quarter.T_N"), 0.75 * top * np.array([0.0, 0.25, 1.0]), rtol=1e-9)
    np.testing.assert_allclose(result.history("heater.heat"), 1e6 * H * SIZE[0] * SIZE[1] * np.array([0.0, 0.25, 1.0]))


def test_plate_bends_away_from_the_lamp_with_the_load_factor():
    system, plate = held(mesh=(4, 1))
    plate.marker("tip", SIZE[0], 0.1)
    system.add(lm.HeatFlux("lamp", plate, "top", 1000.0))
    system.add(lm.PrescribedTemperature("oven", plate, 290.0, gradient=None))
    result = lm.equilibrium(system, steps=[0.5, 1.0])
    tip = -ALPHA * 1000.0 / (2 * K) * SIZE[0] ** 2 / 2
    # with nu = 0 the strip bends like a beam along its middle, the clamp holds what bends across: some per cent of the width
    np.testing.assert_allclose(result.history("tip.position")[:, 2], tip * np.array([0.0, 0.5, 1.0]), rtol=0.02)


@pytest.mark.parametrize("share", [0.5, 0.9, -1.0])
def test_frequency_of_a_pinned_strip_falls_with_compressive_heat(share):
    """f^2 = f_0^2 (1 - T / T_cr), alpha T_cr = pi^2 h^2 / (12 L^2): a pinned strip buckles in the shape of its first mode."""

    def frequency(mean):
        system = lm.System()
        strip = system.add(lm.Plate("strip", (0.5, 0.05), (6, 1), SHEET))
        for side in ("x-", "x+"):
            system.add(lm.EdgeSupport(side, strip.edge(side), axes="xz"))
        system.add(lm.PointSupport("guide", strip.corner("x-y-"), axes="y"))
        system.add(lm.PointSupport("guide2", strip.corner("x+y-"), axes="y"))
        system.add(lm.TemperatureField("heat", strip, reference=400.0))
        system.add(lm.PrescribedTemperature("oven", strip, 400.0 + mean))
        return lm.modes(system, 1, state=lm.equilibrium(system).final).frequencies[0]

    critical = np.pi**2 * H**2 / (12 * 0.5**2 * ALPHA)
    ratio = (frequency(share * critical) / frequency(0.0)) ** 2
    assert ratio == pytest.approx(1.0 - share, abs=2e-4)  # six cubic elements: (pi / 6)^4 / 720 = 1e-4 of f_0^2
