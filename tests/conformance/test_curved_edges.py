"""What joints hold of curved edges whose slopes are no unit vectors, in a bent reference configuration."""

from __future__ import annotations

import numpy as np
import pytest
from curved_plate import PLACE, RADIUS, SIZE, STRETCH, R, bent_plate, nodal_vectors

import lamella as lm
from lamella.errors import DeclarationError
from lamella.math.rotation import matrix_from_vector

ANGLE = SIZE[0] / RADIUS
CONE = {"cone": 0.3, "skew": 0.4}  # no line of parameters is straight with a constant normal


def residuals(model, q):
    """All equations of the one joint in a configuration."""
    (support,) = model.supports
    linear = [model.rows[k].coefs @ q[model.rows[k].coords] - model.rows[k].constant for k in support.rows]
    dots = [model.dots[k].sum(q.reshape(-1, 3)) - model.dots[k].constant for k in support.dots]
    return np.array(linear + dots)


def clamped(kind, side, holder="space", mesh=(6, 3), **shape):
    system = lm.System()
    plate = bent_plate(system, mesh=mesh, **shape)
    if holder == "space":
        system.add(lm.Clamp("root", plate.edge(side), kind=kind))
    else:
        hub = lm.RigidBody("hub", mass=3.0, inertia=(0.2, 0.3, 0.4), position=(0.1, 0.2, -0.1), rotation=(0.5, 0.2, -0.4))
        system.add(hub)
        system.add(lm.FixedJoint("root", hub.marker("face", 0.1, 0.0, 0.2), plate.edge(side), kind=kind))
    return system.compile()


def strained_across(model, side, stretch, shear, **shape):
    """The edge's lines that cross it are stretched by a(s) and sheared along it by b(s): d r_t = a R_t + b R_s."""
    mesh, x = model.plates[0], model.q0.reshape(-1, 3).copy()
    along_x = side[0] == "y"
    h = 1e-5
    for number, node in enumerate(mesh.edge_nodes(side)):
        j, i = divmod(int(node), mesh.nx + 1)
        at = np.array((i * mesh.lx, j * mesh.ly))
        step = np.array((h, 0.0)) if along_x else np.array((0.0, h))
        _, r_x, r_y, r_xy = nodal_vectors(*at, **shape)
        r_s, r_t = (r_x, r_y) if along_x else (r_y, r_x)
        slope = 1 if along_x else 2
        r_ss = (nodal_vectors(*(at + step), **shape)[slope] - nodal_vectors(*(at - step), **shape)[slope]) / (2 * h)
        (a, a_s), (b, b_s) = stretch[number], shear[number]
        x[mesh.vector(int(node), mesh.edge_slope(side)[1])] += a * r_t + b * r_s
        x[mesh.vector(int(node), "r_xy")] += a_s * r_t + a * r_xy + b_s * r_s + b * r_ss
    return x.reshape(-1)


@pytest.mark.parametrize("holder", ["space", "hub"])
@pytest.mark.parametrize("side", ["x-", "x+", "y-", "y+"])
def test_restrained_curved_edge_leaves_stretch_across_free(side, holder):
    model = clamped("restrained", side, holder, **CONE)
    np.testing.assert_allclose(residuals(model, model.q0), 0.0, atol=1e-14)
    n = len(model.plates[0].edge_nodes(side))
    stretch = np.random.default_rng(3).uniform(-0.2, 0.2, (n, 2))
    q = strained_across(model, side, stretch, np.zeros((n, 2)), **CONE)
    assert np.abs(q - model.q0).max() > 0.1
    np.testing.assert_allclose(residuals(model, q), 0.0, atol=1e-14)


@pytest.mark.parametrize("side", ["x+", "y-"])
def test_restrained_curved_edge_leaves_shear_free_as_the_mesh_grows_fine(side):
    """e_n' along the edge comes from the cubic edge's curvature, whose error falls with the square of the element's length."""
    worst = []
    for mesh in ((6, 3), (12, 6)):
        model = clamped("restrained", side, mesh=mesh, **CONE)
        n = len(model.plates[0].edge_nodes(side))
        q = strained_across(model, side, np.zeros((n, 2)), np.full((n, 2), (0.1, 0.3)), **CONE)
        worst.append(np.abs(residuals(model, q)).max())
    assert worst[0] < 0.1 * ANGLE**2 / 36  # b of 0.1 times the square of an element's angle
    assert worst[1] < worst[0] / 3


