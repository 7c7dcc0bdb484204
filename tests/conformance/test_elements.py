"""What every element must fulfil, over all elements of the list and, for its blocks, over flat and curved reference surfaces."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from shell_patch import SURFACES, dense, derivative, gathered_force, patch, random_rotation, section, turned

from lamella.element import ELEMENTS
from lamella.element.plate48.damping import MassDampingBlock
from lamella.element.plate48.damping_small import small_damping
from lamella.element.plate48.framed_shape import framed_shape
from lamella.element.plate48.recovery import ShellRecovery
from lamella.element.plate48.section import Section
from lamella.element.plate48.shape import gauss_points
from lamella.element.shells import SHELLS
from lamella.errors import ModelError
from lamella.inertia import vector_mass, whole_mass
from lamella.lane import aligned

XS, YS = [0.0, 0.5, 0.8, 1.5], [0.0, 0.4, 1.0, 1.3]  # nine elements: one full block of eight and one alone


@pytest.fixture(params=list(ELEMENTS.values()), ids=list(ELEMENTS))
def element(request):
    return request.param


@pytest.fixture(params=list(SURFACES))
def mesh(request, element):
    return patch(element, XS, YS, SURFACES[request.param])


@pytest.fixture
def rng():
    return np.random.default_rng(7)


OPTIONS = {
    "unit": {},
    "cubed": {"curvature": "cubed_normal"},
    "reduced": {"membrane_gauss": 3},
    "cubed, reduced": {"curvature": "cubed_normal", "membrane_gauss": 3},
}


@pytest.fixture(params=list(OPTIONS.values()), ids=list(OPTIONS))
def options(request):
    """How curvature is measured and the energy of the in-plane forces integrated."""
    return request.param


def exact(mesh, rng, n_gauss=4, options=OPTIONS["unit"]):
    material = Section(section(rng), **options)
    return SHELLS[mesh.element.name].strain_models["exact"]("plate", *mesh.tables, material, n_gauss)


def deformed(mesh, rng, size=0.05):
    return mesh.rest + size * rng.standard_normal(mesh.rest.shape)


# --- shape functions ------------------------------------------------------------------------------


def test_coordinates_are_the_values_and_derivatives_at_the_nodes(element):
    rows = {"r": 0, "r_x": 1, "r_y": 2, "r_xy": 4}
    values = np.concatenate([element.shape(*node)[[rows[name] for name in element.vector_names]] for node in element.nodes])
    np.testing.assert_allclose(values, np.eye(element.n_shape), atol=1e-15)


def test_positions_sum_to_one_everywhere(element, rng):
    shape = element.shape(rng.random(20), rng.random(20))
    total = shape[..., np.tile(element.is_position, len(element.nodes))].sum(axis=-1)
    np.testing.assert_allclose(total, np.array([1, 0, 0, 0, 0, 0])[:, None] * np.ones(20), atol=1e-13)


def test_derivatives_of_the_shape_functions(element):
    for d, (first, variable) in {1: (0, 0), 2: (0, 1), 3: (1, 0), 4: (1, 1), 5: (2, 1)}.items():
        step = np.eye(2)[variable]
        # polynomials of low degree: central differences of order eight are exact but for rounding
        numeric = derivative(lambda h, first=first, step=step: element.shape(*(np.array([0.3, 0.8]) + h * step))[first], 0.05)
        np.testing.assert_allclose(element.shape(0.3, 0.8)[d], numeric, atol=1e-12)


def test_what_is_continuous_across_an_edge(element, rng):
    """Position, and for conforming elements the slope across it; others share it at the nodes at most."""
    mesh, s = patch(element, [0.0, 0.5, 0.8], [0.0, 0.4]), np.linspace(0.0, 1.0, 11)
    q = deformed(mesh, rng, 1.0)
    left, right = (
        np.einsum("dns,sc->dnc", element.shape(np.full_like(s, xi), s), (q * scale).reshape(-1, 3)) / scale[3]
        for q, scale, xi in zip(q[mesh.coords], mesh.scale, (1.0, 0.0), strict=True)
    )
    np.testing.assert_allclose(mesh.scale[0, 3] * left[0], mesh.scale[1, 3] * right[0], atol=1e-14)
    jump = np.abs(left[1] - right[1])
    assert jump[[0, -1]].max() < 1e-13  # the slopes of nodes are theirs alone
    assert (jump.max() < 1e-13) == element.conforming


def test_magnitudes_and_scales_follow_the_derivatives(element):
    assert element.magnitudes(2.0)[0] == 2.0
    assert element.magnitudes(2.0)[1] == 1.0
    assert element.scales(np.array([0.5, 1.0]), np.array([0.25, 1.0])).shape == (2, element.n_shape)
    assert element.scales(0.5, 0.25)[1] == 0.5


# --- exact strains --------------------------------------------------------------------------------


def test_rigid_motion_gives_no_force_and_no_energy(mesh, rng, options):
    block = exact(mesh, rng, options=options)
    q = turned(mesh.rest, mesh.is_position, random_rotation(rng), 3.0 * rng.standard_normal(3))
    typical = deformed(mesh, rng)
    # strains of rounding size, 1e-15, give forces of that size and energies of its square
    assert np.abs(gathered_force(block, q)).max() < 1e-12 * np.abs(gathered_force(block, typical)).max()
    assert 0 <= block.energy(0.0, q) < 1e-24 * block.energy(0.0, typical)


def test_force_turns_with_the_configuration(mesh, rng, options):
    block, q, R = exact(mesh, rng, options=options), deformed(mesh, rng), random_rotation(rng)
    moved = turned(q, mesh.is_position, R, np.array([1.0, -2.0, 0.5]))
    expected = (gathered_force(block, q).reshape(-1, 3) @ R.T).reshape(-1)
    np.testing.assert_allclose(gathered_force(block, moved), expected, atol=1e-11 * np.abs(expected).max())
    assert block.energy(0.0, moved) == pytest.approx(block.energy(0.0, q), rel=1e-11)


@pytest.mark.parametrize("n_gauss", [3, 4, 5])
def test_force_is_the_derivative_of_the_energy(mesh, rng, options, n_gauss):
    block, q, d = exact(mesh, rng, n_gauss, options), deformed(mesh, rng), rng.standard_normal(mesh.rest.shape)
    numeric = derivative(lambda h: block.energy(0.0, q + h * d), 2e-4)
    assert gathered_force(block, q) @ d == pytest.approx(numeric, rel=1e-9)


@pytest.mark.parametrize("n_gauss", [3, 4, 5])
def test_tangent_is_the_derivative_of_the_force(mesh, rng, options, n_gauss):
    block, q, d = exact(mesh, rng, n_gauss, options), deformed(mesh, rng), rng.standard_normal(mesh.rest.shape)
    f, K = dense(block, q, alpha_q=0.7)
    numeric = derivative(lambda h: gathered_force(block, q + h * d), 2e-4)
    np.testing.assert_allclose(f, gathered_force(block, q), rtol=1e-12, atol=1e-12 * np.abs(f).max())
    np.testing.assert_allclose(K @ d, 0.7 * numeric, atol=1e-9 * np.abs(numeric).max())


def test_extrapolated_stress_leaves_the_force_and_differs_by_second_order_in_the_tangent(mesh, rng, options):
    block, q, d = exact(mesh, rng, options=options), deformed(mesh, rng, 0.02), rng.standard_normal(mesh.rest.shape)
    f, K = dense(block, q)
    errors = []
    for h in (2e-3, 1e-3):
        f_mixed, K_mixed = dense(block, q, q_previous=q - h * d)
        np.testing.assert_array_equal(f_mixed, f)
        errors.append(np.abs(K_mixed - K).max())
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.1)  # the next term is of third order
    np.testing.assert_allclose(dense(block, q, q_previous=q.copy())[1], K, atol=1e-12 * np.abs(K).max())


def test_constant_membrane_strain_is_in_balance_inside_the_patch(element, rng):
    mesh = patch(element, XS, YS)
    F = np.eye(3) + 0.2 * rng.standard_normal((3, 3))
    f = gathered_force(exact(mesh, rng), (mesh.rest.reshape(-1, 3) @ F.T).reshape(-1))
    inner = np.repeat([0 < x < XS[-1] and 0 < y < YS[-1] for x, y in mesh.nodes], 3 * element.vectors_per_node)
    assert np.abs(f[inner]).max() < 1e-13 * np.abs(f).max()


def test_constant_curvature_is_in_balance_inside_the_patch(element, rng):
    """The patch test of bending; elements that are not conforming pass it where they are rectangles."""
    K = rng.standard_normal((2, 2))
    K = K + K.T

    def bent(x, y):
        z_x, z_y = K @ [x, y]
        return {"r": (x, y, 0.5 * (z_x * x + z_y * y)), "r_x": (1, 0, z_x), "r_y": (0, 1, z_y), "r_xy": (0, 0, K[0, 1])}

    mesh, C = patch(element, XS, YS), section(rng)
    block, q = SHELLS[element.name].strain_models["linear"]("plate", *mesh.tables, C), patch(element, XS, YS, bent).rest
    f = gathered_force(block, q)
    inner = np.repeat([0 < x < XS[-1] and 0 < y < YS[-1] for x, y in mesh.nodes], 3 * element.vectors_per_node)
    assert np.abs(f[inner]).max() < 1e-12 * np.abs(f).max()
    kap = np.array([K[0, 0], K[1, 1], 2 * K[0, 1]])
    assert block.energy(0.0, q) == pytest.approx(0.5 * kap @ C[3:, 3:] @ kap * XS[-1] * YS[-1], rel=1e-12)


def test_small_constant_curvature_is_reproduced(element, rng):
    size, K = 1e-6, np.array([[0.7, -0.4], [-0.4, 1.2]])

    def bent(x, y):
        z_x, z_y = size * (K @ [x, y])
        return {"r": (x, y, 0.5 * (z_x * x + z_y * y)), "r_x": (1, 0, z_x), "r_y": (0, 1, z_y), "r_xy": (0, 0, size * K[0, 1])}

    mesh, C = patch(element, XS, YS), section(rng)
    block = SHELLS[element.name].strain_models["exact"]("plate", *mesh.tables, C)
    kap = size * np.array([K[0, 0], K[1, 1], 2 * K[0, 1]])
    energy = 0.5 * kap @ C[3:, 3:] @ kap * XS[-1] * YS[-1]
    # the membrane strain of a developable bend is of the order size^2
    assert block.energy(0.0, patch(element, XS, YS, bent).rest) == pytest.approx(energy, rel=1e-5)


@pytest.mark.parametrize("strain", ["exact", "linear", "floating", "floating at y+", "corotational"])
@pytest.mark.parametrize("curvature", ["unit_normal", "cubed_normal"])
def test_recovered_strains_give_the_energy(mesh, rng, curvature, strain):
    C = section(rng)
    block = moving_block(strain, mesh, Section(C, curvature=curvature))
    recovery = ShellRecovery(mesh.element, *mesh.tables, curvature=curvature)
    q = deformed(mesh, rng) if strain in ("exact", "linear") else moved(mesh, deformed(mesh, rng), rng)
    xi, eta, weights = gauss_points(4)
    n = len(mesh.coords)
    index, xi, eta = np.repeat(np.arange(n), 16), np.tile(xi, n), np.tile(eta, n)
    turns = None if strain == "exact" else block.turns(q)
    found, size = recovery.at(q, index, xi, eta, turns), 1e-5
    shape = mesh.element.shape(xi, eta)
    vectors = (mesh.reference * mesh.scale).reshape(n, -1, 3)[index]
    R_x, R_y = (np.einsum("ns,nsc->nc", shape[d], vectors) for d in (1, 2))
    area = np.linalg.norm(np.cross(R_x, R_y), axis=1) * np.tile(weights, n)
    assert 0.5 * np.einsum("n,ni,ij,nj->", area, found.strains, C, found.strains) == pytest.approx(
        block.energy(0.0, q), rel=1e-11 if turns is not None else 1e-12
    )
    along = recovery.at(q, index, xi + size, eta).r - found.r
    across = recovery.at(q, index, xi, eta + size).r - found.r
    assert np.abs(np.einsum("nc,nc->n", found.n, along)).max() < 1e-3 * size  # the tangent plane, but for curvature over size
    normal = np.cross(along, across)
    np.testing.assert_allclose(found.n, normal / np.linalg.norm(normal, axis=1, keepdims=True), atol=1e-3)


@pytest.mark.parametrize("n", [1, 7, 8, 9])
def test_filling_up_the_last_block_changes_nothing(element, rng, n):
    xs = np.linspace(0.0, 1.0, n + 1)
    mesh, C = patch(element, xs, [0.0, 1.0]), section(rng)
    model = SHELLS[element.name].strain_models["exact"]
    q = deformed(mesh, rng, 0.01)
    f, K = dense(model("plate", *mesh.tables, C), q)
    singly = [model("plate", *(table[k : k + 1] for table in mesh.tables), C) for k in range(n)]
    parts = [dense(block, q) for block in singly]
    np.testing.assert_allclose(f, sum(part[0] for part in parts), atol=1e-13 * np.abs(f).max())
    np.testing.assert_allclose(K, sum(part[1] for part in parts), atol=1e-13 * np.abs(K).max())
    assert model("plate", *mesh.tables, C).energy(0.0, q) == pytest.approx(sum(b.energy(0.0, q) for b in singly), rel=1e-13)


def test_section_may_differ_from_element_to_element(mesh, rng):
    model = SHELLS[mesh.element.name].strain_models["exact"]
    sections = np.array([section(rng) for _ in mesh.coords])
    q = deformed(mesh, rng)
    singly = [model("p", *(t[k : k + 1] for t in mesh.tables), C).energy(0.0, q) for k, C in enumerate(sections)]
    assert model("plate", *mesh.tables, sections).energy(0.0, q) == pytest.approx(sum(singly), rel=1e-13)


# --- linear strains -------------------------------------------------------------------------------


def test_linear_block_is_the_tangent_plane_of_the_exact_one(mesh, rng, options):
    models, C = SHELLS[mesh.element.name].strain_models, Section(section(rng), **options)
    linear, full = (models[name]("plate", *mesh.tables, C) for name in ("linear", "exact"))
    f, K = dense(linear, mesh.rest, alpha_q=0.5)
    np.testing.assert_allclose(f, 0.0, atol=1e-12 * np.abs(K).max())
    np.testing.assert_allclose(2 * K, dense(full, mesh.rest)[1], atol=1e-12 * np.abs(K).max())
    d = rng.standard_normal(mesh.rest.shape)
    np.testing.assert_allclose(gathered_force(linear, mesh.rest + d), 2 * K @ d, atol=1e-11 * np.abs(K @ d).max())
    assert linear.energy(0.0, mesh.rest + d) == pytest.approx(d @ K @ d, rel=1e-11)
    errors = [
        np.abs(gathered_force(full, mesh.rest + h * d) - gathered_force(linear, mesh.rest + h * d)).max() for h in (2e-5, 1e-5)
    ]
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.01)  # quadratic remainder


# --- linear strains in moving frames -----------------------------------------------------------------


MOVING = ["floating", "floating at x-", "floating at x+", "floating at y-", "floating at y+", "corotational"]


def moving_block(name, mesh, stiffness, label="plate"):
    """A strain model in moving frames by its name, and the edge that its frame follows."""
    model, _, edge = name.partition(" at ")
    place = {"frame_at": edge} if edge else {}
    return SHELLS[mesh.element.name].strain_models[model](label, *mesh.tables, stiffness, **place)


@pytest.fixture(params=MOVING)
def moving(request, mesh, rng):
    return moving_block(request.param, mesh, section(rng))


def moved(mesh, q, rng):
    return turned(q, mesh.is_position, random_rotation(rng), 3.0 * rng.standard_normal(3))


def test_rigid_motion_gives_no_force_in_a_moving_frame(mesh, moving, rng):
    q, typical = moved(mesh, mesh.rest, rng), deformed(mesh, rng)
    # deviations of rounding size, 1e-15, give forces of that size and energies of its square
    assert np.abs(gathered_force(moving, q)).max() < 1e-12 * np.abs(gathered_force(moving, typical)).max()
    assert 0 <= moving.energy(0.0, q) < 1e-24 * moving.energy(0.0, typical)


def test_force_in_a_moving_frame_turns_with_the_configuration(mesh, moving, rng):
    q, R = deformed(mesh, rng), random_rotation(rng)
    after = turned(q, mesh.is_position, R, np.array([1.0, -2.0, 0.5]))
    expected = (gathered_force(moving, q).reshape(-1, 3) @ R.T).reshape(-1)
    np.testing.assert_allclose(gathered_force(moving, after), expected, atol=1e-11 * np.abs(expected).max())
    assert moving.energy(0.0, after) == pytest.approx(moving.energy(0.0, q), rel=1e-11)


def test_force_in_a_moving_frame_has_no_resultant_and_no_torque(mesh, moving, rng):
    q = moved(mesh, deformed(mesh, rng, 0.2), rng).reshape(-1, 3)
    f = gathered_force(moving, q.reshape(-1)).reshape(-1, 3)
    size = np.abs(f).sum()
    np.testing.assert_allclose(f[mesh.is_position].sum(axis=0), 0.0, atol=1e-13 * size)
    np.testing.assert_allclose(np.cross(q, f).sum(axis=0), 0.0, atol=1e-13 * size * np.abs(q).max())


def test_force_in_a_moving_frame_is_the_derivative_of_the_energy(mesh, moving, rng):
    q, d = moved(mesh, deformed(mesh, rng, 0.2), rng), rng.standard_normal(mesh.rest.shape)
    step = 2e-4
    numeric = derivative(lambda h: moving.energy(0.0, q + h * d), step)
    rounding = 10 * np.finfo(float).eps * moving.energy(0.0, q) / step  # all that is left where d is nearly normal to the force
    assert gathered_force(moving, q) @ d == pytest.approx(numeric, rel=1e-9, abs=rounding)


def test_tangent_in_a_moving_frame_is_the_derivative_of_the_force(mesh, moving, rng):
    q, d = moved(mesh, deformed(mesh, rng, 0.2), rng), rng.standard_normal(mesh.rest.shape)
    f, K = dense(moving, q, alpha_q=0.7)
    numeric = derivative(lambda h: gathered_force(moving, q + h * d), 2e-4)
    np.testing.assert_allclose(f, gathered_force(moving, q), rtol=1e-12, atol=1e-12 * np.abs(f).max())
    np.testing.assert_allclose(K @ d, 0.7 * numeric, atol=1e-9 * np.abs(numeric).max())


@pytest.mark.parametrize("name", MOVING)
def test_moving_frames_share_the_tangent_of_the_reference(mesh, rng, name):
    models, C = SHELLS[mesh.element.name].strain_models, section(rng)
    K = dense(models["linear"]("plate", *mesh.tables, C), mesh.rest)[1]
    np.testing.assert_allclose(dense(moving_block(name, mesh, C), mesh.rest)[1], K, atol=1e-12 * np.abs(K).max())


def test_one_element_has_the_same_energy_in_both_frames(element, rng):
    models, C = SHELLS[element.name].strain_models, section(rng)
    mesh = patch(element, XS[:2], YS[:2], SURFACES["twisted"])
    q = deformed(mesh, rng)
    body, single = (models[name]("plate", *mesh.tables, C) for name in ("floating", "corotational"))
    assert body.energy(0.0, q) == pytest.approx(single.energy(0.0, q), rel=1e-12)


def test_frames_follow_the_mean_gradient(element, rng):
    mesh, F = patch(element, XS, YS), rng.standard_normal((3, 3))
    vectors = mesh.rest.reshape(-1, 3) @ F.T
    for name in MOVING:
        groups = moving_block(name, mesh, section(rng)).groups
        found = groups.weights @ vectors.reshape(-1)[groups.coords]
        np.testing.assert_allclose(found, np.broadcast_to(F[:, :2].T, found.shape), atol=1e-14 * len(vectors))


@pytest.mark.parametrize("side", ["x-", "x+", "y-", "y+"])
def test_a_frame_at_an_edge_follows_the_mean_slopes_there(element, rng, side):
    """The means of r_x and r_y over the reference length, by the trapezoidal rule on many points of the deformed patch."""
    mesh = patch(element, XS, YS, SURFACES["twisted"])
    q = deformed(mesh, rng)
    groups = moving_block(f"floating at {side}", mesh, section(rng)).groups
    found = groups.weights[0] @ q[groups.coords[0]]
    nx, ny, fixed, value = len(XS) - 1, len(YS) - 1, "xy".index(side[0]), float(side[1] == "+")
    own = {"x-": range(0, nx * ny, nx), "x+": range(nx - 1, nx * ny, nx), "y-": range(nx), "y+": range(nx * ny - nx, nx * ny)}[
        side
    ]
    s = np.linspace(0.0, 1.0, 2001)
    parameters = [s, s]
    parameters[fixed] = np.full_like(s, value)
    shape, total, sums = element.shape(*parameters), 0.0, np.zeros((2, 3))
    for k in own:
        lengths = mesh.scale[k].reshape(-1, 3)[[element.vector_names.index("r_x"), element.vector_names.index("r_y")], 0]
        now, rest = ((v * mesh.scale[k]).reshape(-1, 3) for v in (q[mesh.coords[k]], mesh.reference[k]))
        ds = np.linalg.norm(shape[2 - fixed] @ rest, axis=1)
        total += np.trapezoid(ds, s)
        sums += [np.trapezoid(ds[:, None] * (shape[1 + i] @ now) / lengths[i], s, axis=0) for i in (0, 1)]
    # the rule's error is h^2 / 12 = 2e-8 times second derivatives of order one
    np.testing.assert_allclose(found, sums / total, atol=1e-7)


def test_a_configuration_without_a_frame_gives_no_number(mesh, moving):
    flattened = mesh.rest.reshape(-1, 3) * [1.0, 0.0, 0.0]  # all on a line
    assert np.isnan(gathered_force(moving, flattened.reshape(-1))).all()


def test_a_closed_ring_has_no_floating_frame(element, rng):
    models, C = SHELLS[element.name].strain_models, section(rng)
    ring = patch(element, np.linspace(0.0, 2 * np.pi * 1.3, 9), [0.0, 1.0], SURFACES["cylinder"])
    with pytest.raises(ModelError, match="ring: the mean of r_x and r_y over the reference has no direction"):
        models["floating"]("ring", *ring.tables, C)
    with pytest.raises(ModelError, match="ring: the mean of r_x and r_y over the reference has no direction"):
        moving_block("floating at y-", ring, C, "ring")
    block, q = models["corotational"]("ring", *ring.tables, C), moved(ring, ring.rest, rng)
    assert block.energy(0.0, q) < 1e-24 * block.energy(0.0, deformed(ring, rng))


def test_a_surface_that_ends_nowhere_has_no_frame_at_an_edge(element, rng):
    """The last nodes of a closed ring are its first."""
    n = 8
    ring = patch(element, np.linspace(0.0, 2 * np.pi * 1.3, n + 1), [0.0, 1.0], SURFACES["cylinder"])
    width = 3 * element.vectors_per_node
    node, place = np.divmod(ring.coords, width)
    joined = replace(ring, coords=width * np.where(node % (n + 1) == n, node - n, node) + place)
    with pytest.raises(ModelError, match=r"ring: the surface has no edge x\+ for a frame; accepted are edges where"):
        moving_block("floating at x+", joined, section(rng), "ring")


# --- inertia --------------------------------------------------------------------------------------


def mass_matrix(mesh, density):
    inertia = SHELLS[mesh.element.name].inertia("plate", mesh.tables, density)
    return whole_mass(vector_mass([inertia], len(mesh.rest) // 3), len(mesh.rest)).toarray()


def test_mass_is_symmetric_positive_and_carries_rigid_translation(mesh):
    M = mass_matrix(mesh, 2.5)
    np.testing.assert_allclose(M, M.T, atol=1e-15)
    assert np.linalg.eigvalsh(M).min() > 0
    v = np.zeros((len(mesh.is_position), 3))
    v[mesh.is_position] = [3.0, 0.0, 4.0]
    recovery = ShellRecovery(mesh.element, *mesh.tables)
    area = surface_area(mesh)
    assert v.reshape(-1) @ M @ v.reshape(-1) == pytest.approx(2.5 * area * 25.0, rel=1e-12)
    assert recovery.at(mesh.rest, np.array([0]), np.array([0.0]), np.array([0.0])).r[0] == pytest.approx(mesh.rest[:3])


def surface_area(mesh):
    xi, eta, weights = gauss_points(4)
    vectors = (mesh.reference * mesh.scale).reshape(len(mesh.coords), -1, 3)
    _, R_x, R_y = np.einsum("dgs,esc->degc", mesh.element.shape(xi, eta)[:3], vectors)
    return (np.linalg.norm(np.cross(R_x, R_y), axis=-1) @ weights).sum()


# --- damping --------------------------------------------------------------------------------------


def viscous(mesh, rng, options=OPTIONS["unit"]):
    return SHELLS[mesh.element.name].viscous("plate", *mesh.tables, Section(section(rng), **options), 0.3)


def test_damping_leaves_rigid_motion_alone(mesh, rng, options):
    block, q = viscous(mesh, rng, options), deformed(mesh, rng)
    spin = np.cross(rng.standard_normal(3), q.reshape(-1, 3))
    spin[mesh.is_position] += rng.standard_normal(3)
    typical = gathered_force(block, q, rng.standard_normal(q.shape))
    assert np.abs(gathered_force(block, q, spin.reshape(-1))).max() < 1e-12 * np.abs(typical).max()
    assert 0 <= block.dissipation(0.0, q, spin.reshape(-1)) < 1e-20 * block.dissipation(0.0, q, rng.standard_normal(q.shape))


def test_damping_force_is_the_rate_of_the_elastic_one_in_its_power(mesh, rng, options):
    block, q, v = viscous(mesh, rng, options), deformed(mesh, rng), rng.standard_normal(mesh.rest.shape)
    assert gathered_force(block, q, v) @ v == pytest.approx(block.dissipation(0.0, q, v), rel=1e-12)
    assert block.dissipation(0.0, q, v) > 0
    assert block.energy(0.0, q) == 0.0


def test_damping_at_rest_is_the_elastic_stiffness_times_the_retardation_time(mesh, options):
    damper = viscous(mesh, np.random.default_rng(3), options)
    shell = exact(mesh, np.random.default_rng(3), options=options)
    D = dense(damper, mesh.rest, 0.0 * mesh.rest, 0.0, 1.0)[1]
    K = dense(shell, mesh.rest)[1]
    np.testing.assert_allclose(D, 0.3 * K, atol=1e-12 * np.abs(K).max())


@pytest.mark.parametrize(("alpha_q", "alpha_v"), [(1.0, 0.0), (0.0, 1.0), (1.3, 0.7)])
def test_damping_tangent(mesh, rng, options, alpha_q, alpha_v):
    block, q, v, d = viscous(mesh, rng, options), deformed(mesh, rng), *rng.standard_normal((2, len(mesh.rest)))
    f, K = dense(block, q, v, alpha_q, alpha_v)
    numeric = derivative(lambda h: gathered_force(block, q + alpha_q * h * d, v + alpha_v * h * d), 2e-4)
    np.testing.assert_allclose(f, gathered_force(block, q, v), rtol=1e-14)
    np.testing.assert_allclose(K @ d, numeric, atol=1e-9 * np.abs(numeric).max())


def test_damped_shell_is_the_sum_of_both_blocks(mesh, rng, options):
    """With the extrapolated geometric part of the elastic one, and energy and power apart."""
    C = section(rng)
    shells = SHELLS[mesh.element.name]
    both = shells.damped("plate", *mesh.tables, Section(C, **options), 0.3)
    parts = (
        shells.strain_models["exact"]("plate", *mesh.tables, Section(C, **options)),
        shells.viscous("plate", *mesh.tables, Section(C, **options), 0.3),
    )
    q, v, previous = deformed(mesh, rng), rng.standard_normal(mesh.rest.shape), deformed(mesh, rng)
    for earlier in (q, previous):
        (f, K), *of_parts = (tangent_from(block, q, v, 1.3, 0.7, earlier) for block in (both, *parts))
        expected = sum(part[0] for part in of_parts), sum(part[1] for part in of_parts)
        np.testing.assert_allclose(f, expected[0], atol=1e-12 * np.abs(expected[0]).max())
        np.testing.assert_allclose(K, expected[1], atol=1e-12 * np.abs(expected[1]).max())
    assert both.energy(0.0, q) == pytest.approx(parts[0].energy(0.0, q), rel=1e-12)
    assert both.dissipation(0.0, q, v) == pytest.approx(parts[1].dissipation(0.0, q, v), rel=1e-12)
    damping, viscous = aligned(len(both.f_coords)), aligned(len(both.f_coords))
    both.damping_force(0.0, q, v, damping)
    parts[1].force(0.0, q, v, viscous)
    np.testing.assert_array_equal(damping, viscous)


def tangent_from(block, q, v, alpha_q, alpha_v, previous):
    """Force and full tangent as sums over the block's buffers."""
    buffer, k = aligned(len(block.f_coords)), aligned(len(block.k_rows))
    block.force_tangent(0.0, q, v, alpha_q, alpha_v, previous, buffer, k)
    f, K = np.zeros(len(q)), np.zeros((len(q),) * 2)
    used = block.f_coords >= 0
    np.add.at(f, block.f_coords[used], (buffer * block.f_scale)[used])
    used = block.k_rows >= 0
    rows, cols, values = block.k_rows[used], block.k_cols[used], (k * block.k_scale)[used]
    np.add.at(K, (rows, cols), values)
    if block.symmetry == "symmetric":
        off = rows != cols
        np.add.at(K, (cols[off], rows[off]), values[off])
    return f, K


