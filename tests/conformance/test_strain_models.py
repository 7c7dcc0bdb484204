"""Every strain model whose frame follows the motion moves plates as the exact strains do, as long as they bend little."""

from __future__ import annotations

import numpy as np
import pytest

import lamella as lm
from lamella.errors import DeclarationError
from lamella.math.rotation import matrix_from_vector, polar

MOVING = ("floating", "floating at x-", "corotational")
SIZE = (0.4, 0.3)
E, RHO = 70e9, 2700.0
TIGHT = lm.Newton(tolerance=1e-10)  # what remains of an iteration adds up over a motion and must not hide what is compared
ALUMINIUM = lm.Isotropic(E=E, nu=0.3, rho=RHO)


def plate(name, strain, thickness, size=SIZE, mesh=(2, 2), **given):
    return lm.Plate(name, size, mesh, lm.Laminate(ALUMINIUM, thickness=thickness), **modelled(strain), **given)


def modelled(strain):
    """The strain model of a name, and the edge that its frame follows."""
    model, _, edge = strain.partition(" at ")
    return {"strain": model, "frame_at": edge or "mean"}


def elastic_slope(length, thickness):
    """Slope w L^3 / (6 D) at the end of a cantilever under its weight w = rho g h, D = E h^3 / 12."""
    return 2 * RHO * 9.81 * length**3 / (E * thickness**2)


def swinging(strain, thickness):
    system = lm.System()
    body = system.add(plate("plate", strain, thickness))
    body.marker("end", *SIZE)
    system.add(lm.PointSupport("pin", body.marker("held", 0.0, 0.0)))
    system.add(lm.Gravity("gravity"))
    return lm.simulate(system, 0.4, lm.GeneralizedAlpha(dt=2e-3, rho_inf=0.8, newton=TIGHT))


@pytest.mark.parametrize("strain", MOVING)
def test_stiff_pendulum_held_at_a_corner(strain):
    exact, small = swinging("exact", 0.01), swinging(strain, 0.01)
    path = exact["end.position"].values
    assert np.linalg.norm(path[-1] - path[0]) > 0.5  # it swings far: 0.5 m is the diagonal
    # The models differ by the square of the elastic slope, which in motion is up to twice the static one.
    length = np.hypot(*SIZE)
    accepted = (2 * elastic_slope(length, 0.01)) ** 2 * length
    assert np.abs(small["end.position"].values - path).max() < accepted
    np.testing.assert_allclose(
        small["pin.force"].values, exact["pin.force"].values, atol=1e-2 * np.abs(exact["pin.force"].values).max()
    )


def hinged(strain, thickness=0.01):
    """Two plates, one behind the other, that start level and swing about a fixed edge."""
    system = lm.System()
    upper = system.add(plate("upper", strain, thickness))
    lower = system.add(plate("lower", strain, thickness, position=(SIZE[0], 0.0, 0.0)))
    lower.marker("end", SIZE[0], 0.0)
    system.add(lm.EdgeSupport("axis", upper.edge("x-")))
    system.add(lm.EdgeHinge("hinge", upper.edge("x+"), lower.edge("x-")))
    system.add(lm.PointForce("pull", lower.marker("corner", *SIZE), (0.0, 2.0, 0.0)))  # not symmetric
    system.add(lm.Gravity("gravity"))
    return lm.simulate(system, 0.3, lm.GeneralizedAlpha(dt=2e-3, rho_inf=0.8, newton=TIGHT))


@pytest.mark.parametrize("strain", MOVING)
def test_hinged_plates_swing_as_with_exact_strains(strain):
    exact, small = hinged("exact"), hinged(strain)
    assert np.ptp(exact["hinge.angle"].values) > 0.3
    # as above for each plate; the second hangs on the first, and a double pendulum lets differences grow
    accepted = 4 * (2 * elastic_slope(SIZE[0], 0.01)) ** 2 * 2 * SIZE[0]
    assert np.abs(small["end.position"].values - exact["end.position"].values).max() < accepted
    np.testing.assert_allclose(small["hinge.angle"].values, exact["hinge.angle"].values, atol=accepted / SIZE[0])


