"""A flat rectangular plate of absolute nodal coordinate shell elements."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Literal

import numpy as np
from pydantic import Field

from lamella.body.base import Body, Marker
from lamella.body.mesh import PlateMesh
from lamella.body.plate_frame import plate_frame, rigid_rows
from lamella.declaration import declaration
from lamella.element.base import ELEMENTS
from lamella.element.plate48.block import STRAIN_MODELS, FloatingShellBlock, ShellBlock, ShellInertia
from lamella.element.plate48.damping import KelvinVoigtBlock, MassDampingBlock
from lamella.element.plate48.damping_small import small_damping
from lamella.element.plate48.frame_groups import FramePlace
from lamella.errors import DeclarationError
from lamella.kinematics import Frame, PointRows
from lamella.material.laminate import Laminate
from lamella.math.rotation import matrix_from_vector
from lamella.roles import Floats, Ints
from lamella.units import Angle, AngularVelocity, Length, Rate, Thickness, Velocity, quantity

if TYPE_CHECKING:
    from lamella.dofs import Build

    Seconds = float
else:
    Seconds = quantity("s", ge=0)

EdgeName = Literal["x-", "x+", "y-", "y+"]
Count = Annotated[int, Field(ge=1, le=10_000)]


class Edge:
    """A straight edge of a plate's parameter rectangle, for supports and loads.

    Args:
        body: the plate.
        side: ``x-``, ``x+``, ``y-`` or ``y+``: the edge where x or y is smallest or largest.
    """

    def __init__(self, body: Plate, side: str) -> None:
        if side not in ("x-", "x+", "y-", "y+"):
            raise DeclarationError(f"Plate '{body.name}'", f"no edge '{side}'", "accepted is x-, x+, y- or y+")
        self.body, self.side = body, side

    def __str__(self) -> str:
        return f"{self.body.name}.{self.side}"


@declaration
class Plate(Body):
    """A flat rectangle 0 <= x <= size[0], 0 <= y <= size[1] at rest in its reference configuration, z along its normal.

    Args:
        name: unique name.
        size: lengths along x and y [m].
        mesh: numbers of elements along x and y.
        laminate: the section.
        position: point of the inertial frame where x = y = 0 lies [m].
        rotation: rotation vector that turns the plate's axes from the inertial ones [rad].
        velocity: initial velocity of the point x = y = 0 [m/s].
        angular_velocity: initial angular velocity in the inertial frame [rad/s].
        strain: ``exact`` (Kirchhoff-Love, large displacements); a small-deformation comparator on the same mesh, linear in a
            frame that is fixed (``linear``), follows the plate (``floating``) or each element (``corotational``); or ``rigid``: a
            panel of the same geometry and mass that keeps its shape.
        frame_at: what the frame of ``floating`` follows: the ``mean`` gradient over the plate, or that over one of its edges (the
            one that is clamped, for example).
        n_gauss: Gauss points in each direction of an element.
        damping: Kelvin-Voigt retardation time c [s]: stress C (E + c dE/dt) with the strains E of the strain model. Rigid
            rotation is not damped, but with ``linear``.
        mass_damping: mass-proportional damping [1/s]: force -c M v; it damps every motion.
        markers: named points (x, y) [m]; each is recorded.
        element: finite element.
    """

    name: str
    size: tuple[Thickness, Thickness]
    mesh: tuple[Count, Count]
    laminate: Laminate
    position: tuple[Length, Length, Length] = (0.0, 0.0, 0.0)
    rotation: tuple[Angle, Angle, Angle] = (0.0, 0.0, 0.0)
    velocity: tuple[Velocity, Velocity, Velocity] = (0.0, 0.0, 0.0)
    angular_velocity: tuple[AngularVelocity, AngularVelocity, AngularVelocity] = (0.0, 0.0, 0.0)
    strain: Literal["exact", "linear", "floating", "corotational", "rigid"] = "exact"
    frame_at: FramePlace = "mean"
    n_gauss: Literal[3, 4, 5] = 4
    damping: Seconds = 0.0
    mass_damping: Rate = 0.0
    markers: dict[str, tuple[Length, Length]] = Field(default_factory=dict)
    element: Literal["plate48"] = "plate48"

    def __post_init__(self) -> None:
        if self.frame_at != "mean" and self.strain != "floating":
            raise DeclarationError(
                f"Plate '{self.name}'",
                f"frame_at '{self.frame_at}' with the strain model '{self.strain}'",
                "accepted are 'mean', or an edge with 'floating'",
            )
        for name, at in self.markers.items():
            self._check_inside(name, at)

    def marker(self, name: str, x: float, y: float) -> Marker:
        """A named point of the mid-surface at (x, y) [m]; it is recorded when the plate is in a system."""
        if name in self.markers and self.markers[name] != (x, y):
            raise DeclarationError(
                f"Plate '{self.name}'", f"marker '{name}' is already at {self.markers[name]}", "use another name"
            )
        self._check_inside(name, (x, y))
        self.markers[name] = (float(x), float(y))
        return Marker(self, name, (float(x), float(y)))

    def corner(self, which: str) -> Marker:
        """A corner as a marker: ``x-y-``, ``x+y-``, ``x+y+`` or ``x-y+``."""
        corners = {"x-y-": (0, 0), "x+y-": (1, 0), "x+y+": (1, 1), "x-y+": (0, 1)}
        if which not in corners:
            raise DeclarationError(f"Plate '{self.name}'", f"no corner '{which}'", f"accepted is {', '.join(corners)}")
        i, j = corners[which]
        return Marker(self, which, (i * self.size[0], j * self.size[1]))

    def edge(self, side: EdgeName) -> Edge:
        """One of the four edges."""
        return Edge(self, side)

    def contribute(self, build: Build) -> None:
        """Number the nodal vectors and add the elastic, inertia and damping blocks."""
        from lamella.body.signals import marker_signals  # the signals need the compiled mesh

        element = ELEMENTS[self.element]
        mesh = PlateMesh(self.name, self.size, self.mesh, element, self.laminate, self.strain)
        turn = matrix_from_vector(np.asarray(self.rotation))
        q = mesh.flat_vectors() @ turn.T
        q[mesh.is_position] += self.position
        q = build.imperfect(q)
        spin = np.cross(self.angular_velocity, q - np.where(mesh.is_position[:, None], self.position, 0.0))
        v = spin + np.where(mesh.is_position[:, None], self.velocity, 0.0)
        mesh.place(build.vectors(self.name, q, v, mesh.is_position, mesh.magnitude), q)
        build.bodies[self.name] = mesh
        arguments = (mesh.coords, mesh.scale, mesh.reference)
        if self.strain == "rigid":
            build.tie(rigid_rows(mesh))
        else:
            self._add_shell(build, arguments)
        inertia = ShellInertia(self.name, *arguments, self.laminate.mass_per_area)
        build.inertias.append(inertia)
        if self.mass_damping > 0:
            build.forces.append(MassDampingBlock(self.name, inertia, self.mass_damping))
        for name, at in self.markers.items():
            build.signals.extend(marker_signals(name, f"{self.name}.{name}", mesh.locate(at)))

    def _add_shell(self, build: Build, tables: tuple[Ints, Floats, Floats]) -> None:
        """Add the elastic block and its structural damping."""
        stiffness = self.laminate.stiffness
        if self.strain == "floating":
            shell = FloatingShellBlock(self.name, *tables, stiffness, self.n_gauss, self.frame_at)
        else:
            shell = STRAIN_MODELS[self.strain](self.name, *tables, stiffness, self.n_gauss)
        build.forces.append(shell)
        if self.damping > 0:
            build.forces.append(
                KelvinVoigtBlock(self.name, *tables, stiffness, self.damping, self.n_gauss)
                if isinstance(shell, ShellBlock)
                else small_damping(shell, self.damping)
            )

    def compiled(self, build: Build) -> PlateMesh:
        """The compiled form of this plate in a build."""
        mesh = build.body(self.name)
        assert isinstance(mesh, PlateMesh)
        return mesh

    def locate(self, build: Build, at: tuple[float, ...]) -> PointRows:
        """Weights of the nodal vectors at (x, y)."""
        return self.compiled(build).locate((at[0], at[1]))

    def frame(self, build: Build, at: tuple[float, ...], axes: Floats) -> Frame:
        """A frame at (x, y) that turns with the tangents and the exact normal."""
        return plate_frame(build, self.compiled(build), at, axes)

    def _check_inside(self, name: str, at: tuple[float, float]) -> None:
        for value, length, axis in zip(at, self.size, "xy", strict=True):
            if not 0 <= value <= length:
                raise DeclarationError(
                    f"Plate '{self.name}'",
                    f"marker '{name}' lies outside the plate at {axis} = {value:g} m",
                    f"accepted is 0 <= {axis} <= {length:g} m",
                )
