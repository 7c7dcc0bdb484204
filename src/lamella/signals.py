"""Signals of a whole system: energies and work, beside those of its parts."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from lamella.assembly.equations import Equations
from lamella.assembly.forces import ForceSum
from lamella.dofs import Signal
from lamella.memory import Memory
from lamella.reaction_signals import reaction_signals
from lamella.roles import Floats, ForceBlock
from lamella.state import OncePerState, State

LOAD_FACTOR = Signal("load_factor", "1", (), lambda state: state.factor, "factor of loads and support motions")
"""Recorded first in statics."""


def system_signals(equations: Equations) -> list[Signal]:
    """Everything recorded in a run: the model's own signals, reactions, energies and work. Made anew for each run."""
    model = equations.model
    reactions = [signal for support in model.supports for signal in reaction_signals(support, equations)]
    return [*model.signals, *reactions, *energy_signals(equations)]


def signals_named(equations: Equations, names: Sequence[str]) -> dict[str, Signal]:
    """Some of them, and the load factor, by name; no more is made than these and what belongs to them."""
    known = {signal.name: signal for signal in (LOAD_FACTOR, *equations.model.signals)}
    for support in equations.model.supports:
        if any(name not in known and name.startswith(f"{support.name}.") for name in names):
            known |= {signal.name: signal for signal in reaction_signals(support, equations)}
    if not known.keys() >= set(names):
        known |= {signal.name: signal for signal in energy_signals(equations)}
    return {name: known[name] for name in names}


class WorkMeter(Memory):
    """Work done since the first state given, with the force averaged over each step: sum 1/2 (f_n + f_n+1) . (x_n+1 - x_n).

    For constant forces this is exact whatever the step.

    Args:
        force_and_path: gives the force and the coordinates it works on, in arrays that are not written again.
    """

    remembered = ("work", "_last")

    def __init__(self, force_and_path: Callable[[State], tuple[Floats, Floats]]) -> None:
        self.force_and_path = force_and_path
        self.work = 0.0
        self._last: tuple[Floats, Floats] | None = None

    def __call__(self, state: State) -> float:
        f, x = self.force_and_path(state)
        if self._last is not None:
            self.work += 0.5 * float((f + self._last[0]).dot(x - self._last[1]))
        self._last = f, x
        return self.work


class ActuatorMeter(Memory):
    """Work put into potentials that change with time or temperature: sum over steps of the change of V(t, q, T) with t and T at
    both ends, averaged over the positions at both ends.

    Args:
        blocks: blocks whose potential depends on time or temperature.
        n_motion: number of coordinates of motion, which come first.
        potential: gives their V in a state.
    """

    remembered = ("work", "_last")

    def __init__(self, blocks: Sequence[ForceBlock], n_motion: int, potential: Callable[[State], float]) -> None:
        self.blocks, self.work, self.n_motion, self.potential = blocks, 0.0, n_motion, potential
        self._last: tuple[float, Floats] | None = None
        self._last_potential: float | None = None

    def __call__(self, state: State) -> float:
        if not self.blocks:
            return 0.0
        n, q, now = self.n_motion, state.q, self.potential(state)
        if self._last is not None:
            t_before, before = self._last
            last = self._at(t_before, before) if self._last_potential is None else self._last_potential
            here = self._at(state.t, np.concatenate([before[:n], q[n:]]))
            there = self._at(t_before, np.concatenate([q[:n], before[n:]]))
            self.work += 0.5 * ((here - last) + (now - there))
        self._last, self._last_potential = (state.t, q), now
        return self.work

    def _at(self, t: float, q: Floats) -> float:
        return sum(block.energy(t, q) for block in self.blocks)

    def recall(self, memory: dict[str, Any]) -> None:
        """Take back what was remembered."""
        super().recall(memory)
        self._last_potential = None


class Baseline(Memory):
    """The first of all values given."""

    remembered = ("first",)

    def __init__(self) -> None:
        self.first: float | None = None

    def __call__(self, value: float) -> float:
        """The value, less the first one."""
        if self.first is None:
            self.first = value
        return value - self.first