def spun(strain, speed=20.0):
    """A free plate that makes half a turn about its normal through its centre."""
    system = lm.System()
    velocity = (speed * SIZE[1] / 2, -speed * SIZE[0] / 2, 0.0)
    body = system.add(plate("plate", strain, 0.004, velocity=velocity, angular_velocity=(0.0, 0.0, speed)))
    body.marker("corner", *SIZE)
    return lm.simulate(system, np.pi / speed, lm.GeneralizedAlpha(dt=np.pi / speed / 200, rho_inf=0.9, newton=TIGHT))


def test_a_plate_spins_freely_in_a_moving_frame():
    exact = spun("exact")
    # the phase error of the integration over half a turn is (omega dt)^2 / 12 * pi, 6e-5
    np.testing.assert_allclose(exact["corner.position"].values[-1], 0.0, atol=1e-4)
    stretch = exact["energy.strain"].values.max()
    for strain in MOVING:
        small = spun(strain)
        # 200 steps, each solved to 1e-10 of what it adds; the corner is stretched outwards by rho omega^2 L^3 / E = 2.5e-7 m
        np.testing.assert_allclose(small["corner.position"].values, exact["corner.position"].values, atol=2e-8)
        assert small["energy.strain"].values.max() == pytest.approx(stretch, rel=1e-4)
    assert np.abs(spun("linear")["corner.position"].values[-1]).max() > 0.1  # a fixed frame does not let it turn


def flying(strain):
    """A free plate with translation, spin about no principal axis, and the velocity of its first two elastic modes."""
    system = lm.System()
    motion = {"velocity": (1.0, -2.0, 3.0), "angular_velocity": (2.0, 5.0, -3.0), "rotation": (0.3, 0.2, 0.1)}
    layup = lm.Laminate(lm.Isotropic(E=2e9, nu=0.3, rho=1200.0), thickness=0.02)
    system.add(lm.Plate("plate", (1.0, 0.8), (2, 2), layup, **modelled(strain), **motion))
    modes = lm.modes(system, 8)
    model = modes.model
    v = model.v0 + sum(modes.displaced(mode, speed) - modes.state for mode, speed in ((6, 1.0), (7, 0.5)))
    return model, lm.state.State(0.0, model.q0.copy(), v, 0.0 * v, np.zeros(0), np.zeros(0))


def momenta(model, state):
    p = (model.mass @ state.v).reshape(-1, 3)
    return p[model.is_position].sum(axis=0), np.cross(state.q.reshape(-1, 3), p).sum(axis=0)


@pytest.mark.parametrize("strain", MOVING)
def test_free_flight_keeps_momenta_and_energy(strain):
    model, start = flying(strain)
    P, H = momenta(model, start)
    drift, energy = [], []
    for dt in (1e-3, 5e-4):
        integrator = lm.GeneralizedAlpha(dt=dt, rho_inf=1.0, newton=lm.Newton(tolerance=1e-11))
        result = lm.simulate(model, 0.05, integrator, initial=start)
        P_end, H_end = momenta(model, result.final)
        assert np.abs(P_end - P).max() < 1e-12 * np.linalg.norm(P)
        drift.append(np.abs(H_end - H).max() / np.linalg.norm(H))
        energy.append(np.abs(result["energy.balance"].values).max() / result["energy.strain"].values.max())
    # the forces have no resultant and no torque, so only the error of the integration is left, which is of second order or better
    assert drift[1] < 1e-4
    assert drift[0] / drift[1] > 3.5
    assert energy[0] / energy[1] > 3.5