# --- damping of small-deformation models --------------------------------------------------------------


def small_damper(name, mesh, stiffness, time=0.3):
    shell = moving_block(name, mesh, stiffness)
    return small_damping(shell, time)


@pytest.fixture(params=MOVING)
def moving_damper(request, mesh, rng):
    return small_damper(request.param, mesh, section(rng))


def test_damping_in_a_moving_frame_leaves_rigid_motion_alone(mesh, moving_damper, rng):
    q = moved(mesh, deformed(mesh, rng, 0.2), rng)
    spin = np.cross(rng.standard_normal(3), q.reshape(-1, 3))
    spin[mesh.is_position] += rng.standard_normal(3)
    spin, typical = spin.reshape(-1), rng.standard_normal(q.shape)
    assert np.abs(gathered_force(moving_damper, q, spin)).max() < 1e-11 * np.abs(gathered_force(moving_damper, q, typical)).max()
    assert 0 <= moving_damper.dissipation(0.0, q, spin) < 1e-20 * moving_damper.dissipation(0.0, q, typical)


def test_damping_in_a_moving_frame_is_the_rate_of_its_own_strains(mesh, moving_damper, rng):
    """f = c B^T K0 B v, with B v the rate of y = R^T x - X along the motion, here by differences."""
    q, v, d = moved(mesh, deformed(mesh, rng, 0.2), rng), *rng.standard_normal((2, len(mesh.rest)))
    groups = moving_damper.groups

    def rate(direction):
        return derivative(lambda h: framed_shape(groups, q + h * direction).y, 2e-4).reshape(len(groups.coords), -1)

    power = 0.3 * sum(b @ K @ a for a, b, K in zip(rate(v), rate(d), groups.stiffness, strict=True))
    assert gathered_force(moving_damper, q, v) @ d == pytest.approx(power, rel=1e-8)
    assert gathered_force(moving_damper, q, v) @ v == pytest.approx(moving_damper.dissipation(0.0, q, v), rel=1e-12)
    assert moving_damper.dissipation(0.0, q, v) > 0
    assert moving_damper.energy(0.0, q) == 0.0


