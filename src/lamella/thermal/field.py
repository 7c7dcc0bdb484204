"""Temperature as a field of a plate."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar

import numpy as np

from lamella import units
from lamella.body.plate import Plate
from lamella.declaration import declaration
from lamella.dofs import Build, Signal
from lamella.element.plate48.thermal_matrices import HeatedElements
from lamella.element.shells import SHELLS
from lamella.errors import DeclarationError
from lamella.roles import Declaration
from lamella.thermal.conduction import plate_block
from lamella.thermal.mesh import ElementSum, TemperatureMesh

if TYPE_CHECKING:
    from lamella.body.mesh import PlateMesh
    from lamella.state import State


@declaration
class TemperatureField(Declaration):
    """The temperature T = T_0 + T_N(x, y, t) + z T_M(x, y, t) of a plate, unknown like its shape.

    T_N and T_M are bilinear on the plate's mesh. Heat is conducted in the plane and through the thickness; edges are insulated
    unless a temperature is prescribed there. Thermal strain alpha (T - T_0) bends and stretches the plate, with every strain
    model but ``rigid``.

    An edge that is clamped ``full`` cannot grow in its plane; it is told among the notes of the start, as is a motion that
    begins at another temperature than the reference.

    Args:
        name: unique name; the result holds ``<name>.heat`` [J], what is stored above the reference temperature, ``<name>.mean``
            [K], the mean of T, and at each marker of the plate ``<marker>.T_N`` [K] and ``<marker>.T_M`` [K/m].
        on: the plate.
        reference: temperature T_0 at which the plate is free of stress [K].
        initial: temperature at the start [K]; the reference when left out. A plate that begins at another one has not grown yet,
            and begins with the stress of that.
        initial_gradient: gradient T_M through the thickness at the start [K/m].

    Raises:
        DeclarationError: the plate has another field, an element without thermal strain (``plate36``), a thickness that varies,
            or a material without conductivity or specific heat.
    """

    order: ClassVar[int] = 4  # values of fields are numbered behind all vectors
    name: str
    on: Plate
    reference: units.Temperature = 0.0
    initial: units.Temperature | None = None
    initial_gradient: units.TemperatureGradient = 0.0

    def contribute(self, build: Build) -> None:
        """Number the temperatures, warm the plate's elastic block, and add capacity and conduction."""
        plate = self.on.compiled(build)
        item = f"TemperatureField '{self.name}'"
        for field in build.fields:
            if isinstance(field, TemperatureMesh) and field.plate is plate:
                raise DeclarationError(
                    item, f"plate '{plate.name}' has the field '{field.name}'", "accepted is one field a plate"
                )
        if not SHELLS[plate.element.name].heated:
            accepted = " or ".join(f"'{name}'" for name, models in SHELLS.items() if models.heated)
            raise DeclarationError(
                item, f"plate '{plate.name}' has the element '{plate.element.name}'", f"accepted with temperatures is {accepted}"
            )
        if plate.thickness_factors is not None:
            raise DeclarationError(
                item, f"plate '{plate.name}' has thickness_factors", "accepted with temperatures is one thickness"
            )
        mesh = TemperatureMesh(self.name, plate, self.reference)
        initial = self.reference if self.initial is None else self.initial
        mesh.place(build, initial - self.reference, self.initial_gradient)
        plate.temperature = mesh
        self._warm(build, plate, mesh)
        block = plate_block(mesh, item)
        build.forces.append(block)

        def stored(state: State) -> float:
            return block.stored(state.q)

        build.signals.append(Signal(f"{self.name}.heat", "J", (), stored, f"heat stored in {plate.name} above the reference"))
        risen = ElementSum(mesh.coords[:, :4], mesh.integrals()[0] / (plate.size[0] * plate.size[1]))

        def mean(state: State) -> float:
            return self.reference + risen(state.q)

        build.signals.append(Signal(f"{self.name}.mean", "K", (), mean, f"mean temperature of {plate.name}"))
        for marker, at in self.on.markers.items():
            build.signals.extend(_marker_signals(marker, f"{plate.name}.{marker}", mesh, at))

    def _warm(self, build: Build, plate: PlateMesh, mesh: TemperatureMesh) -> None:
        """Let the plate's elastic block follow its temperatures."""
        if plate.strain == "rigid":
            return
        heated = SHELLS[plate.element.name].heated
        place = next(k for k, block in enumerate(build.forces) if block.name == plate.name and type(block) in heated)
        elements = HeatedElements(
            plate.name,
            plate.coords,
            plate.scale,
            plate.reference,
            plate.section,
            self.on.n_gauss,
            mesh.coords,
            plate.laminate.thermal_moments,
        )
        elastic = build.forces[place]
        build.forces[place], *added = heated[type(elastic)](elastic, elements)
        build.forces.extend(added)
        if plate.laminate.thermal_moments.any():
            build.notes += [
                f"'{joint}' clamps an edge of '{plate.name}' with the kind 'full', so it cannot grow where '{self.name}' heats "
                "it; the kind 'restrained' or 'sliding' lets it grow"
                for joint, clamped in build.fully_clamped
                if clamped == plate.name
            ]
            if self.initial not in (None, self.reference):
                build.beginnings.append(
                    f"'{self.name}' begins at {self.initial:g} K, '{plate.name}' is free of stress at {self.reference:g} K: it "
                    "begins with stress and vibrates faster than long steps resolve; where it is at rest at the start, give its "
                    "temperature there as 'reference', or start from an equilibrium"
                )


def _marker_signals(name: str, where: str, mesh: TemperatureMesh, at: tuple[float, float]) -> list[Signal]:
    element, shape = mesh.weights(np.array([at[0]]), np.array([at[1]]))
    (of_T_N, of_T_M), weights = np.split(mesh.coords[element[0]], 2), shape[0]
    return [
        Signal(f"{name}.T_N", "K", (), lambda s: float(weights.dot(s.q.take(of_T_N))), f"change of temperature of {where}"),
        Signal(f"{name}.T_M", "K/m", (), lambda s: float(weights.dot(s.q.take(of_T_M))), f"gradient of temperature at {where}"),
    ]
