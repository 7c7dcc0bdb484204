"""Sunlight on a plate that moves and bends."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, ClassVar, Literal

import numpy as np
from pydantic import BeforeValidator, Field

from lamella import units
from lamella.body.plate import Plate
from lamella.declaration import declaration
from lamella.dofs import Build, Motion, Signal
from lamella.element.packing import packed, packed_targets, unpacked
from lamella.element.plate48 import heat_kernels as kernels
from lamella.element.plate48.exact import ShellBlock
from lamella.element.plate48.heated import CrossBlock, GaussPoints
from lamella.element.plate48.shape import Plate48, gauss_points
from lamella.element.plate48.surface import derivatives_at_points, reference_surface
from lamella.lane import WIDTH, aligned
from lamella.math.profile import Constant, Profile
from lamella.math.rotation import matrix_from_vector
from lamella.roles import Declaration, Floats
from lamella.state import State
from lamella.thermal.mesh import TemperatureMesh, field_of

EDGE_ON = 1e-3
"""Smoothing of the switch between the lit sides: half a thousandth of the full flux falls on both when light comes edge-on."""

if TYPE_CHECKING:
    Absorptivity = float | tuple[float, float]
else:
    Absorptivity = Annotated[
        tuple[units.Share, units.Share],
        BeforeValidator(lambda value: (value, value) if isinstance(value, (int, float, str)) else value),
    ]


@declaration
class SolarFlux(Declaration):
    """Sunlight: the side that faces the light absorbs alpha_s S |n0.s| for each reference area, the other one nothing.

    With x = -s.n0 the top side absorbs alpha_s S lit(x) and the bottom side alpha_s S lit(-x), where

        lit(x) = (x + sqrt(x^2 + w^2)) / 2,    w = 0.001

    is max(x, 0) with a smooth corner; lit(x) - lit(-x) = x holds exactly, and so does what drives T_M where both sides absorb
    alike. One plate throws no shadow on another, nor on itself.

    Args:
        name: unique name; the result holds ``<name>.heat`` [W], what the plate absorbs, and ``<name>.view``, the mean of -s.n0.
        on: the plate.
        direction: vector s along which the light travels; its length does not count.
        absorptivity: alpha_s of both sides, or of (top, bottom), 0 to 1.
        constant: solar constant S [W/m^2].
        model: ``coupled`` takes the normal n0 of the present shape, ``uncoupled`` that of the reference configuration.
        turning: angular velocity with which s turns [rad/s].
        profile: factor p(t) of the light, for example an eclipse.

    Raises:
        DeclarationError: an absorptivity outside 0 to 1, or a direction of zero length.
    """

    order: ClassVar[int] = 5
    name: str
    on: Plate
    direction: tuple[units.Number, units.Number, units.Number]
    absorptivity: Absorptivity
    constant: Annotated[units.HeatFlux, Field(ge=0)] = 1361.0
    model: Literal["coupled", "uncoupled"] = "coupled"
    turning: tuple[units.AngularVelocity, units.AngularVelocity, units.AngularVelocity] = (0.0, 0.0, 0.0)
    profile: Profile = Constant(1.0)

    def __post_init__(self) -> None:
        if not np.linalg.norm(self.direction) > 0.0:
            raise ValueError(f"direction = {self.direction}; accepted is a vector of some length")

    def contribute(self, build: Build) -> None:
        """Add the flux of the plate's elements."""
        plate = self.on.compiled(build)
        mesh = field_of(build, plate, f"SolarFlux '{self.name}'")
        assert isinstance(self.absorptivity, tuple)  # one number stands for both sides
        s = np.asarray(self.direction, float) / np.linalg.norm(self.direction)
        light = Light(s, self.constant, np.asarray(self.turning, float), self.profile)
        block = SolarBlock(self.name, mesh, light, self.absorptivity, self.on.n_gauss, coupled=self.model == "coupled")
        build.loads.append(block)
        build.breakpoints.extend(self.profile.breakpoints)

        def heat(state: State) -> float:
            return state.factor * block.absorbed(state)

        def view(state: State) -> float:
            return block.view(state)

        build.signals.append(Signal(f"{self.name}.heat", "W", (), heat, f"heat that {plate.name} absorbs"))
        build.signals.append(Signal(f"{self.name}.view", "1", (), view, f"mean of -s.n0 of {plate.name}"))


