"""Fields on the surface of a moving plate, on structured grids of points, for pictures and for files."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol

import numpy as np

from lamella.errors import DeclarationError
from lamella.material.laminate import Laminate
from lamella.material.recovery import Criterion
from lamella.material.recovery import Surface as Face
from lamella.roles import Floats

if TYPE_CHECKING:
    from lamella.body.mesh import TemperatureSource
    from lamella.body.sample import PlateSample
    from lamella.result import Result

VECTOR = ("x", "y", "z")
PLANE = ("xx", "yy", "xy")
HEAT = {"temperature_top", "temperature_bottom", "T_N", "T_M"}
"""Fields of plates with a temperature field."""
BOTH: tuple[Face, Face] = ("bottom", "top")


class Grid(Protocol):
    """Points on a compiled plate."""

    def sample(self, q: Floats) -> PlateSample:
        """Positions, normals and strains."""
        ...

    def positions(self, q: Floats) -> Floats:
        """Positions alone, linear in q: those of rates are velocities."""
        ...


class Surface(Protocol):
    """A compiled plate, as far as fields need it."""

    name: str
    laminate: Laminate
    loops: tuple[bool, bool]
    temperature: TemperatureSource | None

    def grid(self, per_element: int = 4) -> Grid:
        """A regular grid of points."""
        ...


class Snapshot:
    """One plate at one frame, or at several (...).

    Args:
        plate: the compiled plate.
        grid: points on it.
        q: coordinates of the frame, shape (..., n_q).
        v: their rates, shape (..., n_q); NaN where the frames keep none.
        reference: the points in the reference configuration.
    """

    def __init__(self, plate: Surface, grid: Grid, q: Floats, v: Floats, reference: PlateSample) -> None:
        self.plate, self.reference, self._grid, self._v = plate, reference, grid, v
        self.now = grid.sample(q)

    @property
    def displacement(self) -> Floats:
        """Displacement from the reference configuration [m], shape (..., my, mx, 3)."""
        return self.now.r - self.reference.r

    @property
    def velocity(self) -> Floats:
        """Velocity [m/s], shape (..., my, mx, 3)."""
        return self._grid.positions(self._v)


class SurfaceSampler:
    """All plates of a result, frame by frame or at several at once.

    Args:
        result: of a solution, or read from a file.
        per_element: grid intervals along each side of an element.
    """

    def __init__(self, result: Result, per_element: int) -> None:
        from lamella.io.results import frame_velocities

        self._result, self._velocities = result, frame_velocities(result)
        self._grids = [plate.grid(per_element) for plate in result.model.plates]
        self._references = [grid.sample(result.model.q0) for grid in self._grids]

    def at(self, frame: int | slice) -> list[Snapshot]:
        """The plates at one frame, or at those of a slice, which come first in every array: it takes hardly longer."""
        q, v = self._result.frame_q[frame], self._velocities[frame]
        plates = zip(self._result.model.plates, self._grids, self._references, strict=True)
        return [Snapshot(plate, grid, q, v, reference) for plate, grid, reference in plates]


@dataclass(frozen=True)
class SurfaceField:
    """A field on the surface.

    Args:
        name: for callers and files.
        title: for people, without the unit.
        unit: SI unit.
        labels: names of the components, empty for a scalar.
        evaluate: values on the grid, shape (..., my, mx) or (..., my, mx, len(labels)).
    """

    name: str
    title: str
    unit: str
    labels: tuple[str, ...]
    evaluate: Callable[[Snapshot], Floats]


def _strains(first: int) -> Callable[[Snapshot], Floats]:
    return lambda shot: shot.now.strains[..., first : first + 3]


def _von_mises(shot: Snapshot, places: Sequence[tuple[int, Face]]) -> Floats:
    return np.max([shot.now.von_mises(ply, face) for ply, face in places], axis=0)


def _warm(evaluate: Callable[[Snapshot, TemperatureSource], Floats | float]) -> Callable[[Snapshot], Floats]:
    """A field of plates that have a temperature."""

    def on_grid(shot: Snapshot) -> Floats:
        source = shot.plate.temperature
        if source is None:
            raise DeclarationError(
                "picture",
                f"plate '{shot.plate.name}' has no temperature",
                "accepted is a field of its shape, or add a TemperatureField",
            )
        return np.broadcast_to(np.asarray(evaluate(shot, source), float), shot.now.r.shape[:-1])

    return on_grid


def _temperature(shot: Snapshot, source: TemperatureSource, boundary: int) -> Floats:
    """Absolute temperature [K] at the bottom (0) or top (-1) of the plate."""
    return source.reference + np.asarray(shot.now.T_N) + shot.plate.laminate.z[boundary] * np.asarray(shot.now.T_M)


def _faces(laminate: Laminate) -> list[tuple[int, Face]]:
    """Bottom and top of every ply: stress is linear within one, so its extremes are there."""
    return [(ply, face) for ply in range(len(laminate.layers)) for face in BOTH]


def _failure(criterion: Criterion) -> Callable[[Snapshot], Floats]:
    def largest(shot: Snapshot) -> Floats:
        return np.max([shot.now.failure_index(ply, face, criterion) for ply, face in _faces(shot.plate.laminate)], axis=0)

    return largest


FIELDS = {
    field.name: field
    for field in (
        SurfaceField("displacement", "Displacement", "m", VECTOR, lambda shot: shot.displacement),
        SurfaceField("velocity", "Velocity", "m/s", VECTOR, lambda shot: shot.velocity),
        SurfaceField("normal", "Unit normal", "1", VECTOR, lambda shot: shot.now.n),
        SurfaceField("membrane_strain", "Membrane strain", "1", PLANE, _strains(0)),
        SurfaceField("curvature", "Change of curvature", "1/m", PLANE, _strains(3)),
        SurfaceField("strain_energy_density", "Strain energy density", "J/m²", (), lambda shot: shot.now.energy_density()),
        SurfaceField("von_mises_top", "Von Mises stress, top", "Pa", (), lambda shot: _von_mises(shot, [(-1, "top")])),
        SurfaceField("von_mises_bottom", "Von Mises stress, bottom", "Pa", (), lambda shot: _von_mises(shot, [(0, "bottom")])),
        SurfaceField("von_mises", "Von Mises stress, all plies", "Pa", (), lambda s: _von_mises(s, _faces(s.plate.laminate))),
        SurfaceField("tsai_hill", "Tsai-Hill index, all plies", "1", (), _failure("tsai-hill")),
        SurfaceField("tsai_wu", "Tsai-Wu index, all plies", "1", (), _failure("tsai-wu")),
        SurfaceField("temperature_top", "Temperature, top", "K", (), _warm(lambda shot, T: _temperature(shot, T, -1))),
        SurfaceField("temperature_bottom", "Temperature, bottom", "K", (), _warm(lambda shot, T: _temperature(shot, T, 0))),
        SurfaceField("T_N", "Change of temperature", "K", (), _warm(lambda shot, _: shot.now.T_N)),
        SurfaceField("T_M", "Temperature gradient", "K/m", (), _warm(lambda shot, _: shot.now.T_M)),
    )
}
"""Every field by its name; those "of all plies" are the largest value over the plies and their two faces."""


def available(result: Result) -> list[SurfaceField]:
    """The fields a result can give: velocities need frames that keep them, failure indices strengths, temperatures a field."""
    from lamella.io.results import frame_velocities

    moving = bool(np.isfinite(frame_velocities(result)).all())
    strong = all(_has_strengths(plate.laminate) for plate in result.model.plates)
    warm = all(plate.temperature is not None for plate in result.model.plates)
    missing = (set() if moving else {"velocity"}) | (set() if strong else {"tsai_hill", "tsai_wu"}) | (set() if warm else HEAT)
    return [field for name, field in FIELDS.items() if name not in missing]


def _has_strengths(laminate: Laminate) -> bool:
    names = ("Xt", "Xc", "Yt", "Yc", "S12")
    return all(getattr(lamina, name) is not None for lamina in laminate.laminas for name in names)


def select(name: str) -> tuple[SurfaceField, int | None]:
    """The field ``name``, or its component ``name.component``; the magnitude of a vector has no component.

    Raises:
        DeclarationError: no such field or component.
    """
    stem, _, label = name.partition(".")
    if stem not in FIELDS:
        raise DeclarationError("picture", f"no field '{name}'", f"accepted are {', '.join(FIELDS)}")
    field = FIELDS[stem]
    if not label:
        if field.labels == PLANE:
            names = ", ".join(f"{stem}.{one}" for one in PLANE)
            raise DeclarationError("picture", f"field '{name}' has no magnitude", f"accepted are {names}")
        return field, None
    if label not in field.labels:
        names = ", ".join(f"{stem}.{one}" for one in field.labels)
        raise DeclarationError("picture", f"field '{stem}' has no component '{label}'", f"accepted are {names or stem}")
    return field, field.labels.index(label)


def scalar(field: SurfaceField, component: int | None, shot: Snapshot) -> Floats:
    """One number at each grid point: a scalar field, a component, or the magnitude of a vector; shape (..., my, mx)."""
    values = field.evaluate(shot)
    if not field.labels:
        return values
    return np.linalg.norm(values, axis=-1) if component is None else values[..., component]
