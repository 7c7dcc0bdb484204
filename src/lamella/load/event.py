"""Events: something happens when a recorded signal passes through a value."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar, Literal

from lamella import units
from lamella.declaration import declaration
from lamella.errors import DeclarationError
from lamella.roles import Declaration
from lamella.trigger import Trigger

if TYPE_CHECKING:
    from lamella.dofs import Build

DIRECTIONS = {"rising": 1, "falling": -1, "any": 0}


@declaration
class Event(Declaration):
    """When a recorded signal passes through a value, the run ends, a force or latch changes, or the time is noted.

    The moment is found to a millionth of the step; the step ends there and the next begins with accelerations solved for anew.
    The result lists what happened in ``result.events``.

    Args:
        name: unique name.
        watch: name of a recorded signal, such as ``hinge.angle`` or ``tip.position``.
        value: value that it passes, in the signal's unit.
        component: label of its component, such as ``z``; none for a single number.
        direction: ``rising``, ``falling`` or ``any``.
        action: ``stop`` ends the run; ``switch_on`` and ``switch_off`` let a force or spring act from then on, or no longer (one
            that is switched on does not act before; where there are events for both, the one added first says whether it acts at
            the start); ``latch`` engages a latch; ``record`` only notes the time.
        target: name of the force, spring or latch that changes.
        once: whether it may happen only once in a run.
    """

    order: ClassVar[int] = 9  # after everything that can be its target
    name: str
    watch: str
    value: units.Number = 0.0
    component: str | None = None
    direction: Literal["rising", "falling", "any"] = "any"
    action: Literal["stop", "switch_on", "switch_off", "latch", "record"] = "record"
    target: str | None = None
    once: bool = True

    def __post_init__(self) -> None:
        needs = self.action not in ("stop", "record")
        if needs and self.target is None:
            raise ValueError(f"action = '{self.action}' without 'target'; accepted is the name of what changes")
        if not needs and self.target is not None:
            raise ValueError(f"target = '{self.target}'; the action '{self.action}' has none")

    def contribute(self, build: Build) -> None:
        """Add the trigger, and a switch on its target."""
        act, where = None, f" of '{self.target}'" if self.target else ""
        if self.action in ("switch_on", "switch_off"):
            forces = [block.name for block in (*build.loads, *build.forces)]
            act = build.switched(self._known(forces), on=self.action == "switch_on")
        elif self.action == "latch":
            act = build.latches[self._known(list(build.latches))]
        what = f"{self.component or ''} of {self.watch}".removeprefix(" of ")
        text = f"{self.action.replace('_', ' ')}{where}: {what} passes {self.value:g}"
        build.triggers.append(
            Trigger(
                self.name,
                None,
                DIRECTIONS[self.direction],
                text,
                act,
                self.action == "stop",
                self.once,
                self.watch,
                self.component,
                self.value,
            )
        )

    def _known(self, names: list[str]) -> str:
        if self.target is None or self.target not in names:
            accepted = f"accepted is {', '.join(dict.fromkeys(names))}" if names else "there is none in the system"
            raise DeclarationError(f"Event '{self.name}'", f"there is no such target '{self.target}'", accepted)
        return self.target
