"""The block of contact between a shell and an obstacle."""

from __future__ import annotations

from dataclasses import dataclass
from math import prod
from typing import Any

import numpy as np

from lamella.contact.bristles import advance
from lamella.contact.gap import Obstacle
from lamella.contact.kernels import ANCHOR, FIELDS, TOTALS, Body, force, work_size
from lamella.contact.point import Law
from lamella.contact.sheet import Sheet
from lamella.contact.tangent import force_tangent
from lamella.lane import aligned
from lamella.roles import Floats, ForceBlock, Ints

FIXED = np.concatenate([np.zeros(3), np.eye(3).reshape(-1)])
"""p, d_1, d_2, d_3 of the inertial frame."""


@dataclass(frozen=True)
class ContactTotals:
    """Contact of one pair in one state.

    Args:
        force: of the shell on the obstacle [N], shape (3,).
        torque: of the shell on the obstacle about its centre [N m], shape (3,).
        normal: sum of the normal forces of all points [N].
        friction_power: power turned into heat by friction [W].
        damping_power: power turned into heat by contact damping [W].
        energy: of normal contact and of bristles [J].
        points: number of points that touch.
        depth: largest depth [m].
        evaluated: number of points whose gap was evaluated; those of elements far away are not.
    """

    force: Floats
    torque: Floats
    normal: float
    friction_power: float
    damping_power: float
    energy: float
    points: int
    depth: float
    evaluated: int


@dataclass(frozen=True)
class ContactField:
    """What each point shows in one state, element by element.

    Args:
        gap: distance to the obstacle, negative where it touches [m], shape (n_element, n).
        pressure: normal force per reference area [Pa], shape (n_element, n).
        slip: velocity of the shell's point against the obstacle's, in the tangent plane; 0 where it does not touch [m/s], shape
            (n_element, n, 3).
        traction: friction on the shell per reference area [Pa], shape (n_element, n, 3).
    """

    gap: Floats
    pressure: Floats
    slip: Floats
    traction: Floats


@dataclass(frozen=True)
class _Seen:
    """A state q, v with copies by which it is known that nobody has written to it, and what was found in it."""

    q: Floats
    v: Floats
    q_then: Floats
    v_then: Floats
    force: Floats
    totals: Floats

    def unchanged(self) -> bool:
        return np.array_equal(self.q, self.q_then) and np.array_equal(self.v, self.v_then)


Part = tuple[tuple[int, ...], Ints, Ints, Floats, Floats]
"""Shape of a part of the tangent's buffer, and what is repeated to it: rows, columns, and the factors of both."""


