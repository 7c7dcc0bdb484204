"""What contacts of all kinds of obstacles share: the law, the start, and what is recorded."""

from __future__ import annotations

from abc import abstractmethod
from dataclasses import KW_ONLY
from typing import TYPE_CHECKING, Annotated

import numpy as np
from pydantic import Field, InstanceOf

from lamella.body.base import Marker
from lamella.body.ground import Ground
from lamella.body.rigid import RigidBody
from lamella.body.shell_body import ShellBody
from lamella.contact.block import ContactBlock, ContactTotals
from lamella.contact.friction import BristleFriction, Friction, RegularisedFriction
from lamella.contact.gap import Obstacle
from lamella.contact.point import Law
from lamella.contact.sheet import sheet_of
from lamella.contact.start import check_start
from lamella.declaration import declaration
from lamella.dofs import Build, Signal
from lamella.errors import DeclarationError
from lamella.roles import Declaration, Floats
from lamella.state import State
from lamella.units import NonNegative, Number, Positive, quantity

if TYPE_CHECKING:
    ContactDamping = float
else:
    ContactDamping = quantity("s/m", ge=0)

AXES = ("x", "y", "z")
Direction = tuple[Number, Number, Number]


class ContactPair(Declaration):
    """Fields that each contact declares itself, so that they come before its options."""

    name: str
    shell: InstanceOf[ShellBody]
    at: Marker


@declaration
class Contact(ContactPair):
    """Contact of a shell with a rigid obstacle, point by point: normal force, damping and friction.

    Points lie at the midpoints of equal cells of each element. The surface that touches lies half a thickness from the reference
    surface, on either side. With the depth delta and the area A of a cell in the reference configuration,

        N = k A delta^e (1 + alpha delta') >= 0,

    see :mod:`lamella.contact.point` for friction. The result holds ``<name>.force`` [N] and ``.torque`` about the marker [N m] of
    the shell on the obstacle, ``.normal`` [N], the sum of the normal forces, ``.friction_power`` [W], ``.points``, the number of
    points that touch, and ``.depth`` [m], the largest one.

    Args:
        stiffness: k [N/m^(2 + e)].
        exponent: e.
        damping: alpha [s/m]; contact never pulls.
        mu: coefficient of friction.
        friction: its law: :class:`RegularisedFriction`, or :class:`BristleFriction` where it must hold what is at rest.
        points: in each direction of an element.
    """

    _: KW_ONLY
    stiffness: Positive
    exponent: Annotated[Number, Field(ge=1.0, le=4.0)] = 1.5
    damping: ContactDamping = 0.0
    mu: NonNegative = 0.0
    friction: Friction = RegularisedFriction()
    points: Annotated[int, Field(ge=1, le=20)] = 7

    @property
    def item(self) -> str:
        """What messages call this contact."""
        return f"{type(self).__name__} '{self.name}'"

    def __post_init__(self) -> None:
        """Refuse a marker that is not on a rigid body."""
        if not isinstance(self.at.body, (RigidBody, Ground)):
            where = "the same shell" if self.at.body is self.shell else "a deformable body"
            raise DeclarationError(self.item, f"the marker {self.at} is on {where}", "accepted is a RigidBody's or the Ground's")
        if self.shell.laminate.offset != 0.0:
            raise DeclarationError(
                self.item,
                f"the laminate of '{self.shell.name}' has offset = {self.shell.laminate.offset:g} m",
                "accepted is a laminate whose two sides are equally far from the reference surface",
            )

    @abstractmethod
    def obstacle(self) -> Obstacle:
        """The obstacle, fixed in the body of the marker."""

    @property
    def law(self) -> Law:
        """The law of contact for the kernels."""
        given, law = self.friction, (self.stiffness, self.exponent, self.damping, self.mu)
        if isinstance(given, BristleFriction):
            return Law(*law, True, 0.0, given.stiffness, given.damping)
        return Law(*law, False, given.velocity, 0.0, 0.0)

    def contribute(self, build: Build) -> None:
        """Add the block and its signals.

        Raises:
            DeclarationError: the obstacle has no place at the start; see :func:`lamella.contact.start.check_start`.
        """
        mesh = self.shell.compiled(build)
        body = self.at.body
        first = body.compiled(build).first if isinstance(body, RigidBody) else None
        block = ContactBlock(self.name, sheet_of(mesh, self.points), self.obstacle(), self.law, first)
        check_start(self.item, self.at, build, mesh, block)
        build.forces.append(block)
        build.signals.extend(contact_signals(block))


def unit_axis(item: str, name: str, axis: Direction) -> tuple[float, float, float]:
    """A direction of unit length.

    Raises:
        DeclarationError: it is zero.
    """
    length = float(np.linalg.norm(axis))
    if length == 0.0:
        raise DeclarationError(item, f"{name} = (0, 0, 0)", "accepted is a vector that is not zero")
    x, y, z = (float(c) / length for c in axis)
    return x, y, z


def contact_signals(block: ContactBlock) -> list[Signal]:
    """What a contact records; evaluated once for each state."""
    last: list[tuple[State, ContactTotals]] = []

    def totals(state: State) -> ContactTotals:
        if not last or last[0][0] is not state:
            last[:] = [(state, block.totals(state.q, state.v))]
        return last[0][1]

    def force(state: State) -> Floats:
        return totals(state).force

    def torque(state: State) -> Floats:
        return totals(state).torque

    name = block.name
    return [
        Signal(f"{name}.force", "N", AXES, force, f"force of {name} on the obstacle"),
        Signal(f"{name}.torque", "N m", AXES, torque, f"torque of {name} on the obstacle about its centre"),
        Signal(f"{name}.normal", "N", (), lambda s: totals(s).normal, f"sum of the normal forces of {name}"),
        Signal(f"{name}.friction_power", "W", (), lambda s: totals(s).friction_power, f"heat of the friction of {name}"),
        Signal(f"{name}.points", "1", (), lambda s: float(totals(s).points), f"points of {name} that touch"),
        Signal(f"{name}.depth", "m", (), lambda s: totals(s).depth, f"largest depth of {name}"),
    ]