def test_a_clamped_plate_hangs_and_stretches():
    """The plate does not turn, so one frame gives linear theory; elements turn a little where the clamp holds the contraction."""
    soft = lm.Laminate(lm.Isotropic(E=1e6, nu=0.3, rho=1000.0), thickness=0.02)
    end = {}
    for strain in ("exact", "linear", *MOVING):
        system = lm.System()
        body = system.add(lm.Plate("plate", SIZE, (3, 2), soft, rotation=(0.0, np.pi / 2, 0.0), **modelled(strain)))
        system.add(lm.Clamp("root", body.edge("x-")))
        system.add(lm.Gravity("gravity"))
        body.marker("end", SIZE[0], SIZE[1] / 2)
        result = lm.equilibrium(system, newton=lm.Newton(tolerance=1e-12))
        assert result["root.force"].values == pytest.approx([0.0, 0.0, 1000 * 9.81 * 0.02 * SIZE[0] * SIZE[1]], abs=1e-9)
        end[strain] = result["end.position"].values - [0.0, SIZE[1] / 2, -SIZE[0]]
    stretch = -end["linear"][2]
    assert stretch == pytest.approx(1000 * 9.81 * SIZE[0] ** 2 / (2 * 1e6), rel=0.1)  # rho g L^2 / (2 E); the clamp holds a bit
    for strain in ("floating", "floating at x-"):
        np.testing.assert_allclose(end[strain], end["linear"], atol=1e-9 * stretch)
    for strain in ("exact", "corotational"):  # terms of second order, of the size of the strain
        assert 1e-6 < np.abs(end[strain] - end["linear"]).max() / stretch < 3 * stretch / SIZE[0]


def cantilever(strain, turn, load):
    """A thin cantilever under a load [N] normal to it at a corner, its clamp turned by ``turn``; displacement in its own axes."""
    R = matrix_from_vector(np.array(turn))
    system, body = lm.System(), plate("plate", strain, 0.001, mesh=(4, 2), rotation=turn)
    system.add(body)
    system.add(lm.Clamp("root", body.edge("x-")))
    system.add(lm.PointForce("load", body.marker("end", *SIZE), tuple(load * R[:, 2])))
    result = lm.equilibrium(system, newton=lm.Newton(tolerance=1e-12))
    return result["end.position"].values @ R - (*SIZE, 0.0), lm.modes(result.model, 6).frequencies


@pytest.mark.parametrize("load", [1e-3, 10.0])
def test_a_frame_at_the_clamp_gives_linear_theory_for_any_load(load):
    """With 10 N the linear deflection is a third of the length, where the frame of the mean gradient is far too stiff."""
    expected, frequencies = cantilever("linear", (0.0, 0.0, 0.0), load)
    for turn in ((0.0, 0.0, 0.0), (0.7, -1.9, 0.4)):
        found, own = cantilever("floating at x-", turn, load)
        np.testing.assert_allclose(found, expected, atol=1e-8 * np.abs(expected).max())  # conditioning 1e8 of a thin plate
        np.testing.assert_allclose(own, frequencies, rtol=1e-8)
    if load == 10.0:
        assert expected[2] > SIZE[0] / 3
        assert cantilever("floating", (0.0, 0.0, 0.0), load)[0][2] < 0.5 * expected[2]


def test_stress_is_that_of_the_strain_model():
    """Linear theory bends without stretching, however far, though the exact strain of its shape has the square of the slope."""
    thickness, load = 0.001, 10.0
    for strain in ("linear", "floating at x-"):
        system, body = lm.System(), plate("plate", strain, thickness, mesh=(4, 2), rotation=(0.7, -1.9, 0.4))
        system.add(body)
        system.add(lm.Clamp("root", body.edge("x-")))
        normal = matrix_from_vector(np.array(body.rotation))[:, 2]
        system.add(lm.PointForce("load", body.marker("end", *SIZE), tuple(load * normal)))
        forces = lm.equilibrium(system, newton=lm.Newton(tolerance=1e-12)).plate("plate").section_forces()
        assert np.abs(forces[..., 3:]).max() > load
        # rounding of the coordinates, 1e-16, times E h over the conditioning of the plate's bending, 1e8, relative to E h
        assert np.abs(forces[..., :3]).max() < 1e-7 * E * thickness


