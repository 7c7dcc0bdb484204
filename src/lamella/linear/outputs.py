"""Outputs of a linear model: recorded signals and their derivatives along changes of the state."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from lamella.assembly.equations import Equations
from lamella.dofs import Signal
from lamella.errors import DeclarationError
from lamella.linear.steady import SteadyState
from lamella.roles import Floats
from lamella.signals import system_signals

STEP = 1e-5
"""Step of central differences by positions, in sizes of the bodies: near the cube root of the rounding unit, 6e-6."""
OF_HISTORY = ("work.", "energy.balance")
"""Signals that sum over the steps of a run, so that no state alone has them."""


@dataclass(frozen=True)
class Change:
    """Small changes of a state, one in each column.

    Args:
        q, v, a: coordinates, velocities and accelerations, shape (n_q, n).
        lam: multipliers of all rows, shape (n_all, n).
        reaction: reaction of the eliminated constraints, shape (n_q, n).
    """

    q: Floats
    v: Floats
    a: Floats
    lam: Floats
    reaction: Floats


class Outputs:
    """Components of signals, with their values in a state.

    A derivative is the sum of three central differences: along the change of q, along that of v, and along that of (a, lam,
    reaction). Signals are at most quadratic in velocities and in forces, and most are in positions too: there central differences
    are exact up to rounding, whatever the step. Elsewhere their error is STEP^2 / 6 of the third derivative, 1e-11, and rounding
    is about 1e-16 / STEP of the signal's value for a change by the size of the body.

    Args:
        steady: the state.
        names: signals, or components such as ``tip.position.z``.

    Attributes:
        names, units: of each component.
        values: of each component in the state.

    Raises:
        DeclarationError: no such signal, one given twice, or one that sums over time.
    """

    def __init__(self, steady: SteadyState, names: Sequence[str]) -> None:
        found = named(names, steady.equations)
        self.names, self.signals = list(found), list(found.values())
        self.units = [signal.unit for signal, _ in self.signals]
        self._steady, self._state = steady, steady.state
        self._distinct = list({signal.name: signal for signal, _ in self.signals}.values())
        self.values = self._evaluate()

    def derivative(self, change: Change) -> Floats:
        """Change of each component, shape (n_output, n)."""
        size = self._steady.model.magnitude
        of_q = self._along(("q",), change, lambda d: STEP / np.abs(d["q"] / size).max())
        of_v = self._along(("v",), change, lambda d: max(np.abs(self._state.v / size).max(), 1.0) / np.abs(d["v"] / size).max())
        return of_q + of_v + self._along(("a", "lam", "reaction"), change, self._force_step)

    def direct(self, effects: dict[str, Floats]) -> Floats:
        """Derivatives by an input itself, from those of signals by name, shape (n_output,)."""
        return np.array([effects[s.name][k] if s.name in effects else 0.0 for s, k in self.signals])

    def _force_step(self, change: dict[str, Floats]) -> float:
        """A step that changes accelerations and forces by as much as they are, or by one where they vanish."""
        steps = []
        for name, part in change.items():
            largest = np.abs(part).max(initial=0.0)
            if largest:
                steps.append((np.abs(getattr(self._state, name)).max(initial=0.0) or 1.0) / largest)
        return min(steps)

    def _along(self, names: Sequence[str], change: Change, step_of: Callable[[dict[str, Floats]], float]) -> Floats:
        """Central differences along some parts of each change."""
        columns = change.q.shape[1]
        out = np.zeros((len(self.signals), columns))
        for column in range(columns):
            parts = {name: getattr(change, name)[:, column] for name in names}
            if not any(np.any(part) for part in parts.values()):
                continue
            step = step_of(parts)
            ends = []
            for sign in (1.0, -1.0):
                moved = {name: getattr(self._state, name) + sign * step * part for name, part in parts.items()}
                ends.append(self._evaluate(**moved))
            difference = ends[0] - ends[1]
            for k, (signal, _) in enumerate(self.signals):
                if signal.unit == "rad":  # an angle at the end of its range
                    difference[k] -= 2.0 * np.pi * np.round(difference[k] / (2.0 * np.pi))
            out[:, column] = difference / (2.0 * step)
        return out

    def _evaluate(self, **moved: Floats) -> Floats:
        state = replace(self._state, **moved)
        found = {signal.name: np.atleast_1d(signal.evaluate(state)) for signal in self._distinct}
        return np.array([float(found[signal.name][k]) for signal, k in self.signals])


def named(names: Sequence[str], equations: Equations) -> dict[str, tuple[Signal, int]]:
    """The components of signals that outputs mean, by their own names.

    Raises:
        DeclarationError: no such signal, one given twice, or one that sums over time.
    """
    known = {signal.name: signal for signal in system_signals(equations)}
    if not names:
        raise DeclarationError("linearise", "no outputs are given", "accepted is at least one recorded signal")
    found: dict[str, tuple[Signal, int]] = {}
    for name in names:
        for signal, component in components("linearise", name, known):
            if signal.name.startswith(OF_HISTORY):
                problem = f"the output '{name}' sums over the steps of a run"
                raise DeclarationError("linearise", problem, "accepted are signals that a state alone has")
            own = f"{signal.name}.{signal.labels[component]}" if signal.labels else signal.name
            if own in found:
                raise DeclarationError("linearise", f"the output '{own}' is given twice", "accepted is each once")
            found[own] = signal, component
    return found


def components(item: str, name: str, known: dict[str, Signal]) -> list[tuple[Signal, int]]:
    """A signal and the components meant by a name; ``item`` is who asks, for the message that there is none.

    Raises:
        DeclarationError: no signal has that name; those recorded are listed.
    """
    stem, _, label = name.rpartition(".")
    if name in known:
        signal = known[name]
        found = [(signal, k) for k in range(max(1, len(signal.labels)))]
    elif stem in known and label in known[stem].labels:
        found = [(known[stem], known[stem].labels.index(label))]
    else:
        recorded = ", ".join(key for key in known if not key.startswith(OF_HISTORY))
        raise DeclarationError(item, f"there is no output '{name}'", f"recorded are {recorded}, and their components")
    return found
