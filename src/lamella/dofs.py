"""Numbering: the build that declarations contribute to while a system is compiled."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Protocol

import numpy as np

from lamella.errors import ModelError
from lamella.kinematics import Frame, VectorRows
from lamella.memory import Memory
from lamella.roles import Bools, ConstraintBlock, Floats, ForceBlock, InertiaBlock, Ints
from lamella.switch import SwitchedForce
from lamella.trigger import Sampler, Trigger

if TYPE_CHECKING:
    from lamella.state import State


class Motion(Protocol):
    """A function of time with its first two derivatives (see ``lamella.math.profile``)."""

    def value(self, t: float) -> float: ...
    def rate(self, t: float) -> float: ...
    def acceleration(self, t: float) -> float: ...
    @property
    def breakpoints(self) -> tuple[float, ...]: ...


@dataclass(frozen=True)
class LinearRow:
    """One constant linear constraint ``coefs . q[coords] = constant + motion(t)``, eliminated before the solution.

    Args:
        label: says in words what is held, for messages.
        coords: coordinates, shape (n,).
        coefs: coefficients, shape (n,).
        constant: right-hand side without motion.
        motion: prescribed motion added to the right-hand side.
    """

    label: str
    coords: Ints
    coefs: Floats
    constant: float
    motion: Motion | None = None


@dataclass(frozen=True)
class Signal:
    """A quantity recorded while a solution runs.

    Args:
        name, unit, labels: for example ``tip.position`` and ``m``; names of the components, empty for a scalar.
        evaluate: gives the value from a state, shape (len(labels),) or scalar.
        description: a sentence for the result file.
        cumulative, history: whether it depends on all states, those not recorded as well; what it remembers of them.
        derivative: gives the derivative along a change of the state, from the state and the change; None where it is not known.
        polynomial: whether it is a sum of products of few parts of the state, as a torque is of places and forces.
        potential: whether it is the potential of all force blocks.
        of_vectors: numbers of the coordinate vectors whose places, velocities, accelerations and reactions alone tell it. Its
            value and derivative are then given for several states at once as well, whose parts have shapes (n, n_q), and the
            value has (n,) or (n, len(labels)). None where other parts are needed.
    """

    name: str
    unit: str
    labels: tuple[str, ...]
    evaluate: Callable[[State], Floats | float]
    description: str = ""
    cumulative: bool = False
    history: tuple[Memory, ...] = ()
    derivative: Callable[[State, State], Floats | float] | None = None
    polynomial: bool = False
    potential: bool = False
    of_vectors: Ints | None = None

    @property
    def by_tables(self) -> bool:
        """Whether the derivatives of the elements' tables tell its own: a stiff strain need not be differenced."""
        return self.derivative is not None or self.polynomial or self.potential


@dataclass(frozen=True)
class DotRow:
    """One constraint sum_k c_k u_k . w_k = constant + motion(t), at most quadratic in the coordinates.

    In coordinates that are vectors every joint is a list of such rows: that two lines are perpendicular, that a point lies on
    an axis, that a director has unit length.

    Args:
        label: says in words what is held, for messages.
        terms: (c_k, u_k, w_k).
        constant: right-hand side without motion.
        motion: prescribed motion added to the right-hand side.
    """

    label: str
    terms: tuple[tuple[float, VectorRows, VectorRows], ...]
    constant: float = 0.0
    motion: Motion | None = None

    def sum(self, vectors: Floats) -> float:
        """The sum on the left-hand side; ``vectors`` are all coordinate vectors, shape (n_vectors, 3)."""
        return sum(c * float(u.at(vectors) @ w.at(vectors)) for c, u, w in self.terms)

    def linear(self) -> LinearRow | None:
        """The same row as a linear one when one vector of every term is fixed in space, else None."""
        coords, coefs, constant = [], [], self.constant
        for c, u, w in self.terms:
            if len(u.vectors) and len(w.vectors):
                return None
            fixed, moving = (u, w) if len(w.vectors) else (w, u)
            constant -= c * float(fixed.constant @ moving.constant)
            direction = np.where(np.abs(fixed.constant) > 1e-15 * np.abs(fixed.constant).max(), fixed.constant, 0.0)
            for component in np.flatnonzero(direction):
                coords.append(3 * moving.vectors + component)
                coefs.append(c * direction[component] * moving.weights)
        unique, inverse = np.unique(np.concatenate(coords), return_inverse=True)
        summed = np.bincount(inverse, np.concatenate(coefs), minlength=len(unique)).astype(float)
        return LinearRow(self.label, unique, summed, constant, self.motion)