@pytest.mark.parametrize(("alpha_q", "alpha_v"), [(1.0, 0.0), (0.0, 1.0), (1.3, 0.7)])
def test_damping_tangent_in_a_moving_frame(mesh, moving_damper, rng, alpha_q, alpha_v):
    q, v, d = moved(mesh, deformed(mesh, rng, 0.2), rng), *rng.standard_normal((2, len(mesh.rest)))
    f, K = dense(moving_damper, q, v, alpha_q, alpha_v)
    numeric = derivative(lambda h: gathered_force(moving_damper, q + alpha_q * h * d, v + alpha_v * h * d), 2e-4)
    np.testing.assert_allclose(f, gathered_force(moving_damper, q, v), rtol=1e-12, atol=1e-12 * np.abs(f).max())
    np.testing.assert_allclose(K @ d, numeric, atol=1e-9 * np.abs(numeric).max())
    if alpha_q == 0.0:
        np.testing.assert_allclose(K, K.T, atol=1e-12 * np.abs(K).max())


@pytest.mark.parametrize("name", ["linear", *MOVING])
def test_small_dampers_share_the_matrix_of_the_reference(mesh, rng, name):
    C, v = section(rng), rng.standard_normal(mesh.rest.shape)
    K = dense(moving_block("linear", mesh, C), mesh.rest)[1]
    block = small_damper(name, mesh, C)
    f, D = dense(block, mesh.rest, v, 0.0, 0.7)
    np.testing.assert_allclose(D, 0.7 * 0.3 * K, atol=1e-12 * np.abs(K).max())
    np.testing.assert_allclose(f, 0.3 * K @ v, atol=1e-11 * np.abs(f).max())
    assert block.dissipation(0.0, mesh.rest, v) == pytest.approx(0.3 * v @ K @ v, rel=1e-11)
    if name == "linear":  # constant, wherever the plate is
        np.testing.assert_allclose(gathered_force(block, deformed(mesh, rng), v), f, atol=1e-13 * np.abs(f).max())


