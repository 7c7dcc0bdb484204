"""What is refused at the start: obstacles in the shell, cylinders in each other, and closed shells too short for theirs."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from lamella.contact.block import ContactBlock
from lamella.contact.gap import CYLINDER
from lamella.contact.sheet import places
from lamella.dofs import Build
from lamella.errors import DeclarationError
from lamella.roles import Floats

if TYPE_CHECKING:
    from lamella.body.base import Marker
    from lamella.body.mesh import PlateMesh

SQUARE = 0.95
"""Sine of the angle between two axes' shortest connection and either axis above which cylinders meet with their sides. Where an
end meets a side or an end, nothing is said."""
ROUNDING = 1e-9
"""Share of the radii below which axes meet."""
PARALLEL = 0.99
"""Cosine of the angle between axes that count as parallel: a belt runs around both."""
CIRCLE = np.linspace(0.0, 2.0 * np.pi, 720, endpoint=False)
SHORT = 1e-3
"""Share of its length by which a closed shell may be too short: more than chords and the polygon of a circle can be."""


def check_start(item: str, at: Marker, build: Build, mesh: PlateMesh, block: ContactBlock) -> None:
    """Refuse an obstacle that has no place in the initial configuration.

    Args:
        item: what messages call the contact.
        at: its marker.
        build: with the contacts declared before.
        mesh: of the shell.
        block: the contact.

    Raises:
        DeclarationError: its cylinder overlaps another's on the same shell; or a closed shell is shorter than the convex hull
            of the cylinders inside it; or the obstacle reaches the shell's reference surface.
    """
    if block.obstacle.kind == CYLINDER:
        others = [
            other
            for other in build.forces
            if isinstance(other, ContactBlock)
            and other.obstacle.kind == CYLINDER
            and np.array_equal(other.sheet.coords, block.sheet.coords)
        ]
        _check_cylinders(item, at, build, block, others)
        _check_loop(item, build, mesh, block, others)
    _check_depth(item, at, build, mesh, block)


def _check_cylinders(item: str, at: Marker, build: Build, block: ContactBlock, others: list[ContactBlock]) -> None:
    """Refuse a cylinder that overlaps that of another body; on one body they are one obstacle, such as a roller with flanges."""
    from scipy.optimize import lsq_linear  # imported late: some tenths of a second that most models never need

    q = build.initial.reshape(-1)
    centre, axis = block.place(q)
    for other in others:
        c, a = other.place(q)
        halves = np.array([block.obstacle.half, other.obstacle.half])
        both = lsq_linear(np.stack([axis, -a], axis=1), c - centre, (-halves, halves), method="bvls").x
        between = c + both[1] * a - centre - both[0] * axis
        apart = float(np.linalg.norm(between))
        sines = [np.linalg.norm(np.cross(between, along)) for along in (axis, a)]
        radii = block.obstacle.radius, other.obstacle.radius
        if block.first != other.first and apart < sum(radii) and min(sines) >= SQUARE * apart - ROUNDING * sum(radii):
            raise DeclarationError(
                item,
                f"its cylinder at {at} and that of '{other.name}' overlap by {sum(radii) - apart:.4g} m at the start: radii of "
                f"{radii[0]:.4g} and {radii[1]:.4g} m, axes {apart:.4g} m apart",
                "accepted are cylinders that are apart, or both on one body; move one of them",
            )


def _check_loop(item: str, build: Build, mesh: PlateMesh, block: ContactBlock, others: list[ContactBlock]) -> None:
    """Refuse a loop that cannot go around the cylinders inside it: no shape of it is shorter than their convex hull."""
    if mesh.loops[0] == mesh.loops[1]:
        return
    q = build.initial.reshape(-1)
    centre, axis = block.place(q)
    across = np.linalg.svd(axis[None])[2][1:]  # two directions normal to the axis
    grid = mesh.sample(q, 4).r
    middle = grid[len(grid) // 2] if mesh.loops[0] else grid[:, grid.shape[1] // 2]
    loop = (middle - centre) @ across.T
    inside: list[tuple[str, Floats]] = []
    for one in (*others, block):
        c, a = one.place(q)
        place = across @ (c - centre)
        beside = abs(float(a @ (middle.mean(axis=0) - c))) > one.obstacle.half  # the cylinder ends before the middle line
        if abs(float(axis @ a)) > PARALLEL and not beside and _surrounds(loop, place):
            inside.append((one.name, place + one.obstacle.radius * np.stack([np.cos(CIRCLE), np.sin(CIRCLE)], axis=1)))
    if block.name not in [name for name, _ in inside]:
        return
    length = float(np.linalg.norm(np.diff(loop, axis=0), axis=1).sum())
    from scipy.spatial import ConvexHull  # imported late: some tenths of a second that most models never need

    needed = float(ConvexHull(np.concatenate([circle for _, circle in inside])).area)  # of a plane figure: its circumference
    if needed > (1.0 + SHORT) * length:
        names = " and ".join(f"'{name}'" for name, _ in inside)
        raise DeclarationError(
            item,
            f"'{mesh.name}' is {length:.4g} m around at the start, the cylinders inside it, {names}, are {needed:.4g} m",
            "accepted is a longer shell, or smaller or closer cylinders",
        )


def _surrounds(loop: Floats, place: Floats) -> bool:
    """Whether a closed plane curve, shape (n, 2), turns around a place."""
    angle = np.unwrap(np.arctan2(loop[:, 1] - place[1], loop[:, 0] - place[0]))
    return abs(float(angle[-1] - angle[0])) > np.pi


def _check_depth(item: str, at: Marker, build: Build, mesh: PlateMesh, block: ContactBlock) -> None:
    """Refuse an obstacle that reaches the reference surface: deeper in, it would push the sheet out on the other side."""
    q = build.initial.reshape(-1)
    depth = -block.field(q, np.zeros_like(q)).gap
    allowed = block.sheet.half_thickness[:, None]
    element, point = np.unravel_index(int(np.argmax(depth - allowed)), depth.shape)
    if depth[element, point] > allowed[element, 0]:
        j, i = divmod(int(element), mesh.nx)
        xi, eta = (float(share[point]) for share in places(round(block.sheet.n_point**0.5)))
        x, y = (i + xi) * mesh.lx, (j + eta) * mesh.ly
        r = mesh.locate((x, y)).at(build.initial)
        raise DeclarationError(
            item,
            f"the obstacle at {at} overlaps '{mesh.name}' by {depth[element, point]:.4g} m at the start, at "
            f"x = {x:.4g}, y = {y:.4g} m of the shell, ({', '.join(f'{c:.4g}' for c in r)}) m in space",
            f"accepted is up to half the thickness, {allowed[element, 0]:.4g} m; move one of them",
        )
