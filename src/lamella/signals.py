"""Signals of a whole system: reactions of supports, energies and work."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from lamella._jit import njit
from lamella.assembly.equations import Equations
from lamella.assembly.forces import ForceSum
from lamella.assembly.operator import SumOperator
from lamella.constraint.dot_block import DotBlock
from lamella.dofs import Signal, Support
from lamella.kinematics import StackedRows, vectors_of
from lamella.memory import Memory
from lamella.roles import Floats, ForceBlock, Ints
from lamella.state import OncePerState, State

AXES = ("x", "y", "z")
LOAD_FACTOR = Signal("load_factor", "1", (), lambda state: state.factor, "factor of loads and support motions")
"""Recorded first in statics."""


def system_signals(equations: Equations) -> list[Signal]:
    """Everything recorded in a run: the model's own signals, reactions, energies and work. Made anew for each run."""
    model = equations.model
    reactions = [signal for support in model.supports for signal in reaction_signals(support, equations)]
    return [*model.signals, *reactions, *energy_signals(equations)]


def reaction_signals(support: Support, equations: Equations) -> list[Signal]:
    """Force and torque that a support or joint exerts on its body, or on the body of its side.

    The generalised force R = C^T mu - Phi_q^T lam acts on vectors x_k; a virtual translation gives the force, the sum over
    positions of R_k, and a virtual rotation about the centre c the torque, the sum of (x_k - c) x R_k with c for positions only.
    With P = sum_k (x_k - c) R_k^T the components of the torque are P_yz - P_zy, P_zx - P_xz, P_xy - P_yx.
    """
    model = equations.model
    places = {row: k for k, row in enumerate(equations.elimination.kept)}
    own = np.array([places[row] for row in support.rows if row in places], dtype=np.int64)
    if support.single:
        kind, unit = support.quantity
        forces_of = equations.elimination.forces_of(own)
        return [
            Signal(
                f"{support.name}.{kind}",
                unit,
                (),
                lambda s: float(forces_of(s.reaction).sum()),
                f"generalised {kind} of {support.name}",
                polynomial=True,
            )
        ]
    numbers, held_coords, coefs = equations.elimination.entries_of(own)
    dots = DotBlock(support.name, [model.dots[row] for row in support.dots]) if support.dots else None
    lam = np.array(support.dots, dtype=np.int64)  # the dot rows of joints come first
    vectors = np.unique(np.concatenate([held_coords, np.zeros(0, np.int64) if dots is None else dots.j_cols]) // 3)
    if support.side is not None:
        vectors = np.array([k for k in vectors if model.owners[k] == support.side], dtype=np.int64)
    coords = (3 * vectors[:, None] + np.arange(3)).reshape(-1)
    weights, centre = model.is_position[vectors].astype(float), support.centre
    entries = np.empty(0 if dots is None else len(dots.j_cols))
    place = np.full(model.n_q, len(coords))  # what acts on the other side is left behind
    place[coords] = np.arange(len(coords))
    places = None if dots is None else place[dots.j_cols]
    acting = place[held_coords] < len(coords)
    held = SumOperator(place[held_coords[acting]], numbers[acting], coefs[acting], len(coords))
    forces_of = equations.elimination.forces_of(own)

    def evaluate(state: State) -> Floats:
        f = held(forces_of(state.reaction))
        if dots is not None and places is not None:
            dots.jacobian(state.t, state.q, entries)
            f -= np.bincount(places, entries * state.lam[lam][dots.j_rows], minlength=len(coords) + 1)[:-1]
        found = np.empty(6)
        _resultants(state.q, vectors, weights, f, centre.vectors, centre.weights, centre.constant, found)
        return found

    shared = OncePerState(evaluate)

    def force(state: State) -> Floats:
        return shared(state)[:3]

    def torque(state: State) -> Floats:
        return shared(state)[3:]

    on = f" on {support.side}" if support.side else ""
    signals = [
        Signal(f"{support.name}.force", "N", AXES, force, f"force of {support.name}{on}", polynomial=True),
        Signal(f"{support.name}.torque", "N m", AXES, torque, f"torque of {support.name}{on} about its centre", polynomial=True),
    ]
    frame = support.frame
    if frame is None:
        return signals

    axes = StackedRows(frame.axes)
    into_frame = OncePerState(lambda state: axes.at(vectors_of(state.q)))  # R_WF^T, whose rows are the axes

    def local(evaluate: Callable[[State], Floats]) -> Callable[[State], Floats]:
        return lambda state: into_frame(state).dot(evaluate(state))

    where = "in the joint frame of a"
    return [
        *signals,
        Signal(f"{support.name}.force_local", "N", AXES, local(force), f"force of {support.name}{on} {where}", polynomial=True),
        Signal(
            f"{support.name}.torque_local", "N m", AXES, local(torque), f"torque of {support.name}{on} {where}", polynomial=True
        ),
    ]


@njit
def _resultants(
    q: Floats, vectors: Ints, weights: Floats, f: Floats,
    centre_vectors: Ints, centre_weights: Floats, constant: Floats, out: Floats,
) -> None:  # fmt: skip
    """Force and torque out (6,) of forces f on vectors x_k: sum w_k f_k and sum (x_k - w_k c) x f_k.

    The weight w_k is 1 for positions, else 0; the centre c is a sum of vectors with weights, and a constant.
    """
    c0, c1, c2 = constant[0], constant[1], constant[2]
    for i in range(len(centre_vectors)):
        k, w = 3 * centre_vectors[i], centre_weights[i]
        c0, c1, c2 = c0 + w * q[k], c1 + w * q[k + 1], c2 + w * q[k + 2]
    out[:] = 0.0
    for i in range(len(vectors)):
        k, w = 3 * vectors[i], weights[i]
        x0, x1, x2 = q[k] - w * c0, q[k + 1] - w * c1, q[k + 2] - w * c2
        f0, f1, f2 = f[3 * i], f[3 * i + 1], f[3 * i + 2]
        out[0] += w * f0
        out[1] += w * f1
        out[2] += w * f2
        out[3] += x1 * f2 - x2 * f1
        out[4] += x2 * f0 - x0 * f2
        out[5] += x0 * f1 - x1 * f0


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
        Signal("energy.kinetic", "J", (), kept("kinetic", kinetic), "kinetic energy", polynomial=True),
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