# --- mass damping -------------------------------------------------------------------------------------


def test_mass_damping_is_a_constant_matrix(mesh, rng):
    inertia = SHELLS[mesh.element.name].inertia("plate", mesh.tables, 2.5)
    block, v = MassDampingBlock("plate", inertia, 0.2), rng.standard_normal(mesh.rest.shape)
    M = mass_matrix(mesh, 2.5)
    f, D = dense(block, mesh.rest, v, 1.0, 3.0)
    np.testing.assert_allclose(D, 0.6 * M, atol=1e-15)
    np.testing.assert_allclose(f, 0.2 * M @ v, atol=1e-14)
    assert block.dissipation(0.0, mesh.rest, v) == pytest.approx(0.2 * v @ M @ v, rel=1e-12)


# --- messages -------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["exact", "linear", "floating", "corotational"])
def test_impossible_input_is_refused_with_one_message(element, rng, name):
    mesh, C = patch(element, [0.0, 1.0], [0.0, 1.0]), section(rng)
    shell = SHELLS[element.name]
    model = shell.strain_models[name]
    with pytest.raises(ModelError, match="wing: element tables have shapes"):
        model("wing", mesh.coords[:, :24], mesh.scale, mesh.reference, C)
    with pytest.raises(ModelError, match="wing: stiffness has shape"):
        model("wing", *mesh.tables, C[:3, :3])
    with pytest.raises(ModelError, match="not symmetric"):
        model("wing", *mesh.tables, np.triu(C))
    with pytest.raises(ModelError, match="n_gauss = 1"):
        model("wing", *mesh.tables, C, 1)
    with pytest.raises(ModelError, match="wing: element 0 has no area"):
        model("wing", mesh.coords, mesh.scale, 0.0 * mesh.reference, C)
    with pytest.raises(ModelError, match="mass per area is -1"):
        shell.inertia("wing", mesh.tables, -1.0)
