"""What the kinds of clamped edges hold and leave free, against closed forms, in space and on a body that moves."""

from __future__ import annotations

import numpy as np
import pytest

import lamella as lm
from lamella.errors import DeclarationError
from lamella.math.rotation import matrix_from_vector

E, NU, H = 2e9, 0.3, 0.02
SECTION = lm.Laminate(lm.Isotropic(E=E, nu=NU, rho=1200.0), thickness=H)
SIZE, PLACE, TURN = (1.2, 0.9), np.array((0.4, -0.2, 0.3)), (0.1, -0.3, 0.7)
R = matrix_from_vector(np.array(TURN))
KINDS = ("full", "restrained", "sliding")
TIGHT = lm.Newton(tolerance=1e-12, keep=0.0)


def plate(mesh=(2, 2), **given):
    return lm.Plate("plate", SIZE, mesh, SECTION, position=tuple(PLACE), rotation=TURN, **given)


def clamped(kind, holder, mesh=(2, 2), **given):
    """The plate with its edge x- clamped in space, to the ground by a joint, or to a free rigid body."""
    system, body = lm.System(), plate(mesh, **given)
    system.add(body)
    if holder == "space":
        system.add(lm.Clamp("root", body.edge("x-"), kind=kind))
    else:
        hub = lm.RigidBody("hub", mass=3.0, inertia=(0.2, 0.3, 0.4), position=(0.1, 0.2, -0.1), rotation=(0.5, 0.2, -0.4))
        marker = lm.Ground().marker("wall", 0.2, 0.1, 0.0) if holder == "ground" else hub.marker("face", 0.1, 0.0, 0.2)
        system.add(marker.body)
        system.add(lm.FixedJoint("root", marker, body.edge("x-"), kind=kind))
    return system, body


def residuals(model, q):
    """All equations of the root in a configuration, linear ones and dot products."""
    (support,) = model.supports
    x = q.reshape(-1, 3)
    rows, dots = (model.rows[k] for k in support.rows), (model.dots[k] for k in support.dots)
    linear = [row.coefs @ q[row.coords] - row.constant for row in rows]
    return np.array(linear + [row.sum(x) - row.constant for row in dots])


def strained(model, F, centre):
    """The plate deformed by a gradient F (3, 3) about a point; other bodies stay."""
    own = np.array([owner == "plate" for owner in model.owners])
    x = model.q0.reshape(-1, 3)
    about = np.outer(model.is_position, centre)
    return np.where(own[:, None], (x - about) @ F.T + about, x).reshape(-1)


HOLDERS = pytest.mark.parametrize("holder", ["space", "ground", "hub"])


@HOLDERS
@pytest.mark.parametrize("mesh", [(2, 1), (2, 3)])
def test_number_of_rows(holder, mesh):
    n = mesh[1] + 1
    multipliers = {"full": 0, "restrained": 2 * n, "sliding": 6 * n + 1}  # for what is held along axes that move
    for kind, count in zip(KINDS, (12 * n, 8 * n, 6 * n + 1), strict=True):
        model = clamped(kind, holder, mesh)[0].compile()
        assert len(residuals(model, model.q0)) == count
        np.testing.assert_allclose(residuals(model, model.q0), 0.0, atol=1e-15)
        assert len(model.supports[0].dots) == (multipliers[kind] if holder == "hub" else 0)


@HOLDERS
@pytest.mark.parametrize(
    ("strain", "free"),
    [
        ("stretch across the edge", ("restrained", "sliding")),
        ("shear of what crosses the edge", ("restrained", "sliding")),
        ("stretch along the edge", ("sliding",)),
        ("bending rotation", ()),
        ("rotation in the plane", ()),
        ("rotation about the normal of the edge's line", ()),
    ],
)
def test_strains_that_are_free(holder, strain, free):
    t, s, n = R.T  # across the edge, along it, normal
    gradient = {
        "stretch across the edge": np.outer(t, t),
        "shear of what crosses the edge": np.outer(s, t),
        "stretch along the edge": np.outer(s, s),
        "bending rotation": np.outer(n, t),
        "rotation in the plane": np.outer(t, s) - np.outer(s, t),
        "rotation about the normal of the edge's line": np.outer(n, s),
    }[strain]
    middle = PLACE + R @ (0.0, SIZE[1] / 2, 0.0)
    for kind in KINDS:
        model = clamped(kind, holder, (2, 3))[0].compile()
        change = np.abs(residuals(model, strained(model, np.eye(3) + 0.01 * gradient, middle))).max()
        if kind in free:
            assert change < 1e-15
        else:
            assert change > 1e-3  # the strain times 0.1 m or a slope of 1


