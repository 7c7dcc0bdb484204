"""What flat plates and curved shells share: edges, markers, strain models and damping."""

from __future__ import annotations

from abc import abstractmethod
from dataclasses import KW_ONLY
from typing import TYPE_CHECKING, Annotated, Literal

import numpy as np
from pydantic import Field

from lamella.arguments import NUMBER, TEXT, accepts
from lamella.body.base import Body, Marker
from lamella.body.mesh import PlateMesh
from lamella.body.plate_frame import plate_frame, rigid_rows
from lamella.declaration import declaration
from lamella.element.base import ELEMENTS
from lamella.element.plate48.damping import MassDampingBlock
from lamella.element.plate48.frame import FrameShellBlock
from lamella.element.plate48.frame_groups import FramePlace
from lamella.element.plate48.linear import LinearShellBlock
from lamella.element.plate48.section import Curvature
from lamella.element.shells import SHELLS
from lamella.errors import DeclarationError
from lamella.kinematics import Frame, PointRows
from lamella.material.laminate import Laminate
from lamella.math.rotation import matrix_from_vector
from lamella.roles import Floats, Ints
from lamella.surface.base import Surface
from lamella.units import Angle, AngularVelocity, Length, Number, Positive, Rate, Velocity, quantity

if TYPE_CHECKING:
    from lamella.dofs import Build

    Seconds = float
else:
    Seconds = quantity("s", ge=0)

EdgeName = Literal["x-", "x+", "y-", "y+"]
SIDES = ("x-", "x+", "y-", "y+")
Count = Annotated[int, Field(ge=1, le=10_000)]


class Edge:
    """An edge of the parameter rectangle of a plate or shell, for supports and loads.

    Args:
        body: the plate or shell.
        side: ``x-``, ``x+``, ``y-`` or ``y+``: the edge where x or y is smallest or largest.
    """

    def __init__(self, body: ShellBody, side: str) -> None:
        if not isinstance(side, str) or side not in SIDES:
            raise DeclarationError(body.item, f"no edge '{side}'", "accepted is x-, x+, y- or y+")
        axis = "xy".index(side[0])
        if body.geometry.loops[axis]:
            rest = [name for name in SIDES if not body.geometry.loops["xy".index(name[0])]]
            raise DeclarationError(
                body.item,
                f"no edge '{side}': it is closed along {side[0]}",
                f"its edges are {' and '.join(rest)}" if rest else "it has no edge at all",
            )
        self.body, self.side = body, side

    def __str__(self) -> str:
        return f"{self.body.name}.{self.side}"

    def __repr__(self) -> str:
        return f"<Edge {self}>"


class MeshedBody(Body):
    """Fields that each body declares itself, so that they come before its options."""

    mesh: tuple[int, int]
    laminate: Laminate