@pytest.mark.parametrize("side", ["x+", "y-"])
def test_restrained_curved_edge_holds_its_normal(side):
    model = clamped("restrained", side, **CONE)
    mesh, x = model.plates[0], model.q0.reshape(-1, 3).copy()
    node = int(mesh.edge_nodes(side)[1])
    slopes = [x[mesh.vector(node, name)] for name in ("r_x", "r_y")]
    normal = np.cross(*slopes) / np.linalg.norm(np.cross(*slopes))
    x[mesh.vector(node, mesh.edge_slope(side)[1])] += 1e-3 * normal
    assert np.abs(residuals(model, x.reshape(-1))).max() == pytest.approx(1e-3, rel=1e-9)


@pytest.mark.parametrize("kind", ["full", "restrained"])
@pytest.mark.parametrize("side", ["x-", "y+"])
def test_clamped_curved_edge_turns_with_its_body(kind, side):
    model = clamped(kind, side, "hub", **CONE)
    turn, move, x = matrix_from_vector(np.array((0.9, -1.3, 0.4))), np.array((0.3, 0.1, -0.7)), model.q0.reshape(-1, 3)
    moved = (x @ turn.T + np.outer(model.is_position, move)).reshape(-1)
    np.testing.assert_allclose(residuals(model, moved), 0.0, atol=1e-13)


def test_straight_edge_of_a_cylinder_slides_along_itself():
    model = clamped("sliding", "x+")
    n = len(model.plates[0].edge_nodes("x+"))
    assert len(residuals(model, model.q0)) == 6 * n + 1
    axis, x = R[:, 1], model.q0.reshape(-1, 3)
    middle = STRETCH * SIZE[1] / 2 + PLACE @ axis
    grown = x + 0.1 * np.outer(x @ axis - middle * model.is_position, axis)
    np.testing.assert_allclose(residuals(model, grown.reshape(-1)), 0.0, atol=1e-14)
    moved = x + 0.1 * np.outer(model.is_position, axis)
    assert np.abs(residuals(model, moved.reshape(-1))).max() == pytest.approx(0.1)


@pytest.mark.parametrize(("side", "shape"), [("y+", {}), ("x+", {"skew": 0.4})])
def test_curved_edge_does_not_slide(side, shape):
    with pytest.raises(
        DeclarationError, match=r"Clamp 'root': kind 'sliding' of edge plate.*turn by .* deg; accepted are straight"
    ):
        clamped("sliding", side, **shape)


def continued(joint, rate=1.0, start=0.0, mesh=(6, 2), size_x=SIZE[0], spoil=False, **shape):
    """A bent plate a and its continuation b beyond y+, joined there."""
    system = lm.System()
    a = bent_plate(system, "a", **shape)
    b = bent_plate(system, "b", mesh, (size_x, SIZE[1]), start=(start, SIZE[1]), rate=rate, **shape)
    if spoil:
        system.add(Spoiled(b))
    system.add(joint(a.edge("y+"), b.edge("y-")))
    return system.compile()


class Spoiled(lm.roles.Declaration):
    """Changes the speed of b's parameter along its edge x-, which stays where it is."""

    name = "spoiled"

    def __init__(self, plate):
        self.plate = plate

    def contribute(self, build):
        mesh = self.plate.compiled(build)
        for node in mesh.edge_nodes("x-"):
            build.q[1][mesh.vector(int(node), "r_y") - mesh.first] *= 1.2


def hinge(a, b):
    return lm.EdgeHinge("joint", a, b)


@pytest.mark.parametrize(
    ("rate", "start", "size_x"), [(1.0, 0.0, SIZE[0]), (0.5, 0.0, 2 * SIZE[0]), (-0.75, SIZE[0], SIZE[0] / 0.75)]
)
def test_hinge_of_curved_edges_with_proportional_parameters(rate, start, size_x):
    model = continued(hinge, rate, start, size_x=size_x, **CONE)
    np.testing.assert_allclose(residuals(model, model.q0), 0.0, atol=1e-14)
    x = model.q0.reshape(-1, 3)
    gradient = np.eye(3) + 0.3 * np.random.default_rng(1).uniform(-1, 1, (3, 3))
    np.testing.assert_allclose(residuals(model, (x @ gradient.T).reshape(-1)), 0.0, atol=1e-14)
    own = np.array([owner == "b" for owner in model.owners])
    assert np.abs(residuals(model, np.where(own[:, None], 1.01 * x, x).reshape(-1))).max() > 5e-3