@dataclass(frozen=True)
class Support:
    """What holds a body: its rows, the point its torque refers to, and the side on which its reaction is counted.

    Args:
        name: the support's or joint's name.
        rows: numbers of its linear rows.
        centre: the point to which the torque refers.
        dots: numbers of its rows among the dot rows of the joints.
        side: name of the body on which the reaction acts; every body when None.
        frame: joint frame in which the reaction is reported as well, None for the inertial frame alone.
        single: whether one generalised force is reported, the sum over its rows, instead of force and torque.
        edge: whether it holds an edge, whose end nodes another edge may hold as well.
        quantity: name and unit of that force.
    """

    name: str
    rows: tuple[int, ...]
    centre: VectorRows
    dots: tuple[int, ...] = ()
    side: str | None = None
    frame: Frame | None = None
    single: bool = False
    edge: bool = False
    quantity: tuple[str, str] = ("force", "N")


class ScalarField(Protocol):
    """A field of scalars, such as temperatures, whose values are coordinates behind the vectors."""

    name: str
    first: int
    """Number of its first coordinate."""
    magnitude: Floats
    """Typical size of a change of each value, shape (n,)."""
    uniform: Floats
    """A change that is the same everywhere, of typical size, shape (n,)."""

    def describe(self, coordinate: int) -> str:
        """A value in words, by its coordinate."""
        ...