class ContactBlock(ForceBlock):
    """Contact of the points of a shell with one obstacle; see :mod:`lamella.contact.point` for the law.

    Bristles keep where they hold in the axes of the obstacle's body. It changes with accepted steps only (``settle``), where
    those beyond mu times the elastic normal force slide to that limit.

    Args:
        name: the declaration's name.
        sheet: points of the shell.
        obstacle: the obstacle.
        law: the law of contact.
        first: number of the vector p of the obstacle's body, None for the inertial frame.
    """

    remembered = ("_anchors", "_heat")

    def __init__(self, name: str, sheet: Sheet, obstacle: Obstacle, law: Law, first: int | None) -> None:
        self.name, self.sheet, self.obstacle, self.law = name, sheet, obstacle, law
        self.symmetry = "none" if law.mu > 0.0 else "nearly"
        self.depends_on_velocity = law.damping > 0.0 or law.mu > 0.0
        n_pairs = sheet.n_element * sheet.n_point
        self._anchors = np.full(ANCHOR * n_pairs if law.bristle else 0, np.nan)
        self._heat = 0.0
        self._work, self._totals = aligned(work_size(sheet)), np.zeros(TOTALS)
        self._recent: list[_Seen] = []
        self._points, self._places = np.zeros(sheet.n_point, np.int64), np.zeros(sheet.n_point, np.int64)
        self._no_field = np.zeros(0)
        self.first = first
        self._list_entries()
        self._aside = np.zeros(len(self.f_coords))

    def _list_entries(self) -> None:
        """Coordinates and factors of the buffers, in the order of :mod:`lamella.contact.tangent`."""
        sheet = self.sheet
        n, wide, count = sheet.n_vector, sheet.vectors, sheet.n_element
        coords = np.full((count, 3, wide), -1, np.int64)
        coords[:, :, :n] = sheet.coords.reshape(count, n, 3).transpose(0, 2, 1)
        scale = np.zeros((count, 1, wide))
        scale[:, 0, :n] = sheet.scale.reshape(count, n)
        body: Ints = np.zeros(0, np.int64) if self.first is None else 3 * self.first + np.arange(12)
        self.f_coords = np.concatenate([coords.reshape(-1), body])
        self.f_scale = np.concatenate([(scale * np.ones((1, 3, 1))).reshape(-1), np.ones(len(body))])
        shape = (count, 3, 3, n, wide)
        parts: list[Part] = [
            (
                shape,
                coords[:, :, None, :n, None],
                coords[:, None, :, None, :],
                scale[:, :, None, :n, None],
                scale[:, None, :, None],
            )
        ]
        if len(body):
            turned = (count, 3, 12, wide)
            parts.append((turned, coords[:, :, None], body[:, None], scale[:, :, None], np.ones(1)))
            turned = (count, 12, 3, wide)
            parts.append((turned, body[:, None, None], coords[:, None], np.ones(1), scale[:, None]))
            parts.append(((12, 12), body[:, None], body, np.ones(1), np.ones(1)))
        rows, cols, scales = [], [], []
        for shape, row, col, of, by in parts:
            filler = (np.broadcast_to(row, shape) < 0) | (np.broadcast_to(col, shape) < 0)
            rows.append(np.where(filler, -1, row).reshape(-1))
            cols.append(np.where(filler, -1, col).reshape(-1))
            scales.append(np.broadcast_to(of * by, shape).reshape(-1))
        shapes = [part[0] for part in parts]
        sizes = [np.full(count, prod(shape[1:])) if len(shape) > 2 else [prod(shape)] for shape in shapes]
        self.k_parts = np.cumsum(np.concatenate([[0], *sizes]))
        self.k_used = np.zeros(len(self.k_parts) - 1, bool)
        self.k_rows, self.k_cols, self.k_scale = np.concatenate(rows), np.concatenate(cols), np.concatenate(scales)

    def _body(self, q: Floats, v: Floats) -> Body:
        if self.first is None:
            return Body(FIXED, np.zeros(12))
        own = slice(3 * self.first, 3 * self.first + 12)
        return Body(q[own], v[own])

    def place(self, q: Floats) -> tuple[Floats, Floats]:
        """Centre of the obstacle [m] and its axis in a state."""
        vectors = self._body(q, q).x.reshape(4, 3)
        return vectors[0] + self.obstacle.centre @ vectors[1:], self.obstacle.axis @ vectors[1:]

    def _evaluate(self, q: Floats, v: Floats, f: Floats, field: Floats, *, moving: bool, damping: bool = False) -> None:
        force(
            q, v, moving, self._body(q, v), self.sheet, self.obstacle, self.law, self._anchors, damping, self._work,
            self._points, self._places, f, self._totals, field,
        )  # fmt: skip

    def _observed(self, q: Floats, v: Floats) -> tuple[Floats, Floats]:
        """Force and totals in a state. An accepted state, and that at rest in its place, are asked for several times."""
        for seen in self._recent:
            if seen.q is q and seen.v is v and seen.unchanged():
                return seen.force, seen.totals
        f = np.empty(len(self.f_coords))
        self._evaluate(q, v, f, self._no_field, moving=self.depends_on_velocity)
        self._recent = [_Seen(q, v, q.copy(), v.copy(), f, self._totals.copy()), *self._recent[:1]]
        return f, self._recent[0].totals

    def force(self, t: float, q: Floats, v: Floats, f: Floats) -> None:
        f[:] = self._observed(q, v)[0]

    def damping_force(self, t: float, q: Floats, v: Floats, f: Floats) -> None:
        self._evaluate(q, v, f, self._no_field, moving=True, damping=True)

    def force_tangent(
        self, t: float, q: Floats, v: Floats, alpha_q: float, alpha_v: float, q_previous: Floats, f: Floats, k: Floats
    ) -> None:
        force_tangent(
            q, v, self.depends_on_velocity, self._body(q, v), self.sheet, self.obstacle, self.law, self._anchors,
            alpha_q, alpha_v, self._work, self._points, self._places, f, k, self.k_used,
        )  # fmt: skip

    def totals(self, q: Floats, v: Floats) -> ContactTotals:
        """Resultants, energy and powers in a state."""
        T = self._observed(q, v)[1].copy()
        return ContactTotals(T[:3], T[3:6], T[6], T[7], T[8], T[9], int(T[10]), T[11], int(T[12]))

    def field(self, q: Floats, v: Floats) -> ContactField:
        """Gap, pressure, slip and traction of every point in a state."""
        shape = (self.sheet.n_element, self.sheet.n_point, FIELDS)
        values = np.zeros(shape)
        self._evaluate(q, v, self._aside, values.reshape(-1), moving=True)
        return ContactField(values[..., 0], values[..., 1], values[..., 2:5], values[..., 5:8])

    def energy(self, t: float, q: Floats) -> float:
        known = next((seen.v for seen in self._recent if seen.q is q), None)
        return float(self._observed(q, np.zeros_like(q) if known is None else known)[1][9])

    def dissipation(self, t: float, q: Floats, v: Floats) -> float:
        T = self._observed(q, v)[1]
        return float(T[7] + T[8])

    def settle(self, t: float, q: Floats) -> None:
        if self.law.bristle:
            self._recent = []
            self._heat += advance(q, self._body(q, q), self.sheet, self.obstacle, self.law, self._anchors, self._work)

    def reset(self) -> None:
        self._anchors[:], self._recent = np.nan, []
        self._heat = 0.0

    def recall(self, memory: dict[str, Any]) -> None:
        super().recall(memory)
        self._recent = []

    def settled_heat(self) -> float:
        return self._heat