def test_curved_edges_of_different_meshes_do_not_coincide():
    with pytest.raises(
        DeclarationError, match=r"EdgeHinge 'joint': a.y\+ is 1.49\d+ m and b.y- 1.49\d+ m long; accepted are edges of"
    ):
        continued(hinge, mesh=(3, 2))


def test_edges_elsewhere_are_refused():
    with pytest.raises(DeclarationError, match=r"EdgeHinge 'joint': a.y\+ and b.y- lie 0.0999\d* m apart"):
        continued(hinge, start=0.1)


def test_parameters_that_are_not_proportional_are_refused():
    system = lm.System()
    a = bent_plate(system, "a")
    b = bent_plate(system, "b", start=(SIZE[0], 0.0))
    system.add(Spoiled(b))
    system.add(hinge(a.edge("x+"), b.edge("x-")))
    with pytest.raises(
        DeclarationError, match=r"the tangents of a.x\+ and b.x- differ by 0.2 of their length; accepted are edges whose"
    ):
        system.compile()


def test_weld_of_curved_edges():
    model = continued(lambda a, b: lm.FixedJoint("joint", a, b), **CONE)
    np.testing.assert_allclose(residuals(model, model.q0), 0.0, atol=1e-14)


def held_names(model):
    """How many components of each nodal vector the joint's rows hold."""
    mesh, (support,) = model.plates[0], model.supports
    counts: dict[str, int] = {}
    for k in support.rows:
        (vector,) = set((model.rows[k].coords // 3).tolist())
        name = mesh.element.vector_names[(vector - mesh.first) % 4]
        counts[name] = counts.get(name, 0) + 1
    return counts


def test_symmetry_planes_of_a_cone():
    system = lm.System()
    plate = bent_plate(system, cone=0.3)
    system.add(lm.Symmetry("middle", plate.edge("x-"), tuple(R[:, 2])))
    model = system.compile()
    np.testing.assert_allclose(residuals(model, model.q0), 0.0, atol=1e-14)
    assert held_names(model) == {"r": 4, "r_y": 4, "r_x": 8, "r_xy": 8}


@pytest.mark.parametrize(
    ("side", "normal", "shape", "message"),
    [
        ("x-", 2, {"skew": 0.4}, "leaves the plane"),
        ("y-", 1, {"cone": 0.3}, r"cross edge plate.y- meet the plane .* at 73.3008 deg"),  # 90 deg - arctan 0.3
        ("y-", 2, {}, "leaves the plane"),
    ],
)
def test_edges_that_are_no_symmetry_planes_are_refused(side, normal, shape, message):
    system = lm.System()
    plate = bent_plate(system, **shape)
    system.add(lm.Symmetry("s", plate.edge(side), tuple(R[:, normal])))
    with pytest.raises(DeclarationError, match=message):
        system.compile()


def test_diaphragm_of_an_arc_is_free_along_its_normal():
    system = lm.System()
    plate = bent_plate(system)
    system.add(lm.Diaphragm("end", plate.edge("y+"), tuple(R[:, 1])))
    model = system.compile()
    assert held_names(model) == {"r": 14, "r_x": 14}
    warped = model.q0.reshape(-1, 3) + np.outer(np.random.default_rng(2).uniform(-1, 1, model.n_q // 3), R[:, 1])
    np.testing.assert_allclose(residuals(model, warped.reshape(-1)), 0.0, atol=1e-14)


def test_hinged_arc_keeps_its_line_and_turns():
    system = lm.System()
    plate = bent_plate(system)
    system.add(lm.EdgeSupport("end", plate.edge("y+")))
    assert held_names(system.compile()) == {"r": 21, "r_x": 21}


def test_mean_of_an_arc_is_its_centroid():
    system = lm.System()
    plate = bent_plate(system)
    system.add(lm.EdgeAverage("mean", plate.edge("y+"), "xyz"))
    model = system.compile()
    half = ANGLE / 2
    reach = RADIUS * np.sin(half) / half
    centroid = PLACE + R @ (reach * np.cos(half), STRETCH * SIZE[1], reach * np.sin(half))
    # a cubic edge is off its arc by the fourth power of an element's angle over 384 (Taylor)
    np.testing.assert_allclose([row.constant for row in model.rows], centroid, atol=RADIUS * (ANGLE / 6) ** 4 / 384)
