"""Linear models against closed forms, natural modes, statics and small nonlinear motions."""

from __future__ import annotations

import numpy as np
import pytest
from linear_systems import (
    ARM,
    DAMPER,
    INERTIA,
    M_B,
    MASS,
    OFF,
    STIFFNESS,
    cantilever,
    carriage,
    hub,
    pendulum,
    system_of,
)
from scipy import sparse

import lamella as lm
from lamella.errors import DeclarationError, ModelError
from lamella.solve.eigen import gyroscopic

F = np.array([0.3, 1.6, 4.0])
S = 2j * np.pi * F


def vibrations(model):
    """Frequencies of the poles in the upper half plane [Hz], ascending."""
    poles = model.poles()
    return np.sort(poles.imag[poles.imag > 1e-3]) / (2 * np.pi)


@pytest.mark.parametrize("kept", [None, 5])
def test_poles_of_a_plate_are_its_natural_frequencies(kept):
    model = lm.linearise(cantilever(), ("load",), ("tip.position.z",)).state_space(kept)
    expected = lm.modes(cantilever(), 5).frequencies
    # eigenvalues of the whole plate have the rounding of the highest one, 1e-16 (60 kHz / 7 Hz)^2 of the first: 1e-8
    np.testing.assert_allclose(vibrations(model)[:5], expected, rtol=1e-7)


@pytest.mark.parametrize(("kept", "correct"), [(None, True), (3, True)])
def test_gain_at_rest_is_that_of_statics(kept, correct):
    outputs = ("tip.position.z", "root.force.z", "root.torque.y")
    gain = lm.linearise(cantilever(), ("load",), outputs).state_space(kept, static_correction=correct).dc_gain()[:, 0]
    still = lm.equilibrium(cantilever(load=1e-4))
    found = np.array([still["tip.position"].values[2], still["root.force"].values[2], still["root.torque"].values[1]]) / 1e-4
    # a deflection of 4e-7 m changes the stiffness by its square over h^2, 1e-8; rounding of positions, 1e-16 / 4e-7, as much
    np.testing.assert_allclose(gain, found, rtol=1e-6)


def test_static_correction_gives_what_the_modes_left_out_would_give():
    model = lm.linearise(cantilever(), ("load",), ("tip.position.z",))
    whole = model.state_space().dc_gain()[0, 0]
    # the second bending mode has the share (f_1 / f_2)^2 = 2.5 % of the first
    assert model.state_space(1, static_correction=False).dc_gain()[0, 0] < 0.98 * whole
    assert model.state_space(1).dc_gain()[0, 0] == pytest.approx(whole, rel=1e-7)


def test_step_of_a_plate_is_that_of_the_nonlinear_model():
    small = 1e-3
    run = lm.simulate(cantilever(load=small, damping=1e-4), 0.3, lm.GeneralizedAlpha(dt=5e-4, rho_inf=1.0))
    model = lm.linearise(cantilever(damping=1e-4), ("load",), ("tip.position.z", "root.torque.y")).state_space()
    y = model.step_response(run.at, "load")
    z = run["tip.position"].values[:, 2] / small
    # the step of a seventieth of the first period errs in phase by (w dt)^2 / 12 w t = 5e-4; higher modes add some
    assert np.abs(z - y[:, 0]).max() < 5e-3 * np.abs(z).max()


