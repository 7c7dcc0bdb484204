"""What a shell must fulfil on every surface, from its declaration to files and pictures."""

from __future__ import annotations

import numpy as np
import pytest
from shell_patch import dense, derivative, gathered_force

import lamella as lm
from lamella.errors import DeclarationError, ResultFileError
from lamella.io.model_file import dumps, loads
from lamella.io.vtk import write_vtkhdf
from lamella.viz.fields import FIELDS, SurfaceSampler

RING = [(np.cos(a), np.sin(a)) for a in np.linspace(0.0, 2.0 * np.pi, 12, endpoint=False)]
SURFACES = {
    "cylinder": lm.CylinderSurface(radius=0.7, length=1.2, angle=(0.2, 1.9)),
    "belt": lm.BeltSurface(length=2.5, width=0.8),
    "cone": lm.ConeSurface(radii=(0.5, 0.9), height=1.1, closed=True),
    "sphere": lm.SphereSurface(radius=1.3, latitude=(-0.3, 1.1), angle=(0.0, 2.0)),
    "annulus": lm.AnnulusSurface(radii=(0.6, 1.0), closed=True),
    "points": lm.PointSurface([[(x, y, z) for x, y in RING] for z in (0.0, 0.4, 0.8)], closed="x"),
    "function": lm.FunctionSurface(lambda x, y: np.stack([x, y, 0.2 * np.sin(2 * x) * np.cos(y)], axis=1), lengths=(1.5, 1.0)),
}
MESH = (6, 3)
PLY = lm.Lamina(E1=10e9, E2=1e9, nu12=0.3, G12=0.5e9, rho=1500.0)
LAYUP = lm.Laminate(PLY, angles=(0, 30), thickness=0.01)
TAPER = [[0.6 + 0.1 * i + 0.2 * j for i in range(MESH[0])] for j in range(MESH[1])]
OPTIONS = {
    "plain": {},
    "tapered": {"thickness_factors": TAPER},
    "directed": {"ply_direction": (1.0, 0.0, -1.0)},
    "stretched": {"prestrain": (2e-3, -1e-3, 1e-3)},
    "reduced": {"membrane_gauss": 3},
    "plate36": {"element": "plate36"},
    "bent": {"stress_free": "flat"},
    "all": {"thickness_factors": TAPER, "prestrain": (2e-3, -1e-3, 1e-3), "membrane_gauss": 3, "element": "plate36"},
}
"""``flat`` stands for a flat sheet of the surface's lengths."""


@pytest.fixture(params=list(SURFACES))
def surface(request):
    return SURFACES[request.param]


def flat(surface):
    """A flat sheet of the surface's lengths."""
    return lm.FunctionSurface(lambda x, y: np.stack([x, y, np.zeros_like(x)], axis=1), surface.size)


def compiled(surface, **options):
    if options.get("stress_free") == "flat":
        options["stress_free"] = flat(surface)
    system = lm.System()
    system.add(lm.Shell("shell", surface, MESH, LAYUP, rotation=(0.1, -0.4, 0.3), position=(1, 2, 3), **options))
    return system.compile()


# --- force, energy, tangent -----------------------------------------------------------------------


@pytest.mark.parametrize("options", list(OPTIONS.values()), ids=list(OPTIONS))
def test_force_is_the_derivative_of_the_energy_and_tangent_that_of_the_force(surface, options):
    model = compiled(surface, **options)
    (shell,), mesh = model.forces, model.plates[0]
    rng = np.random.default_rng(5)
    size = np.repeat(np.tile(mesh.element.magnitudes(min(mesh.lx, mesh.ly)), mesh.n_nodes), 3)
    q = model.q0 + 0.03 * size * rng.uniform(-1, 1, model.n_q)
    force, K = dense(shell, q)
    for _ in range(3):
        way = size * rng.uniform(-1, 1, model.n_q)
        slope = derivative(lambda h, way=way: shell.energy(0.0, q + h * way), 1e-3)
        # differences of order eight: (1e-3)^8, and rounding 1e-16 / 1e-3 of energy and force
        assert force @ way == pytest.approx(slope, abs=1e-9 * np.abs(force * way).sum())
        bent = size * derivative(lambda h, way=way: gathered_force(shell, q + h * way), 1e-3)
        np.testing.assert_allclose(size * (K @ way), bent, rtol=0, atol=1e-9 * np.abs(bent).max())


def test_a_shell_rests_where_it_has_no_stress(surface):
    model = compiled(surface, thickness_factors=TAPER, ply_direction=(1.0, 0.0, -1.0))
    (shell,) = model.forces
    dilated = gathered_force(shell, 1.001 * model.q0)
    np.testing.assert_allclose(gathered_force(shell, model.q0), 0.0, atol=1e-11 * np.abs(dilated).max())  # rounding over 1e-3


def test_flat_sheet_in_another_place_is_not_bent():
    """The stress-free surface counts by its shape, not by where it lies."""
    sheet = lm.FunctionSurface(lambda x, y: np.stack([0 * x, x + 5.0, y - 3.0], axis=1), (1.5, 1.0))
    model = compiled(lm.FunctionSurface(lambda x, y: np.stack([x, y, 0 * x], axis=1), (1.5, 1.0)), stress_free=sheet)
    (shell,) = model.forces
    # the series of the functions are exact to 1e-10, beside strains of 1e-3
    assert shell.energy(0.0, model.q0) < 1e-14 * shell.energy(0.0, 1.001 * model.q0)