def _heat(damped: Sequence[ForceBlock], n_q: int) -> Callable[[State], tuple[Floats, Floats]]:
    """The function from states to damping forces, those with velocities less those without, and the coordinates they work on.

    A damper that relaxes within a step does the work of its mean force on the little way that is left, not its first power
    for half the step.
    """
    dampers = ForceSum(damped, n_q)
    return lambda state: (dampers.damping(state.t, state.q, state.v), state.q)


def energy_signals(equations: Equations) -> list[Signal]:
    """Kinetic and strain energy, work of loads and of moving supports, heat, and the balance of them all.

    The balance is kinetic + strain + dissipated - work of loads - work of supports, minus its first value: zero for an exact
    solution; in motion what the integrator has damped (negative) or gained.
    """
    model, elimination = equations.model, equations.elimination
    damped = [block for block in model.forces if block.depends_on_velocity and not block.first_order]
    n = model.n_motion
    moves = elimination.moves or equations.constraints.moves
    mechanical = np.array([elimination.rows[k].coords[0] < n for k in elimination.moving], dtype=float)
    forces_of = elimination.forces_of(elimination.moving)

    def kinetic(state: State) -> float:
        v = state.v
        return 0.5 * float(v.dot(equations.momentum(v))) if v.dot(v) else 0.0  # statics then needs no mass

    def kinetic_change(state: State, change: State) -> float:
        return float(change.v.dot(equations.momentum(state.v))) if state.v.dot(state.v) else 0.0

    potentials = OncePerState(lambda s: [block.energy(s.t, s.q) for block in model.forces])

    def strain(state: State) -> float:
        return float(sum(potentials(state)))

    def power(state: State) -> float:
        return sum(block.dissipation(state.t, state.q, state.v) for block in damped)

    def nothing(state: State) -> float:
        return 0.0

    loads = WorkMeter(lambda s: (-s.factor * equations.loads(s.t, s.q, s.v)[:n], s.q[:n]))
    constraints = equations.constraints
    along_motions = WorkMeter(
        lambda s: (
            np.concatenate([mechanical * forces_of(s.reaction), -s.lam]),
            np.concatenate([s.factor * elimination.motions(s.t), constraints.prescribed(s.t)]),
        )
    )
    varying = [k for k, block in enumerate(model.forces) if block.varies]
    driven = [model.forces[k] for k in varying]
    actuators = ActuatorMeter(driven, n, lambda s: sum(potentials(s)[k] for k in varying))

    def supports(state: State) -> float:
        return (along_motions(state) if moves else 0.0) + actuators(state)

    along_the_way = WorkMeter(_heat(damped, model.n_q)) if damped else nothing

    settled = Baseline()  # a run may begin with what an earlier one has left behind

    def dissipated(state: State) -> float:
        return along_the_way(state) + settled(sum(block.settled_heat() for block in model.forces))

    last: dict[str, float] = {}
    from_start = Baseline()

    def kept(name: str, evaluate: Callable[[State], float]) -> Callable[[State], float]:
        def value(state: State) -> float:
            last[name] = evaluate(state)
            return last[name]

        return value

    def balance(state: State) -> float:
        total = last["kinetic"] + last["strain"] + last["dissipated"] - last["loads"] - last["supports"]
        return from_start(total)

    return [
        Signal("energy.kinetic", "J", (), kept("kinetic", kinetic), "kinetic energy", derivative=kinetic_change),
        Signal("energy.strain", "J", (), kept("strain", strain), "strain energy", potential=True),
        Signal("work.loads", "J", (), kept("loads", loads), "work of the loads", cumulative=True, history=(loads,)),
        Signal(
            "work.supports",
            "J",
            (),
            kept("supports", supports),
            "work of moving supports, drives and thermal strain",
            cumulative=True,
            history=(along_motions, actuators),
        ),
        Signal(
            "work.dissipated",
            "J",
            (),
            kept("dissipated", dissipated),
            "energy turned into heat by damping",
            cumulative=True,
            history=(along_the_way, settled) if isinstance(along_the_way, Memory) else (settled,),
        ),
        Signal("power.dissipated", "W", (), power, "power turned into heat by damping"),
        Signal("energy.balance", "J", (), balance, "energy balance: zero for an exact solution", history=(from_start,)),
    ]