def test_a_pendulum_has_the_stiffness_of_its_weight_in_the_multipliers():
    model = lm.linearise(pendulum(), ("motor", "gravity"), ("pin.angle", "pin.force.z", "bob.position.x")).state_space()
    omega = np.sqrt(MASS * 9.81 * ARM / (INERTIA + MASS * ARM**2))
    np.testing.assert_allclose(model.poles(), [1j * omega, -1j * omega], rtol=1e-12, atol=1e-12)
    weight = MASS * 9.81
    expected = [[1 / (weight * ARM), 0.0], [0.0, weight], [1 / weight, 0.0]]
    # the signs: the joint turns about -y, and so does the motor; x grows with the angle
    np.testing.assert_allclose(np.abs(model.dc_gain()), expected, rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(model.output_values, [0.0, weight, 0.0], atol=1e-12)
    assert model.dc_gain()[0, 0] > 0.0


def test_a_pendulum_that_stands_falls():
    model = lm.linearise(pendulum(angle=np.pi), ("motor",), ("pin.angle",)).state_space()
    rate = np.sqrt(MASS * 9.81 * ARM / (INERTIA + MASS * ARM**2))
    np.testing.assert_allclose(np.sort(model.poles().real), [-rate, rate], rtol=1e-12)
    assert not model.is_stable


def test_step_of_a_pendulum_that_a_torque_holds_aside():
    """The constraints have turned, and their multipliers too; the motor turns with it, as the torque is about the axis."""
    angle = np.pi / 6
    torque = MASS * 9.81 * ARM * np.sin(angle)
    model = lm.linearise(pendulum(angle, lm.Constant(torque)), ("motor",), ("pin.angle",)).state_space()
    omega = np.sqrt(MASS * 9.81 * ARM * np.cos(angle) / (INERTIA + MASS * ARM**2))
    np.testing.assert_allclose(model.poles(), [1j * omega, -1j * omega], rtol=1e-12, atol=1e-12)
    assert model.input_values == pytest.approx([torque])
    small = 1e-3
    run = lm.simulate(pendulum(angle, lm.Constant(torque + small)), 2.0, lm.GeneralizedAlpha(dt=4e-3, rho_inf=1.0))
    found, y = run["pin.angle"].values / small, model.step_response(run.at, "motor")[:, 0]
    # phase (w dt)^2 / 12 w t = 1e-4 of 1; the amplitude of 1e-4 rad changes the pull by as much
    assert np.abs(found - y).max() < 1e-3 * np.abs(found).max()


def test_a_driven_carriage_has_the_transfer_function_of_a_mass_behind_a_spring():
    model = lm.linearise(carriage(), ("drive", "spring.preload"), ("b.position.x",)).state_space()
    denominator = M_B * S**2 + DAMPER * S + STIFFNESS
    found = model.frequency_response(F)[:, 0]
    np.testing.assert_allclose(found[:, 0], (DAMPER * S + STIFFNESS) / denominator, rtol=1e-9)
    np.testing.assert_allclose(found[:, 1], -1.0 / denominator, rtol=1e-9)
    assert model.input_units == ("m", "N")


@pytest.mark.parametrize("kept", [None, 1])
def test_force_of_a_drive_by_its_acceleration(kept):
    linear = lm.linearise(carriage(), {"push": "drive.acceleration"}, ("drive.force", "a.velocity.x"))
    model = linear.state_space(kept)
    mass = 1.0 + M_B * (DAMPER * S + STIFFNESS) / (M_B * S**2 + DAMPER * S + STIFFNESS)
    np.testing.assert_allclose(model.frequency_response(F)[:, 0, 0], mass, rtol=1e-9)
    np.testing.assert_allclose(model.frequency_response(F)[:, 1, 0], 1.0 / S, rtol=1e-9)
    assert (model.inputs, model.input_units) == (("push",), ("m/s^2",))


def test_an_output_that_needs_rates_of_a_displacement_is_refused():
    for output in ("drive.force", "rail_b.speed"):
        with pytest.raises(DeclarationError, match=f"'{output}' depends on rates of the input 'drive'.*acceleration"):
            lm.linearise(carriage(), ("drive",), (output,)).state_space()


def test_a_free_hub_turns_and_its_blade_vibrates():
    linear = lm.linearise(hub(), ("motor",), ("pin.angle", "tip.position.y", "root.torque.z"))
    whole, small = linear.state_space(), linear.state_space(3)
    expected = lm.modes(hub(), 4).frequencies[1:]
    np.testing.assert_allclose(vibrations(small)[:2], expected[:2], rtol=1e-9)
    np.testing.assert_allclose(vibrations(whole)[:3], expected, rtol=1e-7)
    assert np.abs(small.poles()[:2]).max() == 0.0  # rounding of the rigid-body motion is taken out
    f = np.array([1.0, 5.0])
    # inertia relief: what is left is (f / f_4)^2 of the modes left out, and those are 1e-5 of the whole
    np.testing.assert_allclose(small.frequency_response(f)[:, :2], whole.frequency_response(f)[:, :2], rtol=1e-6)
    # below the vibrations the hub turns with the inertia of all: 1 / (I s^2)
    inertia = 2e-3 + 2700.0 * 2e-3 * 0.05 * (0.45**3 - 0.05**3) / 3
    slow = whole.frequency_response(np.array([0.05]))[0, 0, 0] * -((2 * np.pi * 0.05) ** 2)
    # the blade's own bending adds (f / f_1)^2 = 6e-6, its thickness h^2 / 12 L^2 = 2e-6 of the inertia
    assert slow.real == pytest.approx(1.0 / inertia, rel=1e-4)


def test_poles_of_a_hub_that_spins_are_its_natural_frequencies():
    """With the Coriolis force; the verification case linear-step-response compares steps of it with the inertial frame."""
    omega = 20.0
    held = hub(omega, spin=True, hold=True)
    state = lm.equilibrium(held).final
    expected = lm.modes(held, 3, state=state).frequencies
    model = lm.linearise(held, ("motor",), ("tip.position.y",), state=state).state_space()
    np.testing.assert_allclose(vibrations(model)[:3], expected, rtol=1e-7)
    # the drive bore nothing, so that the state is one of the free hub as well, though it has a multiplier less
    free = lm.linearise(hub(omega, spin=True), ("motor",), ("hub.euler.yaw",), state=state).state_space()
    assert vibrations(free)[0] > 1.5 * expected[0]


def test_natural_frequencies_of_what_spins_are_found_whatever_the_rounding_of_the_stiffness(monkeypatch):
    held, rng, given = hub(20.0, spin=True, hold=True), np.random.default_rng(5), []

    def noted(*arguments):
        given.append(arguments)
        return gyroscopic(*arguments)

    monkeypatch.setattr("lamella.modal.gyroscopic", noted)
    expected = 2 * np.pi * lm.modes(held, 3, state=lm.equilibrium(held).final).frequencies
    K, *others = given[0]
    for _ in range(20):
        near = K.toarray() * (1.0 + 1e-16 * rng.standard_normal(K.shape))
        roots, _ = gyroscopic(sparse.csc_array(0.5 * (near + near.T)), *others)
        np.testing.assert_allclose(np.abs(roots), expected, rtol=1e-9)


def test_heat_alone_has_no_motions():
    plate = lm.Plate("plate", (0.4, 0.3), (2, 2), lm.Laminate(HOT, thickness=2e-3), strain="rigid")
    heat, film = lm.TemperatureField("heat", plate, reference=293.0), lm.Film("film", plate, 10.0, 293.0)
    flux = lm.HeatFlux("sun", plate, "top", 1.0, profile=OFF)
    model = lm.linearise(system_of(plate, lm.Clamp("root", plate.edge("x-")), heat, film, flux), ("sun",), ("heat.mean",))
    assert model.state_space().n_states == 2 * 9
    assert model.state_space().dc_gain()[0, 0] == pytest.approx(1 / 20.0, rel=1e-9)
    assert model.state_space().balanced(1).dc_gain()[0, 0] == pytest.approx(1 / 20.0, rel=1e-6)


def heated(damping=1e-4):
    plate = lm.Plate("plate", (0.4, 0.3), (2, 2), lm.Laminate(HOT, thickness=2e-3), damping=damping)
    tip = plate.marker("tip", 0.4, 0.15)
    return system_of(
        plate,
        lm.Clamp("root", plate.edge("x-")),
        lm.TemperatureField("heat", plate, reference=293.0),
        lm.Film("film", plate, 10.0, 293.0),
        lm.HeatFlux("sun", plate, "top", 1.0, profile=OFF),
        lm.PointForce("load", tip, (0, 0, 1.0), profile=OFF),
    )


HOT = lm.Isotropic(E=70e9, nu=0.3, rho=2700.0, alpha=23e-6, k=200.0, c=900.0)


def test_temperatures_are_states_behind_the_motions():
    model = lm.linearise(heated(), ("sun", "load"), ("heat.mean", "tip.position.z", "sun.heat", "film.heat")).state_space()
    slowest = model.poles()[0]
    # evenly warm: rho c h T' = q - 2 h_c T
    rate = 2 * 10.0 / (2700.0 * 900.0 * 2e-3)
    assert slowest.real == pytest.approx(-rate, rel=1e-9)
    gain = model.dc_gain()
    area = 0.4 * 0.3
    np.testing.assert_allclose(gain[:, 0][[0, 2, 3]], [1 / 20.0, area, -area], rtol=1e-9)
    bent = []
    for flux in (1.0, -1.0):
        hot = heated()
        hot.declarations[4] = lm.HeatFlux("sun", hot.declarations[0], "top", flux)
        bent.append(lm.equilibrium(hot, newton=lm.Newton(tolerance=1e-13, keep=0.0))["tip.position"].values[2])
    # warmed by 0.05 K the clamped edge is pressed, which changes the bending by 2e-4, but by the opposite where it is cooled
    assert gain[1, 0] == pytest.approx(0.5 * (bent[0] - bent[1]), rel=1e-5)
    with pytest.raises(DeclarationError, match=r"temperatures.*accepted is the whole model"):
        lm.linearise(heated(), ("sun",), ("heat.mean",)).state_space(3)


def test_temperatures_beside_stiff_damping_are_stable():
    """The membrane decays 1e12 times faster than the plate cools down."""
    model = lm.linearise(heated(damping=1e-2), ("sun",), ("heat.mean",)).state_space()
    sizes = np.abs(model.poles())
    assert sizes[0] < 1e-11 * sizes[-1]
    assert model.is_stable
    assert model.dc_gain()[0, 0] == pytest.approx(1 / 20.0, rel=1e-9)
    assert model.balanced(1).dc_gain()[0, 0] == pytest.approx(1 / 20.0, rel=1e-6)


def test_a_prescribed_temperature_is_an_input():
    plate = lm.Plate("plate", (0.4, 0.1), (4, 1), lm.Laminate(HOT, thickness=2e-3), strain="linear")
    middle = plate.marker("middle", 0.2, 0.05)
    system = system_of(
        plate,
        lm.Clamp("root", plate.edge("x-")),
        lm.TemperatureField("heat", plate),
        lm.PrescribedTemperature("left", plate.edge("x-"), 1.0, profile=OFF),
        lm.PrescribedTemperature("right", plate.edge("x+"), 0.0),
    )
    model = lm.linearise(system, ("left",), (f"{middle.name}.T_N",)).state_space()
    assert model.dc_gain()[0, 0] == pytest.approx(0.5, rel=1e-9)  # a linear course between the ends
    with pytest.raises(DeclarationError, match=r"'left\.heat' depends on rates"):  # it warms what stands at the edge
        lm.linearise(system, ("left",), ("left.heat",)).state_space()
    slow = np.array([1e-6])
    heat = lm.linearise(system, ("left.acceleration",), ("left.heat",)).state_space().frequency_response(slow)[0, 0, 0]
    # heat k h b / L for each kelvin through the strip, and i w of a third of its capacity of 194 J/K, 4e-3 of that,
    # the square of which adds to the real part
    assert (heat * (2j * np.pi * slow[0]) ** 2).real == pytest.approx(200.0 * 2e-3 * 0.1 / 0.4, rel=2e-5)


def test_uniform_translation_is_steady_and_turning_is_not():
    def glider(**motion):
        body = lm.RigidBody("body", mass=2.0, inertia=(1, 2, 2.5), **motion)
        return system_of(body, lm.PointForce("push", body.origin, (1.0, 0, 0), profile=OFF))

    for motion in ({"velocity": (3.0, 0, 0)}, {"angular_velocity": (0, 0, 1.0)}):
        run = lm.simulate(glider(**motion), 0.1, lm.GeneralizedAlpha(dt=1e-2))
        linear = (glider(), ("push",), ("body.velocity.x",))
        if "velocity" in motion:
            found = lm.linearise(*linear, state=run.final).state_space().frequency_response(F)[:, 0, 0]
            np.testing.assert_allclose(found, 1 / (2.0 * S), rtol=1e-9)
        else:
            with pytest.raises(ModelError, match=r"moves at 0.995 of the bodies' size in a second.*SteadySpin"):
                lm.linearise(*linear, state=run.final)


@pytest.mark.parametrize(
    ("inputs", "outputs", "said"),
    [
        (("lod",), ("tip.position",), r"there is no input 'lod'.*there are: load"),
        (("load",), ("tip.positon",), r"there is no output 'tip.positon'.*tip\.position"),
        (("load",), ("tip.position.w",), "there is no output 'tip.position.w'"),
        ((), ("tip.position",), "at least one input"),
        (("load", "load"), ("tip.position",), "each once"),
        (("load",), (), "at least one recorded signal"),
        (("load",), ("tip.position", "tip.position.z"), "'tip.position.z' is given twice"),
        (("load",), ("work.loads",), "sums over the steps"),
        (("load.acceleration",), ("tip.position",), "no motion to accelerate"),
    ],
)
def test_wrong_names_are_told_with_those_that_exist(inputs, outputs, said):
    with pytest.raises(DeclarationError, match=said):
        lm.linearise(cantilever(), inputs, outputs)


def test_a_state_out_of_equilibrium_is_refused_with_its_residual():
    with pytest.raises(ModelError, match=r"not in equilibrium: a force of .* N or N m is unbalanced at z of .*plate"):
        lm.linearise(cantilever(load=1.0), ("load",), ("tip.position",))


def test_a_state_of_another_system_is_refused():
    state = lm.equilibrium(cantilever(load=1.0, mesh=(2, 1))).final
    with pytest.raises(ModelError, match=r"the state has \d+ coordinates; accepted is one with \d+"):
        lm.linearise(cantilever(), ("load",), ("tip.position",), state=state)


def test_too_many_modes_or_states_are_refused(monkeypatch):
    linear = lm.linearise(cantilever(), ("load",), ("tip.position",))
    n = linear.basis.shape[1]
    assert linear.K.shape == linear.M.shape == linear.C.shape == (n, n)
    for modes in (0, n + 1):
        with pytest.raises(DeclarationError, match=f"modes = {modes}; accepted is 1 to {n}"):
            linear.state_space(modes)
    monkeypatch.setattr("lamella.linear.model.LARGEST", 10)
    with pytest.raises(DeclarationError, match=f"the whole model has {2 * n} states; accepted are 10; give modes=n"):
        linear.state_space()
    assert linear.state_space(3).n_states == 8