@dataclass
class Build:
    """What declarations have contributed so far. Vectors are numbered in the order of declaration."""

    q: list[Floats] = field(default_factory=list)
    v: list[Floats] = field(default_factory=list)
    is_position: list[Bools] = field(default_factory=list)
    magnitude: list[Floats] = field(default_factory=list)
    forces: list[ForceBlock] = field(default_factory=list)
    loads: list[ForceBlock] = field(default_factory=list)
    inertias: list[InertiaBlock] = field(default_factory=list)
    constraints: list[ConstraintBlock] = field(default_factory=list)
    rows: list[LinearRow] = field(default_factory=list)
    dots: list[DotRow] = field(default_factory=list)
    body_dots: list[DotRow] = field(default_factory=list)
    supports: list[Support] = field(default_factory=list)
    signals: list[Signal] = field(default_factory=list)
    bodies: dict[str, object] = field(default_factory=dict)
    triggers: list[Trigger] = field(default_factory=list)
    samplers: list[Sampler] = field(default_factory=list)
    latches: dict[str, Callable[[], None]] = field(default_factory=dict)
    breakpoints: list[float] = field(default_factory=list)
    frames: dict[str, Frame] = field(default_factory=dict)
    owners: list[str] = field(default_factory=list)
    n_vectors: int = 0
    fields: list[ScalarField] = field(default_factory=list)
    temperatures: list[Floats] = field(default_factory=list)
    fully_clamped: list[tuple[str, str]] = field(default_factory=list)
    """Joints that hold the strain at an edge of a plate at zero, with the name of the plate."""
    notes: list[str] = field(default_factory=list)
    beginnings: list[str] = field(default_factory=list)
    """What the user should know about the system, and about a motion that begins as the bodies are declared, in sentences."""
    imperfection: Floats | None = None
    """Added to the stress-free geometry of elastic plates, all coordinates of motion in the order of numbering."""
    spin: Floats | None = None
    """Angular velocity of the frame in which the system is described [rad/s], shape (3,)."""

    def imperfect(self, q: Floats) -> Floats:
        """The vectors of a body that is numbered next, shape (n, 3), with their imperfection."""
        if self.imperfection is None:
            return q
        return q + self.imperfection[3 * self.n_vectors : 3 * (self.n_vectors + len(q))].reshape(-1, 3)

    def vectors(self, owner: str, q: Floats, v: Floats, is_position: Bools, magnitude: Floats) -> int:
        """Number a body's coordinate vectors; gives the number of the first.

        Args:
            owner: name of the body.
            q: initial values, shape (n, 3).
            v: initial velocities, shape (n, 3).
            is_position: True where a vector is a position (moved by a translation), shape (n,).
            magnitude: typical size of a change of each vector (length for a position, 1 for a slope) in any units, shape (n,).

        Raises:
            ModelError: scalar fields, which lie behind all vectors, are numbered already.
        """
        if self.fields:
            raise ModelError(f"vectors of '{owner}' would be numbered behind the field '{self.fields[0].name}'")
        first = self.n_vectors
        self.q.append(np.asarray(q, float))
        self.v.append(np.asarray(v, float))
        self.is_position.append(np.asarray(is_position, bool))
        self.magnitude.append(np.asarray(magnitude, float))
        self.n_vectors += len(q)
        self.owners.extend([owner] * len(q))
        return first

    def scalars(self, scalar_field: ScalarField, values: Floats) -> int:
        """Number the values of a scalar field, behind all vectors; gives the number of the first coordinate.

        Args:
            scalar_field: the field.
            values: initial values, shape (n,).
        """
        first = 3 * self.n_vectors + sum(map(len, self.temperatures))
        self.fields.append(scalar_field)
        self.temperatures.append(np.asarray(values, float))
        return first

    @property
    def initial(self) -> Floats:
        """All coordinate vectors numbered so far in the reference configuration, shape (n_vectors, 3)."""
        return np.concatenate(self.q) if self.q else np.zeros((0, 3))

    def hold(
        self,
        name: str,
        rows: Sequence[LinearRow | DotRow],
        centre: VectorRows,
        side: str | None = None,
        frame: Frame | None = None,
        *,
        single: bool = False,
        edge: bool = False,
        quantity: tuple[str, str] = ("force", "N"),
    ) -> None:
        """Add a support or joint, whose reaction force, and torque about ``centre``, are reported under ``name``.

        Rows that are linear are eliminated, the others take multipliers. The arguments are those of :class:`Support`.
        """
        linear, dots = len(self.rows), len(self.dots)
        for row in rows:
            if row.motion is not None:
                self.breakpoints.extend(row.motion.breakpoints)
            self._add(row, self.dots)
        numbers = tuple(range(linear, len(self.rows))), tuple(range(dots, len(self.dots)))
        self.supports.append(Support(name, numbers[0], centre, numbers[1], side, frame, single, edge, quantity))

    def constrain(self, block: ConstraintBlock) -> None:
        """Add a block of constraints with multipliers, and the jumps of its motions."""
        self.breakpoints.extend(block.breakpoints)
        self.constraints.append(block)

    def switched(self, name: str, *, on: bool) -> Callable[[], None]:
        """Let an event switch the force called ``name``; gives the function that does it.

        Args:
            name: name of a force or spring.
            on: whether the event switches it on; it then does not act at the start of a run.
        """
        blocks = []
        for group in (self.forces, self.loads):
            for k, block in enumerate(group):
                if block.name == name:
                    if type(block) is not SwitchedForce:  # one that a controller holds is switched as a whole
                        block = group[k] = SwitchedForce(block, on=not on)
                    blocks.append(block)

        def switch() -> None:
            for block in blocks:
                block.on = on

        return switch

    def tie(self, rows: Sequence[LinearRow | DotRow]) -> None:
        """Add the equations by which a body holds itself together; they have no reaction that is reported."""
        for row in rows:
            self._add(row, self.body_dots)

    def _add(self, row: LinearRow | DotRow, dots: list[DotRow]) -> None:
        found = row.linear() if isinstance(row, DotRow) else row
        if found is not None:
            self.rows.append(found)
        else:
            assert isinstance(row, DotRow)
            dots.append(row)

    def body(self, name: str) -> object:
        """The compiled form of a body, by its name."""
        if name not in self.bodies:
            raise ModelError(f"body '{name}' is referred to but was not added to the system; call system.add({name}) first")
        return self.bodies[name]