@pytest.mark.parametrize("kind", KINDS)
def test_a_clamp_that_moves_with_the_plate_strains_nothing(kind):
    """A rigid motion of hub and plate, however large, keeps all equations."""
    model = clamped(kind, "hub")[0].compile()
    Q, shift = matrix_from_vector(np.array((1.0, -2.0, 0.5))), np.array((3.0, -1.0, 2.0))
    q = (model.q0.reshape(-1, 3) @ Q.T + np.outer(model.is_position, shift)).reshape(-1)
    np.testing.assert_allclose(residuals(model, q), 0.0, atol=1e-14)


def pulled(kind, holder, load, mesh=(3, 2)):
    """The plate pulled across its clamped edge by a load [N/m] along its own x axis, at rest; the hub is held."""
    system, body = clamped(kind, holder, mesh)
    if holder == "hub":
        hub, ground = system.bodies[1], lm.Ground()
        system.add(ground)
        system.add(lm.FixedJoint("held", ground.marker("at", *hub.position), hub.origin))
    system.add(lm.EdgeForce("pull", body.edge("x+"), tuple(load * R[:, 0])))
    body.marker("lower", SIZE[0], 0.0)
    body.marker("upper", SIZE[0], SIZE[1])
    return lm.equilibrium(system, newton=TIGHT)


@HOLDERS
def test_a_sliding_edge_lets_a_strip_contract_as_it_likes(holder):
    """Uniaxial stress: lam E h e = p with e = (lam^2 - 1) / 2 along the pull, and -nu e across it, everywhere."""
    load = 2e5
    stretch = max(np.roots([0.5, 0.0, -0.5, -load / (E * H)]).real)
    across = np.sqrt(1.0 - NU * (stretch**2 - 1.0))
    result = pulled("sliding", holder, load)
    half = SIZE[1] / 2
    for name, y in (("lower", half - across * half), ("upper", half + across * half)):
        expected = PLACE + R @ (stretch * SIZE[0], y, 0.0)
        np.testing.assert_allclose(
            result[f"{name}.position"].values, expected, atol=1e-9 * SIZE[0]
        )  # Newton on a stretch of 5e-3
    np.testing.assert_allclose(result["root.force"].values, -load * SIZE[1] * R[:, 0], atol=1e-6 * load)


@HOLDERS
def test_kinds_in_the_order_of_their_stiffness(holder):
    """Each kind holds less than the one before; in space, on the ground and on a hub they are the same."""
    load, ends = 1e4, {}
    for kind in KINDS:
        result = pulled(kind, holder, load)
        ends[kind] = (result["upper.position"].values - PLACE) @ R[:, 0] - SIZE[0]
        in_space = pulled(kind, "space", load)
        np.testing.assert_allclose(result["upper.position"].values, in_space["upper.position"].values, atol=1e-9 * SIZE[0])
        for name in ("root.force", "root.torque"):
            np.testing.assert_allclose(result[name].values, in_space[name].values, atol=1e-6 * load)
    assert ends["full"] * 1.01 < ends["restrained"] < ends["sliding"]


def test_only_a_full_clamp_holds_the_strain_at_the_edge_at_zero():
    for kind in KINDS:
        result = pulled(kind, "space", 1e4)
        strain = result.model.plates[0].sample(result.final.q).strains[:, 0]
        eps_x, eps_y = strain[:, 0], strain[:, 1]
        typical = 1e4 / (E * H)
        if kind == "full":
            assert np.abs(strain[::4, 0]).max() < 1e-12
        else:
            assert eps_x.min() > 0.5 * typical
        assert (np.abs(eps_y).max() < 1e-12) == (kind != "sliding")  # the edge is held along itself