def test_a_thin_cantilever_has_the_stiffness_and_the_frequency_of_a_beam():
    """w = F L^3 / (3 E I), f = 1.8751^2 / (2 pi L^2) sqrt(E I / m): a narrow strip, as Euler and Bernoulli have it."""
    L, b, t, F = 1.0, 0.02, 0.002, 0.004
    EI, m = E * b * t**3 / 12, RHO * b * t
    system = lm.System()
    body = system.add(plate("strip", "floating at x-", t, (L, b), (8, 1)))
    system.add(lm.Clamp("root", body.edge("x-"), kind="restrained"))
    system.add(lm.PointForce("load", body.marker("end", L, b / 2), (0.0, 0.0, F)))
    result = lm.equilibrium(system)
    # a root that cannot curve across stiffens by nu^2 over a width or so, where x^2 has its share: 3 nu^2 b / L = 0.5 %
    assert result["end.position"].values[2] == pytest.approx(F * L**3 / (3 * EI), rel=1e-2)
    first = 1.8751041**2 / (2 * np.pi * L**2) * np.sqrt(EI / m)
    assert lm.modes(result.model, 1).frequencies[0] == pytest.approx(first, rel=1e-2)


def on_a_hub(strain):
    """A panel on a hub that is driven through one and a half turns in 2 s; the motion is slow beside the panel's modes."""
    system, ground = lm.System(), lm.Ground()
    hub = lm.RigidBody("hub", mass=20.0, inertia=(2.0, 2.0, 2.0))
    panel = plate("panel", strain, 0.01, mesh=(3, 1), position=(0.2, -0.15, 0.0))
    for item in (ground, hub, panel):
        system.add(item)
    pin = system.add(lm.RevoluteJoint("pin", ground.origin, hub.origin, axis=(0, 1, 0)))
    system.add(lm.FixedJoint("mount", hub.marker("face", 0.2, 0, 0), panel.edge("x-")))
    system.add(lm.AngleDrive("motor", pin, angle=lm.Cycloid(t_end=2.0, end=3 * np.pi)))
    panel.marker("tip", SIZE[0], SIZE[1] / 2)
    return lm.simulate(system, 2.0, lm.GeneralizedAlpha(dt=2.5e-3, rho_inf=0.8, newton=TIGHT))


def test_a_frame_at_the_root_follows_the_hub():
    small, exact = on_a_hub("floating at x-"), on_a_hub("exact")
    model, q = small.model, small.final.q
    path, angle = small["tip.position"].values, small["pin.angle"].values
    arm = 0.2 + SIZE[0]
    bent = np.abs(path - arm * np.stack([np.cos(angle), 0.0 * angle, -np.sin(angle)], axis=1)).max()
    assert 5e-5 < bent < 2e-4
    # what linear theory leaves out is the stiffening by rotation, (9 / 330)^2 = 8e-4 of the deflection
    np.testing.assert_allclose(path, exact["tip.position"].values, atol=1e-2 * bent)
    np.testing.assert_allclose(path[-1], [-arm, 0.0, 0.0], atol=1e-2 * bent)  # half a turn is left over
    (block,) = (block for block in model.forces if block.name == "panel")
    frame = polar(np.swapaxes(block.groups.weights @ q[block.groups.coords], -1, -2))[0][0]
    np.testing.assert_allclose(frame, model.rigid_bodies[0].rotation(q), atol=1e-10)


@pytest.mark.parametrize("strain", ["exact", "linear", "corotational", "rigid"])
def test_only_the_floating_frame_is_at_an_edge(strain):
    with pytest.raises(DeclarationError, match=f"Plate 'p': frame_at 'y-' with the strain model '{strain}'; accepted are 'mean'"):
        lm.Plate("p", SIZE, (1, 1), lm.Laminate(ALUMINIUM, thickness=0.01), strain=strain, frame_at="y-")


