"""Composite plate on four corner points under a force at its centre."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Literal

import numpy as np

import lamella as lm
from lamella.roles import Floats
from lamella.verification import Curves, Evidence, References

slow = False

PLY = lm.Lamina(E1=181e9, E2=103e9, G12=7.7e9, nu12=0.28, rho=1560)
LAMINATE = lm.Laminate(PLY, angles=(0, 90, 0), thickness=1.5e-3)
CORNERS = ("x-y-", "x+y-", "x+y+", "x-y+")
MESHES = (6, 8, 12, 24)


def run() -> Iterator[Evidence]:
    """Yield the checks and pictures of this case."""
    references = References.beside(__file__)
    pinned = np.array([deflections(n, pinned=True) for n in MESHES])
    yield from references.checks("z_C at -2 N, corners pinned, mesh n x n", pinned[:, 0].tolist())
    yield from references.checks("z_C at -10 N, corners pinned, mesh n x n", pinned[:, 1].tolist())
    free = np.array([deflections(n, pinned=False) for n in MESHES])
    yield references.check("z_C at -2 N, corners free in the plane", free[-1, 0])
    yield references.check("z_C at -10 N, corners free in the plane", free[-1, 1])
    # From n = 6 to 12 and from 12 to 24 the mesh size is halved: a converging value changes less and less.
    for quantity, z in (("corners pinned", pinned), ("corners free in the plane", free)):
        change = np.diff(z[[0, 2, 3], 0])
        yield references.check(f"change from 12 to 24 over change from 6 to 12, {quantity}", change[1] / change[0])
    linear = deflections(24, pinned=True, strain="linear")
    yield references.check("z_C at -2 N, linear theory", linear[0])
    names = {force: f"z_C at {force} N, corners pinned, mesh n x n" for force in (-2, -10)}
    computed = {f"{force} N": (MESHES, pinned[:, place]) for place, force in enumerate(names)}
    points = {f"{force} N, another code": references.points(name) for force, name in names.items()}
    yield Curves("Corners pinned: no limit as the mesh is refined", "Elements along a side [–]", "z_C [m]", computed, points)


def deflections(n: int, *, pinned: bool, strain: Literal["exact", "linear"] = "exact") -> Floats:
    """z of the centre [m] under -2 N and -10 N.

    Args:
        n: elements along each side.
        pinned: hold the corners along x, y and z; else along z only, with the plane's rigid motion held at two points.
        strain: strain model.
    """
    system = lm.System()
    plate = system.add(lm.Plate("plate", (1.5, 2.0), (n, n), LAMINATE, strain=strain))
    centre = plate.marker("C", 0.75, 1.0)
    for corner in CORNERS:
        system.add(lm.PointSupport(f"pin {corner}", plate.corner(corner), axes="xyz" if pinned else "z"))
    if not pinned:
        system.add(lm.PointSupport("in the plane", centre, axes="xy"))
        system.add(lm.PointSupport("against turning", plate.marker("B", 0.75, 2.0), axes="x"))
    system.add(lm.PointForce("force", centre, (0.0, 0.0, -10.0)))
    history = lm.equilibrium(system, steps=[0.2, 1.0]).history("C.position")
    return history.sel(load_factor=[0.2, 1.0], method="nearest").values[:, 2]