def test_pressure_on_a_closed_shell_held_at_both_ends_is_nearly_symmetric():
    def pressed(*sides, **options):
        system = lm.System()
        shell = system.add(lm.Shell("shell", lm.CylinderSurface(0.7, 1.2, closed=options["closed"]), MESH, LAYUP))
        for side in sides:
            system.add(lm.Clamp(side, shell.edge(side)))
        system.add(lm.Pressure("inside", shell, -100.0))
        (block,) = system.compile().loads
        return block.symmetry

    assert pressed("y-", "y+", closed=True) == "nearly"  # where it is closed there is no edge to hold
    assert pressed("y-", closed=True) == "none"
    assert pressed("y-", "y+", closed=False) == "none"


# --- sections -------------------------------------------------------------------------------------


def test_energy_density_is_that_of_each_element_at_its_thickness():
    model = compiled(SURFACES["cylinder"], thickness_factors=TAPER)
    mesh = model.plates[0]
    rng = np.random.default_rng(5)
    sample = mesh.sample(model.q0 + 0.005 * model.magnitude * rng.uniform(-1, 1, model.n_q), per_element=2)
    density = sample.energy_density()
    for element in range(MESH[0] * MESH[1]):
        j, i = divmod(element, MESH[0])
        e = sample.strains[2 * j + 1, 2 * i + 1]  # the middle
        assert density[2 * j + 1, 2 * i + 1] == pytest.approx(0.5 * e @ mesh.section.stiffness[element] @ e, rel=1e-12)


def test_temperatures_of_a_plate_of_varying_thickness_are_refused():
    warm = lm.Isotropic(E=70e9, nu=0.3, rho=2700, alpha=2e-5, k=200.0, c=900.0)
    system = lm.System()
    plate = system.add(lm.Plate("plate", (1, 1), MESH, lm.Laminate(warm, thickness=1e-3), thickness_factors=TAPER))
    system.add(lm.TemperatureField("heat", plate))
    with pytest.raises(DeclarationError, match=r"TemperatureField 'heat': plate 'plate' has thickness_factors; accepted"):
        system.compile()


# --- files and pictures ---------------------------------------------------------------------------


def loaded(surface):
    """A shell held at one edge, or at all its nodes around, with a marker and every option that a file can hold."""
    system = lm.System()
    options = OPTIONS["all"] | {"markers": {"point": (0.4, 0.3)}, "damping": 1e-3, "velocity": (0.0, 0.0, 0.1)}
    shell = system.add(lm.Shell("shell", surface, MESH, LAYUP, **options))
    system.add(lm.Clamp("root", shell.edge("x-" if surface.loops[1] else "y-")))
    system.add(lm.Pressure("inside", shell, -200.0))
    return system


def test_model_file_holds_the_surface(surface):
    system = loaded(surface)
    if surface.python_only:
        with pytest.raises(DeclarationError, match="is a Python function, which a model file cannot hold"):
            dumps(system)
        return
    text = dumps(system)
    again = loads(text).system
    assert again.declarations[0] == system.declarations[0]
    assert dumps(again) == text


def test_model_file_holds_the_stress_free_surface():
    shell = lm.Shell("s", SURFACES["cone"], MESH, LAYUP, stress_free=lm.AnnulusSurface(radii=(0.5, 0.9), angle=(0.0, 5.0)))
    system = lm.System()
    system.add(shell)
    text = dumps(system)
    assert "stress_free:" in text
    assert loads(text).system.declarations[0] == shell


def test_result_is_stored_and_read_back(surface, tmp_path):
    result = lm.equilibrium(loaded(surface))
    stored = lm.read_result(result.save(tmp_path / "run.h5"))
    np.testing.assert_array_equal(stored["point.position"], result["point.position"])
    if surface.python_only:
        with pytest.raises(ResultFileError, match="holds no model"):
            stored.plate("shell")
        return
    new, old = stored.plate("shell"), result.plate("shell")
    for name in ("r", "n", "strains", "thickness_factors"):
        np.testing.assert_array_equal(getattr(new, name), getattr(old, name))
    np.testing.assert_array_equal(new.section_forces(), old.section_forces())


def test_fields_and_paraview_of_a_shell(surface, tmp_path):
    result = lm.equilibrium(loaded(surface))
    (shot,) = SurfaceSampler(result, 3).at(len(result.frame_at) - 1)
    for name in ("displacement", "membrane_strain", "strain_energy_density", "von_mises"):
        assert np.isfinite(FIELDS[name].evaluate(shot)).all()
    r = shot.now.r
    for axis, closed in enumerate(surface.loops):
        ends = (r[:, 0], r[:, -1]) if axis == 0 else (r[0], r[-1])
        gap = np.linalg.norm(ends[0] - ends[1], axis=-1).max()
        assert (gap < 1e-12) == closed  # the surface drawn is closed as the shell is
    assert write_vtkhdf(result, tmp_path / "surface.vtkhdf", per_element=2).stat().st_size > 0