class Light:
    """Parallel light of the flux S p(t) that travels along a unit vector s, which turns at a constant angular velocity."""

    def __init__(self, direction: Floats, constant: float, turning: Floats, profile: Motion) -> None:
        self._direction, self._constant, self._turning, self._profile = direction, constant, turning, profile
        self._turns = bool(turning.any())

    def direction(self, t: float) -> Floats:
        """s at the time t [s], shape (3,)."""
        return matrix_from_vector(self._turning * t) @ self._direction if self._turns else self._direction

    def at(self, t: float) -> Floats | None:
        """Direction times flux, S p(t) s [W/m^2], shape (3,); None in the dark."""
        flux = self._constant * self._profile.value(t)
        return flux * self.direction(t) if flux else None


class SolarBlock(CrossBlock):
    """The flux that elements of a plate absorb, on the rows of their temperatures, with its derivative by their shape.

    Args:
        name: the load's name.
        mesh: the temperature field.
        light: the light.
        absorptivity: of the top and bottom side.
        n_gauss: Gauss points in each direction.
        coupled: whether the normal is that of the present shape.
    """

    first_order = True

    def __init__(
        self, name: str, mesh: TemperatureMesh, light: Light, absorptivity: tuple[float, float], n_gauss: int, *, coupled: bool
    ) -> None:
        plate = mesh.plate
        self._light, self._coupled = light, coupled
        elements = ShellBlock(name, plate.coords, plate.scale, plate.reference, plate.section, n_gauss)
        super().__init__(name, elements, plate.coords, mesh.coords)
        self._points = GaussPoints(elements, n_gauss)
        xi, eta, weights = gauss_points(n_gauss)
        surface = reference_surface(name, derivatives_at_points(Plate48().shape(xi, eta), elements.rest))
        areas = surface.area * weights
        self._area, self._whole = packed(areas), float(areas.sum())
        top, bottom = absorptivity
        self._upper, self._lower = top * np.array([1.0, mesh.height("top")]), bottom * np.array([1.0, mesh.height("bottom")])
        self.f_coords = packed_targets(mesh.coords)
        self.f_scale = np.ones(len(self.f_coords))
        self._absorbed, self._n = aligned(elements.n_block * WIDTH), elements.n_element
        self._reference = np.zeros(int(plate.coords.max()) + 1)
        self._reference[plate.coords] = plate.reference
        self.k_rows, self.k_cols = self._fields, self._coords
        if not coupled:
            self.k_rows = self.k_cols = np.zeros(0, np.int64)
            self.k_scale = np.zeros(0)

    def force(self, t: float, q: Floats, v: Floats, f: Floats) -> None:
        """Minus the heat absorbed [W]."""
        light = self._light.at(t)
        if light is None:
            f[:], self._absorbed[:] = 0.0, 0.0
            return
        self._shine(q, light, self._upper, self._lower, f)

    def _shine(self, q: Floats, light: Floats, upper: Floats, lower: Floats, f: Floats) -> None:
        p = self._points
        shape = q if self._coupled else self._reference
        kernels.solar_flux(
            shape, p.index, p.scale, p.table, p.corners, p.n, self._area, light, upper, lower, EDGE_ON, p.work, f, self._absorbed
        )

    def force_tangent(
        self, t: float, q: Floats, v: Floats, alpha_q: float, alpha_v: float, q_previous: Floats, f: Floats, k: Floats
    ) -> None:
        """Minus the heat, and its derivative by the shape."""
        self.force(t, q, v, f)
        light = self._light.at(t)
        if not self._coupled:
            return
        if light is None:
            k[:] = 0.0
            return
        p = self._points
        kernels.solar_tangent(
            q, p.index, p.scale, p.table, p.corners, p.n, self._area, light, self._upper, self._lower, EDGE_ON, alpha_q, p.work, k
        )

    def absorbed(self, state: State) -> float:
        """Heat absorbed in a state [W]."""
        self.force(state.t, state.q, state.v, np.empty(len(self.f_coords)))
        return float(unpacked(self._absorbed, self._n).sum())

    def view(self, state: State) -> float:
        """Mean of -s.n0 in a state: what the top side would absorb less what the bottom side would, as lit(x) - lit(-x) = x."""
        one = np.array([1.0, 0.0])
        self._shine(state.q, self._light.direction(state.t), one, -one, np.empty(len(self.f_coords)))
        return float(unpacked(self._absorbed, self._n).sum()) / self._whole

    def energy(self, t: float, q: Floats) -> float:
        """None: heat is not mechanical energy."""
        return 0.0
