"""Simply supported [0/90/0] plates under a sinusoidal pressure."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from itertools import product

import numpy as np

import lamella as lm
from lamella.declaration import declaration
from lamella.dofs import Build
from lamella.load.dead import add_dead_load
from lamella.material.recovery import ply_stress
from lamella.math.gauss import gauss_rule
from lamella.math.profile import Constant
from lamella.result import Result
from lamella.roles import Declaration, Floats
from lamella.verification import Evidence, Orders, References, Shape

slow = False

SIDE, THICKNESS, PRESSURE, E_T = 1.0, 0.01, 1e-3, 1e9
PLY = lm.Lamina(E1=25 * E_T, E2=E_T, G12=0.5 * E_T, nu12=0.25, rho=1600)
LAMINATE = lm.Laminate(PLY, angles=(0, 90, 0), thickness=THICKNESS)


@declaration
class SinusoidalForce(Declaration):
    """A dead force per area along z, q0 sin(pi x / a) sin(pi y / b), on a plate of a x b; ``amplitude`` is q0 [Pa]."""

    name: str
    on: lm.Plate
    amplitude: float

    def contribute(self, build: Build) -> None:
        """Integrate with 4 x 4 Gauss points in each element."""
        mesh = self.on.compiled(build)
        places, weights = gauss_rule(4)
        x, wx = _points(mesh.nx, mesh.lx, places, weights)
        y, wy = _points(mesh.ny, mesh.ly, places, weights)
        rows = mesh.locate_each([*product(x, y)])
        values = self.amplitude * np.outer(wx * np.sin(np.pi * x / self.on.size[0]), wy * np.sin(np.pi * y / self.on.size[1]))
        shares = [value * row.position for value, row in zip(values.reshape(-1), rows, strict=True)]
        vectors = np.concatenate([row.vectors for row in rows])
        add_dead_load(build, self.name, vectors, np.outer(np.concatenate(shares), (0.0, 0.0, 1.0)), Constant(1.0))


def _points(count: int, length: float, places: Floats, weights: Floats) -> tuple[Floats, Floats]:
    """Gauss points along one side of the plate and their weights [m]."""
    return ((np.arange(count)[:, None] + places) * length).reshape(-1), np.tile(weights, count) * length


def run() -> Iterator[Evidence]:
    """Yield the checks and pictures of this case."""
    references = References.beside(__file__)
    for name, width in (("b = 3a", 3 * SIDE), ("b = a", SIDE)):
        computed, exact = normalised(loaded(width)), kirchhoff(width)
        yield replace(
            references.check("w, Kirchhoff", computed[0] / exact[0]), quantity=f"w, {name}, over that of Kirchhoff's theory"
        )
        for quantity, stress, closed in zip(("sigma_x", "sigma_y"), computed[1:], exact[1:], strict=True):
            ratio = references.check("stress, Kirchhoff", stress / closed)
            yield replace(ratio, quantity=f"{quantity}, {name}, over that of Kirchhoff's theory")
        if name == "b = 3a":
            yield references.check("w, b = 3a, elasticity", computed[0])
        else:
            yield references.check("sigma_x, b = a, elasticity", computed[1])
    closed = kirchhoff(SIDE)[0]
    meshes = {n: loaded(SIDE, n) for n in (4, 8)}
    errors = [normalised(result)[0] - closed for result in meshes.values()]
    yield references.check("order of convergence of w", np.log2(errors[0] / errors[1]))
    yield Orders(
        "Deflection of the square plate", "Element [m]", {"w": ([SIDE / n for n in meshes], np.abs(errors) / closed)}, (4,)
    )
    yield Shape("Stress on top, displacement × 1e4", meshes[8], field="von_mises_top", scale=1e4)


def loaded(width: float, n: int = 16) -> Result:
    """Equilibrium on n x n elements; the edges are held along z and may move in their plane."""
    system = lm.System()
    plate = system.add(lm.Plate("plate", (SIDE, width), (n, n), LAMINATE))
    plate.marker("centre", SIDE / 2, width / 2)
    for side in ("x-", "x+", "y-", "y+"):
        system.add(lm.EdgeSupport(side, plate.edge(side), axes="z"))
    system.add(lm.PointSupport("pin", plate.corner("x-y-"), axes="xy"))
    system.add(lm.PointSupport("line", plate.corner("x+y-"), axes="y"))
    system.add(SinusoidalForce("pressure", plate, PRESSURE))
    return lm.equilibrium(system, newton=lm.Newton(tolerance=1e-12, keep=0.0))


def normalised(result: Result) -> tuple[float, float, float]:
    """w = 100 E_T h^3 w / (q0 a^4) and sigma = sigma h^2 / (q0 a^2) at the centre.

    sigma_x is taken on top of the plate, sigma_y on top of the middle ply.
    """
    sample = result.model.plates[0].sample(result.final.q)
    strains = sample.strains[len(sample.y) // 2, len(sample.x) // 2]
    scale = THICKNESS**2 / (PRESSURE * SIDE**2)
    deflection = float(result["centre.position"][2])
    top, middle = ply_stress(LAMINATE, strains, 2, "top"), ply_stress(LAMINATE, strains, 1, "top")
    return 100 * E_T * THICKNESS**3 * deflection / (PRESSURE * SIDE**4), float(top[0]) * scale, float(middle[1]) * scale


def kirchhoff(width: float) -> tuple[float, float, float]:
    """The same three numbers of classical lamination theory, with w = q0 / (D11 p^4 + 2 (D12 + 2 D66) p^2 q^2 + D22 q^4)."""
    p2, q2 = (np.pi / SIDE) ** 2, (np.pi / width) ** 2
    D, Q = LAMINATE.D, LAMINATE.Dk
    w = 1 / (D[0, 0] * p2**2 + 2 * (D[0, 1] + 2 * D[2, 2]) * p2 * q2 + D[1, 1] * q2**2)
    kap = np.array([p2, q2, 0.0]) * w
    scale = THICKNESS**2 / SIDE**2
    stress_x, stress_y = THICKNESS / 2 * Q[2, 0] @ kap, THICKNESS / 6 * Q[1, 1] @ kap
    return 100 * E_T * THICKNESS**3 * w / SIDE**4, float(stress_x) * scale, float(stress_y) * scale