@declaration
class ShellBody(MeshedBody):
    """A thin body of absolute nodal coordinate shell elements over a rectangle of parameters x, y.

    Args:
        position: point of the inertial frame where the origin of the body's axes lies [m].
        rotation: rotation vector that turns the body's axes from the inertial ones [rad].
        velocity: initial velocity of the origin [m/s].
        angular_velocity: initial angular velocity in the inertial frame [rad/s].
        strain: ``exact`` (Kirchhoff-Love, large displacements); a small-deformation comparator on the same mesh, linear in a
            frame that is fixed (``linear``), follows the body (``floating``) or each element (``corotational``); or ``rigid``: a
            flat panel of the same geometry and mass that keeps its shape.
        frame_at: what the frame of ``floating`` follows: the ``mean`` gradient over the body, or that over one of its edges (the
            one that is clamped, for example).
        n_gauss: Gauss points in each direction of an element.
        membrane_gauss: fewer points, for the energy of the in-plane forces alone; None stands for ``n_gauss``. It eases membrane
            locking of elements that bend far. At least 3, and more than one element then.
        curvature: ``unit_normal``, kap = r_xx.n/|n| with n = r_x x r_y; or ``cubed_normal``, kap = r_xx.n/|n|^3 (Dufva and
            Shabana), which is smaller by the square of the stretch of area.
        damping: Kelvin-Voigt retardation time c [s]: stress C (E + c dE/dt) with the strains E of the strain model. Rigid
            rotation is not damped, but with ``linear``.
        mass_damping: mass-proportional damping [1/s]: force -c M v; it damps every motion.
        ply_direction: vector of the body's axes from whose projection on the surface the fibre angles count, and which is the
            first axis of stresses and strains; the direction of the parameter x when left out.
        thickness_factors: for each element, by which number all heights of the section are multiplied: its plies and its offset;
            rows follow y, the elements of a row x.
        prestrain: membrane strains (eps_11, eps_22, 2 eps_12) that the reference configuration already has, in the axes of the
            plies; positive where it is stretched [-].
        markers: named points (x, y) [m]; each is recorded.
        element: finite element: ``plate48`` (r, r_x, r_y, r_xy at each node), whose slopes are continuous; or ``plate36`` without
            r_xy, a quarter fewer coordinates, whose slope across an edge is continuous at the nodes only.
    """

    _: KW_ONLY
    position: tuple[Length, Length, Length] = (0.0, 0.0, 0.0)
    rotation: tuple[Angle, Angle, Angle] = (0.0, 0.0, 0.0)
    velocity: tuple[Velocity, Velocity, Velocity] = (0.0, 0.0, 0.0)
    angular_velocity: tuple[AngularVelocity, AngularVelocity, AngularVelocity] = (0.0, 0.0, 0.0)
    strain: Literal["exact", "linear", "floating", "corotational", "rigid"] = "exact"
    frame_at: FramePlace = "mean"
    n_gauss: Literal[3, 4, 5] = 4
    membrane_gauss: Literal[3, 4] | None = None
    curvature: Curvature = "unit_normal"
    damping: Seconds = 0.0
    mass_damping: Rate = 0.0
    ply_direction: tuple[Number, Number, Number] | None = None
    thickness_factors: tuple[tuple[Positive, ...], ...] | None = None
    prestrain: tuple[Number, Number, Number] | None = None
    markers: dict[str, tuple[Length, Length]] = Field(default_factory=dict)
    element: Literal["plate48", "plate36"] = "plate48"

    @property
    @abstractmethod
    def geometry(self) -> Surface:
        """The reference surface in the body's axes."""

    @property
    def stress_free_geometry(self) -> Surface:
        """The surface on which the body has no stress."""
        return self.geometry

    @property
    def item(self) -> str:
        """What messages call this body."""
        return f"{type(self).__name__} '{self.name}'"

    def __post_init__(self) -> None:
        """Refuse options that do not go together, and markers outside."""
        if self.frame_at != "mean" and self.strain != "floating":
            raise DeclarationError(
                self.item,
                f"frame_at '{self.frame_at}' with the strain model '{self.strain}'",
                "accepted are 'mean', or an edge with 'floating'",
            )
        if self.prestrain is not None and self.strain != "exact":
            raise DeclarationError(self.item, f"prestrain with the strain model '{self.strain}'", "accepted is 'exact'")
        if self.ply_direction is not None and not any(self.ply_direction):
            raise DeclarationError(self.item, "ply_direction = (0, 0, 0)", "accepted is a vector that is not zero")
        nx, ny = self.mesh
        rows = self.thickness_factors
        if rows is not None and (len(rows) != ny or any(len(row) != nx for row in rows)):
            shape = f"{len(rows)} rows of {', '.join(str(n) for n in sorted({len(row) for row in rows}))}"
            raise DeclarationError(self.item, f"thickness_factors has {shape}", f"accepted are {ny} rows of {nx} numbers")
        if self.membrane_gauss is not None:
            self._check_reduced(self.membrane_gauss)
        for name, at in self.markers.items():
            self._check_inside(name, at)

    @accepts(name=TEXT, x=NUMBER, y=NUMBER)
    def marker(self, name: str, x: float, y: float) -> Marker:
        """A named point of the reference surface at (x, y) [m]; it is recorded when the body is in a system."""
        if name in self.markers and self.markers[name] != (x, y):
            raise DeclarationError(self.item, f"marker '{name}' is already at {self.markers[name]}", "use another name")
        self._check_inside(name, (x, y))
        self.markers[name] = (float(x), float(y))
        return Marker(self, name, (float(x), float(y)))

    def corner(self, which: str) -> Marker:
        """A corner as a marker: ``x-y-``, ``x+y-``, ``x+y+`` or ``x-y+``."""
        corners = {"x-y-": (0, 0), "x+y-": (1, 0), "x+y+": (1, 1), "x-y+": (0, 1)}
        if which not in corners:
            raise DeclarationError(self.item, f"no corner '{which}'", f"accepted is {', '.join(corners)}")
        i, j = corners[which]
        l_x, l_y = self.geometry.size
        return Marker(self, which, (i * l_x, j * l_y))

    def edge(self, side: EdgeName) -> Edge:
        """One of the edges."""
        return Edge(self, side)

    def contribute(self, build: Build) -> None:
        """Number the nodal vectors and add the elastic, inertia and damping blocks."""
        from lamella.body.signals import marker_signals  # the signals need the compiled mesh

        turn = matrix_from_vector(np.asarray(self.rotation))
        mesh = PlateMesh(
            self.name,
            self.geometry,
            self.mesh,
            ELEMENTS[self.element],
            self.laminate,
            self.strain,
            self.curvature,
            self.membrane_gauss,
        )
        if self.thickness_factors is not None:
            mesh.thicken(np.array(self.thickness_factors).reshape(-1))
        mesh.orient(None if self.ply_direction is None else turn @ self.ply_direction, self.prestrain)
        q = mesh.node_vectors() @ turn.T
        q[mesh.is_position] += self.position
        v = np.where(mesh.is_position[:, None], self.velocity, 0.0)
        if any(self.angular_velocity):
            v += np.cross(self.angular_velocity, q - np.where(mesh.is_position[:, None], self.position, 0.0))
        rest = mesh.corner_vectors(self.stress_free_geometry) @ turn.T
        rest[:, np.tile(mesh.element.is_position, len(mesh.element.nodes))] += self.position
        imperfect = build.imperfect(q)
        rest, q = rest + (imperfect - q)[mesh.element_vectors], imperfect
        mesh.place(build.vectors(self.name, q, v, mesh.is_position, mesh.magnitude), rest)
        build.bodies[self.name] = mesh
        arguments = (mesh.coords, mesh.scale, mesh.reference)
        if self.strain == "rigid":
            build.tie(rigid_rows(mesh))
        else:
            self._add_shell(build, mesh, arguments)
        inertia = SHELLS[self.element].inertia(self.name, arguments, mesh.mass_per_area)
        build.inertias.append(inertia)
        if self.mass_damping > 0:
            build.forces.append(MassDampingBlock(self.name, inertia, self.mass_damping))
        for name, at in self.markers.items():
            build.signals.extend(marker_signals(name, f"{self.name}.{name}", mesh.locate(at)))

    def _add_shell(self, build: Build, mesh: PlateMesh, tables: tuple[Ints, Floats, Floats]) -> None:
        """Add the elastic block, its structural damping, and the frames in which strains are recovered."""
        models, section = SHELLS[self.element], mesh.section
        blocks = models.shell(self.strain, self.name, tables, section, self.n_gauss, self.frame_at, self.damping)
        build.forces.extend(blocks)
        if isinstance(blocks[0], LinearShellBlock | FrameShellBlock):
            mesh.turns = blocks[0].turns

    def compiled(self, build: Build) -> PlateMesh:
        """The compiled form of this body in a build."""
        mesh = build.body(self.name)
        assert isinstance(mesh, PlateMesh)
        return mesh

    def locate(self, build: Build, at: tuple[float, ...]) -> PointRows:
        """Weights of the nodal vectors at (x, y)."""
        return self.compiled(build).locate((at[0], at[1]))

    def frame(self, build: Build, at: tuple[float, ...], axes: Floats) -> Frame:
        """A frame at (x, y) that turns with the tangents and the exact normal."""
        return plate_frame(build, self.compiled(build), at, axes)

    def _check_reduced(self, points: int) -> None:
        if points > self.n_gauss:
            raise DeclarationError(
                self.item,
                f"membrane_gauss = {points} with n_gauss = {self.n_gauss}",
                f"accepted is a number up to {self.n_gauss}, or none",
            )
        if points == 3 and self.mesh == (1, 1):
            raise DeclarationError(
                self.item,
                "membrane_gauss = 3 on a single element, which leaves motions in its plane without stiffness",
                "accepted is a mesh of two or more elements, or membrane_gauss = 4",
            )

    def _check_inside(self, name: str, at: tuple[float, float]) -> None:
        for value, length, axis in zip(at, self.geometry.size, "xy", strict=True):
            if not 0 <= value <= length:
                raise DeclarationError(
                    self.item,
                    f"marker '{name}' lies outside the {type(self).__name__.lower()} at {axis} = {value:g} m",
                    f"accepted is 0 <= {axis} <= {length:g} m",
                )