@pytest.mark.parametrize("kind", KINDS)
def test_a_moving_clamp_carries_the_plate_along(kind):
    """Without a load the plate moves as a whole by the given displacement."""
    system, body = lm.System(), plate()
    system.add(body)
    given = {"x": lm.Harmonic(amplitude=0.03, frequency=4.0), "z": lm.Harmonic(amplitude=-0.02, frequency=3.0)}
    system.add(lm.Clamp("root", body.edge("x-"), given, kind))
    body.marker("end", *SIZE)
    result = lm.equilibrium(system, t=0.05, newton=TIGHT)
    moved = np.array((given["x"].value(0.05), 0.0, given["z"].value(0.05)))
    assert np.linalg.norm(moved) > 0.02
    np.testing.assert_allclose(result["end.position"].values, PLACE + R @ (*SIZE, 0.0) + moved, atol=1e-12)


def turning(kind, dt):
    """A panel on a hub that is turned by one radian."""
    system, ground = lm.System(), lm.Ground()
    hub = lm.RigidBody("hub", mass=20.0, inertia=(2.0, 2.0, 2.0))
    panel = lm.Plate("panel", (1.0, 0.4), (3, 1), SECTION, position=(0.2, -0.2, 0.0))
    for item in (ground, hub, panel):
        system.add(item)
    pin = system.add(lm.RevoluteJoint("pin", ground.origin, hub.origin, axis=(0, 1, 0)))
    system.add(lm.FixedJoint("mount", hub.marker("face", 0.2, 0, 0), panel.edge("x-"), kind=kind))
    system.add(lm.AngleDrive("motor", pin, angle=lm.SmoothStep(t_end=0.4, end=1.0)))
    return lm.simulate(system, 0.4, lm.GeneralizedAlpha(dt=dt, rho_inf=0.9))


@pytest.mark.parametrize("kind", KINDS)
def test_a_panel_follows_its_hub(kind):
    result, finer = turning(kind, 4e-3), turning(kind, 2e-3)
    axes = result.model.rigid_bodies[0].rotation(result.final.q)
    np.testing.assert_allclose(axes[:, 0], [np.cos(1.0), 0.0, -np.sin(1.0)], atol=1e-9)
    normal = np.cross(*(result.final.q.reshape(-1, 3)[result.model.plates[0].vector(0, name)] for name in ("r_x", "r_y")))
    np.testing.assert_allclose(normal / np.linalg.norm(normal), axes[:, 2], atol=1e-10)
    errors = [np.abs(r["energy.balance"].values).max() / r["energy.kinetic"].values.max() for r in (result, finer)]
    # second order: the first bending mode, some 20 rad/s, makes (omega dt)^2 = 6e-3 of a small part of the energy
    assert errors[0] < 1e-3
    assert errors[0] / errors[1] > 3.5


def test_a_rigid_plate_is_held_alike_by_all_kinds():
    for holder in ("space", "ground", "hub"):
        models = [clamped(kind, holder, strain="rigid")[0].compile() for kind in KINDS]
        assert len({len(model.rows) for model in models}) == len({len(model.dots) for model in models}) == 1


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (
            lambda p, hub: (hub.origin, p.corner("x-y-")),
            r"FixedJoint 'j': kind 'sliding' of hub.origin and plate.x-y-; accepted are a",
        ),
        (lambda p, hub: (lm.Plate("a", SIZE, (1, 1), SECTION).edge("x+"), p.edge("x-")), "kind 'sliding' of a.x. and plate.x-;"),
    ],
)
def test_kinds_are_for_edges_on_bodies(make, message):
    hub, body = lm.RigidBody("hub", mass=1.0, inertia=(1.0, 1.0, 1.0)), plate()
    a, b = make(body, hub)
    system = lm.System()
    for item in (a.body, body, lm.FixedJoint("j", a, b, kind="sliding")):
        system.add(item)
    with pytest.raises(DeclarationError, match=message):
        system.compile()
