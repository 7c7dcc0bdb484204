"""Heat given to a plate and exchanged with its surroundings: fluxes, sources, films and radiation."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Annotated, ClassVar, Literal

import numpy as np
from pydantic import AfterValidator, BeforeValidator

from lamella import units
from lamella.body.plate import Plate
from lamella.declaration import declaration
from lamella.dofs import Build, Signal
from lamella.load.dead import DeadLoadBlock
from lamella.math.profile import Constant, Profile
from lamella.roles import Declaration, Floats, ForceBlock
from lamella.state import State
from lamella.thermal.conduction import film_block
from lamella.thermal.mesh import TemperatureMesh, field_of
from lamella.thermal.radiation import RadiationBlock

Side = Literal["top", "bottom"]
BOTH: tuple[Side, Side] = ("top", "bottom")


def _distinct(sides: tuple[Side, ...]) -> tuple[Side, ...]:
    if not sides or len(set(sides)) < len(sides):
        raise ValueError("accepted is top, bottom or both, each once")
    return sides


if TYPE_CHECKING:
    Sides = Side | tuple[Side, ...]
else:
    Sides = Annotated[
        tuple[Side, ...],
        BeforeValidator(lambda value: (value,) if isinstance(value, str) else value, json_schema_input_type=Side | list[Side]),
        AfterValidator(_distinct),
    ]


def record_heat(build: Build, name: str, mesh: TemperatureMesh, block: ForceBlock, unit_factor: bool = False) -> None:
    """Record the heat that a block gives to a plate [W]: minus the sum of its entries for T_N."""
    buffer = np.zeros(len(block.f_coords))
    is_mean = ((block.f_coords - mesh.first) % 2 == 0) & (block.f_coords >= 0)

    def heat(state: State) -> float:
        block.force(state.t, state.q, state.v, buffer)
        return -(state.factor if unit_factor else 1.0) * float(buffer[is_mean].sum())

    build.signals.append(Signal(f"{name}.heat", "W", (), heat, f"heat that {name} gives to {mesh.plate.name}"))


def supplied(mesh: TemperatureMesh, mean: float, slope: float) -> Floats:
    """Heat given to all nodes by a uniform supply, ``mean`` to T_N and ``slope`` to T_M for each area, shape (n_element, 8)."""
    one = mesh.integrals()[0]
    return np.broadcast_to(np.concatenate([mean * one, slope * one]), mesh.coords.shape)


def _add_supply(build: Build, name: str, mesh: TemperatureMesh, values: Floats, profile: Profile) -> None:
    block = DeadLoadBlock(name, mesh.coords.reshape(-1), values.reshape(-1), profile)
    build.loads.append(block)
    build.breakpoints.extend(profile.breakpoints)
    record_heat(build, name, mesh, block, unit_factor=True)


@declaration
class HeatFlux(Declaration):
    """A given flux q p(t) into one side of a plate.

    Args:
        name: unique name; the result holds ``<name>.heat`` [W].
        on: the plate.
        side: ``top`` (z > 0) or ``bottom``.
        flux: q [W/m^2], negative for heat that is taken away.
        profile: p(t).
    """

    order: ClassVar[int] = 5
    name: str
    on: Plate
    side: Side
    flux: units.HeatFlux
    profile: Profile = Constant(1.0)

    def contribute(self, build: Build) -> None:
        """Give q to T_N and z q to T_M."""
        mesh = field_of(build, self.on.compiled(build), f"HeatFlux '{self.name}'")
        _add_supply(build, self.name, mesh, supplied(mesh, self.flux, self.flux * mesh.height(self.side)), self.profile)


@declaration
class HeatSource(Declaration):
    """Heat Q p(t) that arises in the volume of a plate.

    Args:
        name: unique name; the result holds ``<name>.heat`` [W].
        on: the plate.
        power: Q [W/m^3].
        profile: p(t).
    """

    order: ClassVar[int] = 5
    name: str
    on: Plate
    power: units.HeatSource
    profile: Profile = Constant(1.0)

    def contribute(self, build: Build) -> None:
        """Give int Q dz to T_N and int Q z dz to T_M."""
        plate = self.on.compiled(build)
        mesh, z = field_of(build, plate, f"HeatSource '{self.name}'"), plate.laminate.z
        moments = z[-1] - z[0], 0.5 * (z[-1] ** 2 - z[0] ** 2)
        _add_supply(build, self.name, mesh, supplied(mesh, *(self.power * float(m) for m in moments)), self.profile)


@declaration
class Film(Declaration):
    """Exchange of heat with a fluid: q = h_c (T_ambient - T) into each side, with T at the surface.

    Args:
        name: unique name; the result holds ``<name>.heat`` [W], what the plate receives.
        on: the plate.
        coefficient: h_c [W/(m^2 K)].
        ambient: temperature of the fluid [K].
        sides: ``top``, ``bottom`` or both.
    """

    order: ClassVar[int] = 5
    name: str
    on: Plate
    coefficient: units.FilmCoefficient
    ambient: units.Temperature
    sides: Sides = BOTH

    def contribute(self, build: Build) -> None:
        """Add the exchange of each side."""
        mesh = field_of(build, self.on.compiled(build), f"Film '{self.name}'")
        blocks = [film_block(self.name, mesh, mesh.height(side), self.coefficient, self.ambient) for side in self.sides]
        _add_exchange(build, self.name, mesh, blocks)


@declaration
class Radiation(Declaration):
    """Radiation to the surroundings: q = epsilon sigma (T_space^4 - T^4) into each side, with the absolute T at the surface.

    Args:
        name: unique name; the result holds ``<name>.heat`` [W], what the plate receives (negative when it cools).
        on: the plate.
        emissivity: epsilon, 0 to 1.
        space: temperature of the surroundings [K].
        sides: ``top``, ``bottom`` or both.
    """

    order: ClassVar[int] = 5
    name: str
    on: Plate
    emissivity: units.Share
    space: units.Temperature = 3.0
    sides: Sides = BOTH

    def contribute(self, build: Build) -> None:
        """Add the radiation of each side."""
        mesh = field_of(build, self.on.compiled(build), f"Radiation '{self.name}'")
        blocks = [RadiationBlock(self.name, mesh, mesh.height(side), self.emissivity, self.space) for side in self.sides]
        _add_exchange(build, self.name, mesh, blocks)


def _add_exchange(build: Build, name: str, mesh: TemperatureMesh, blocks: Sequence[ForceBlock]) -> None:
    """Add what depends on temperature alone, and record its sum."""
    build.forces.extend(blocks)
    buffers = [(block, np.zeros(len(block.f_coords))) for block in blocks]

    def heat(state: State) -> float:
        total = 0.0
        for block, buffer in buffers:
            block.force(state.t, state.q, state.v, buffer)
            total -= float(buffer.reshape(-1, 8)[:, :4].sum())
        return total

    build.signals.append(Signal(f"{name}.heat", "W", (), heat, f"heat that {mesh.plate.name} receives by {name}"))
