"""The frozen result of compilation: blocks, constraints, and what is recorded."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import count
from typing import Any, Literal

import numpy as np
from scipy import sparse

from lamella.body.mesh import PlateMesh
from lamella.body.rigid_frame import RigidFrame
from lamella.constraint.dot_block import DotBlock
from lamella.dofs import Build, DotRow, LinearRow, ScalarField, Signal, Support
from lamella.errors import ModelError
from lamella.inertia import vector_mass, whole_mass
from lamella.memory import Memory
from lamella.roles import Bools, ConstraintBlock, Floats, ForceBlock, InertiaBlock, remembers
from lamella.state import State
from lamella.trigger import Sampler, Trigger

FARTHEST = 1e9
"""Distance of a body from the origin over its size."""


@dataclass(frozen=True)
class Model:
    """A system compiled to arrays; nothing in it changes while it is solved.

    Args:
        q0: reference and initial coordinates, shape (n_q,).
        v0: initial velocities, shape (n_q,).
        is_position: True for vectors that are positions, shape (n_q / 3,).
        magnitude: typical size of a change of each coordinate, shape (n_q,).
        inertias: parts of the mass matrix.
        forces: blocks of internal forces.
        loads: blocks of external loads; statics scales them by the load factor.
        constraints: blocks with Lagrange multipliers; the dot rows of joints come first, then those of bodies.
        rows: constant linear constraints, eliminated by the assembly.
        dots: dot rows of the joints; their multipliers are the first.
        supports: which rows belong to which support or joint.
        owners: name of the body each coordinate vector belongs to, shape (n_q / 3,).
        signals: what is recorded.
        breakpoints: times [s] at which a load or motion jumps, ascending.
        plates: compiled plates, for pictures and fields.
        triggers: events that may happen in a run.
        samplers: controllers that act at sample times of a run.
        rigid_bodies: compiled rigid bodies, for pictures.
        fields: scalar fields, whose values are the coordinates behind those of the vectors.
        redundant: what to do with constraints that repeat others: ``raise`` an error that names them, or ``drop`` them.
        notes: what the user should know about the system, in sentences.
        beginnings: what the user should know about a motion that begins in the reference configuration, in sentences.
        imperfection: what was added to the stress-free geometry of the plates, shape (n_q,); None when it is perfect.
        spin: angular velocity of the frame in which the system is described [rad/s], shape (3,); None when it is inertial.
        description: the system as data for result files, None when it was not given.
    """

    q0: Floats
    v0: Floats
    is_position: Bools
    magnitude: Floats
    inertias: tuple[InertiaBlock, ...]
    forces: tuple[ForceBlock, ...]
    loads: tuple[ForceBlock, ...]
    constraints: tuple[ConstraintBlock, ...]
    rows: tuple[LinearRow, ...]
    dots: tuple[DotRow, ...]
    supports: tuple[Support, ...]
    owners: tuple[str, ...]
    signals: tuple[Signal, ...]
    breakpoints: tuple[float, ...]
    plates: tuple[PlateMesh, ...]
    triggers: tuple[Trigger, ...] = ()
    samplers: tuple[Sampler, ...] = ()
    rigid_bodies: tuple[RigidFrame, ...] = ()
    fields: tuple[ScalarField, ...] = ()
    redundant: Literal["raise", "drop"] = "raise"
    notes: tuple[str, ...] = ()
    beginnings: tuple[str, ...] = ()
    imperfection: Floats | None = None
    spin: Floats | None = None
    description: Any = field(default=None, compare=False)

    def reset(self) -> None:
        """Put blocks with discrete state back to that of the start of a run."""
        for item in (*self.forces, *self.loads, *self.constraints, *self.samplers, *self._histories.values()):
            item.reset()

    def begin(self, state: State | None) -> None:
        """Forget earlier runs, and take over what the state remembers of those parts that the model has too."""
        self.reset()
        if state is None or state.memory is None:
            return
        for name, part in self._memories.items():
            if part.fits(state.memory.get(name)):
                part.recall(state.memory[name])

    def remembering(self, state: State) -> State:
        """The state just reached, with what the next ones depend on besides.

        This is where bristles hold, how often angles have turned, which latches are engaged, what events have switched, and the
        states of controllers.
        """
        memory = {name: part.memory() for name, part in self._memories.items()}
        return replace(state, memory=memory) if memory else state

    @cached_property
    def _histories(self) -> dict[str, Memory]:
        """What signals remember, by name."""
        return {f"{signal.name} {k}": part for signal in self.signals for k, part in enumerate(signal.history)}

    @cached_property
    def _memories(self) -> dict[str, Memory]:
        """All parts with a memory: those of one name are numbered."""
        found = dict(self._histories)
        for part in (*self.forces, *self.loads, *self.constraints, *self.samplers):
            if isinstance(part, Memory) and part.remembered:
                numbers = (f"{part.name} {k}" for k in count())
                found[next(name for name in numbers if name not in found)] = part
        return found

    def settle(self, state: State) -> None:
        """Tell all blocks that ``state`` has been accepted."""
        for block in self._settling:
            block.settle(state.t, state.q)

    @property
    def remembers(self) -> bool:
        """Whether a block has a discrete state."""
        return bool(self._settling)

    @cached_property
    def _settling(self) -> list[ForceBlock | ConstraintBlock]:
        return [block for block in (*self.forces, *self.loads, *self.constraints) if remembers(block)]

    def largest_displacement(self, shape: Floats) -> float:
        """Largest displacement in a change of all coordinates (n_q,) [m].

        A rigid body that turns about its origin is displaced as far as its points at its reach are.
        """
        moved = np.linalg.norm(self.vectors(shape), axis=1)
        largest = float(moved[self.is_position].max())
        for body in self.rigid_bodies:
            reach = self.magnitude[3 * body.first]
            largest = max(largest, reach * float(moved[body.first + 1 : body.first + 4].max()))
        return largest

    @cached_property
    def mass(self) -> sparse.csr_array:
        """The constant mass matrix M, sparse (n_q, n_q)."""
        return whole_mass(self.vector_mass, self.n_q)

    @cached_property
    def vector_mass(self) -> sparse.csr_array:
        """The matrix m of M = m x 1_3, sparse (n_vectors, n_vectors)."""
        return vector_mass(self.inertias, len(self.is_position))

    @property
    def n_q(self) -> int:
        """Number of coordinates before elimination."""
        return len(self.q0)

    @property
    def n_motion(self) -> int:
        """Number of coordinates that are components of vectors; the others are values of scalar fields."""
        return 3 * len(self.is_position)

    def vectors(self, coordinates: Floats) -> Floats:
        """The vectors among all coordinates (n_q,), shape (n_vectors, 3)."""
        return coordinates[: self.n_motion].reshape(-1, 3)

    @property
    def n_lam(self) -> int:
        """Number of Lagrange multipliers."""
        return sum(block.n_lam for block in self.constraints)

    def describe(self, coordinate: int) -> str:
        """A coordinate in words, for messages."""
        if coordinate >= self.n_motion:
            return next(f for f in reversed(self.fields) if f.first <= coordinate).describe(coordinate)
        vector, component = divmod(coordinate, 3)
        for plate in self.plates:
            if plate.first <= vector < plate.first + len(plate.is_position):
                return f"{'xyz'[component]} of {plate.describe(vector)}"
        for body in self.rigid_bodies:
            if body.first <= vector < body.first + 4:
                names = ("the position", "axis 1", "axis 2", "axis 3")
                return f"{'xyz'[component]} of {names[vector - body.first]} of rigid body '{body.name}'"
        return f"{'xyz'[component]} of an axis of a frame on '{self.owners[vector]}'"

    @classmethod
    def from_build(cls, build: Build, description: Any = None, redundant: Literal["raise", "drop"] = "raise") -> Model:
        """Freeze a build.

        Raises:
            ModelError: the system has no body with coordinates, or two signals share a name.
        """
        if build.n_vectors == 0:
            raise ModelError("the system has no body; add at least one, for example system.add(Plate(...))")
        _refuse_names(build.signals, [support.name for support in build.supports])
        _refuse_distances(build)
        return cls(
            q0=np.concatenate([np.concatenate(build.q).reshape(-1), *build.temperatures]),
            v0=np.concatenate([np.concatenate(build.v).reshape(-1), *map(np.zeros_like, build.temperatures)]),
            is_position=np.concatenate(build.is_position),
            magnitude=np.concatenate([np.repeat(np.concatenate(build.magnitude), 3), *(f.magnitude for f in build.fields)]),
            inertias=tuple(build.inertias),
            forces=tuple(build.forces),
            loads=tuple(build.loads),
            constraints=_numbered(build),
            rows=tuple(build.rows),
            dots=tuple(build.dots),
            supports=tuple(build.supports),
            triggers=tuple(build.triggers),
            samplers=tuple(build.samplers),
            owners=tuple(build.owners),
            signals=tuple(build.signals),
            breakpoints=tuple(sorted(set(build.breakpoints))),
            plates=tuple(body for body in build.bodies.values() if isinstance(body, PlateMesh)),
            rigid_bodies=tuple(body for body in build.bodies.values() if isinstance(body, RigidFrame)),
            fields=tuple(build.fields),
            redundant=redundant,
            notes=tuple(build.notes),
            beginnings=tuple(build.beginnings),
            imperfection=build.imperfection,
            spin=build.spin,
            description=description,
        )


def _numbered(build: Build) -> tuple[ConstraintBlock, ...]:
    """The constraint blocks, each with the number of its first multiplier."""
    rows = (("joints", build.dots, False), ("bodies", build.body_dots, True))
    dots = [DotBlock(name, items, body=body) for name, items, body in rows if items]
    blocks = tuple(block for block in (*dots, *build.constraints) if block.n_lam)
    first = 0
    for block in blocks:
        block.first = first
        first += block.n_lam
    return blocks


def _refuse_distances(build: Build) -> None:
    """Refuse bodies so far out that their own lengths are lost in the digits of their places."""
    places, own = np.concatenate(build.q)[np.concatenate(build.is_position)], np.concatenate(build.magnitude)
    far, owners = np.abs(places).max(axis=1), np.array(build.owners)[np.concatenate(build.is_position)]
    ratio = far / own[np.concatenate(build.is_position)]
    worst = int(ratio.argmax())
    if ratio[worst] > FARTHEST:
        text = f"body '{owners[worst]}' lies {far[worst]:g} m from the origin, {ratio[worst]:.1g} times its size"
        raise ModelError(f"{text}; accepted are at most {FARTHEST:g} times")


def _refuse_names(signals: list[Signal], supports: list[str]) -> None:
    """Refuse names that result files could not hold, or not tell from each other."""
    names = [signal.name for signal in signals]
    for name in (*names, *supports):
        if not name or name.startswith(".") or "/" in name or "\0" in name:
            raise ModelError(f"{name!r} cannot be recorded; accepted are names that are not empty and hold no '/'")
    for name in names:
        if names.count(name) > 1:
            stem = name.rpartition(".")[0]
            raise ModelError(f"two things are called '{stem}' and would both be recorded as '{name}'; give them different names")