# --- damping --------------------------------------------------------------------------------------


@pytest.mark.parametrize("strain", ["exact", "linear", *MOVING])
def test_the_first_mode_decays_by_the_retardation_time(strain):
    """Amplitudes fall by exp(-c omega^2 t / 2), and what energy is lost is the heat of the damper."""
    c, layup, system = 2e-4, lm.Laminate(lm.Isotropic(E=2e9, nu=0.0, rho=1200.0), thickness=0.02), lm.System()
    body = system.add(lm.Plate("plate", (1.0, 0.2), (2, 1), layup, damping=c, **modelled(strain)))
    system.add(lm.Clamp("root", body.edge("x-")))
    modes = lm.modes(system, 1)
    omega = 2 * np.pi * modes.frequencies[0]
    v = omega * (modes.displaced(0, 1e-4) - modes.state)
    start = lm.state.State(0.0, modes.state.copy(), v, 0.0 * v, np.zeros(0), np.zeros(0))
    end = 4 * 2 * np.pi / omega
    result = lm.simulate(system, end, lm.GeneralizedAlpha(dt=end / 200, rho_inf=1.0, newton=TIGHT), initial=start)
    energy = result["energy.kinetic"].values + result["energy.strain"].values
    # the trapezoidal rule lowers the rate by (omega dt)^2 / 4 = 4e-3, relative
    assert 0.5 * np.log(energy[0] / energy[-1]) / end == pytest.approx(0.5 * c * omega**2, rel=1e-2)
    assert np.abs(result["energy.balance"].values).max() < 1e-3 * energy[0]


def lag(strain, damping):
    """Largest lag [m] of the tip of a slender panel behind a hub that turns by one radian in ten seconds."""
    sheet, system, ground = lm.Laminate(lm.Isotropic(E=1.93e9, nu=0.3, rho=36.8), thickness=0.01), lm.System(), lm.Ground()
    hub = lm.RigidBody("hub", mass=100.0, inertia=(200.0, 200.0, 200.0))
    panel = lm.Plate("panel", (7.5, 0.5), (4, 1), sheet, position=(0.0, -0.25, 0.0), damping=damping, **modelled(strain))
    for item in (ground, hub, panel):
        system.add(item)
    pin = system.add(lm.RevoluteJoint("pin", ground.origin, hub.origin, axis=(0, 1, 0)))
    system.add(lm.FixedJoint("mount", hub.origin, panel.edge("x-"), kind="restrained"))
    system.add(lm.AngleDrive("motor", pin, angle=lm.SmoothStep(t_end=10.0, end=1.0)))
    panel.marker("tip", 7.5, 0.25)
    result = lm.simulate(system, 4.0, lm.GeneralizedAlpha(dt=0.05, rho_inf=0.8))
    path, angle = result["tip.position"].values, result["pin.angle"].values
    return np.abs(path[:, 0] * np.sin(angle) + path[:, 2] * np.cos(angle)).max()


def test_damping_does_not_brake_what_linear_theory_stretches():
    """A plate bent by many thicknesses is stretched by linear theory, in exact strains, but not in its own: no damper may see it.

    Damping by c = 10 ms is 0.7 % of critical for the first mode, at 0.2 Hz: it takes no more than that of the lag.
    """
    exact, undamped, damped = lag("exact", 0.01), lag("floating at x-", 0.0), lag("floating at x-", 0.01)
    assert damped > 10 * 0.01  # many thicknesses
    assert 0.98 * undamped < damped < undamped
    slope = 1.5 * damped / 7.5  # at the tip, were the load there
    assert damped == pytest.approx(exact, rel=2 * slope**2)  # what linear theory leaves out is of second order in it
