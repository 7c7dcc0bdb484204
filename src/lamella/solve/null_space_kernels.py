"""Compiled kernels of the reduction of a matrix to the motions that constraints allow."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from lamella._jit import inlined, inner, kernel
from lamella.lane import WIDTH, load_at, number_at, store_at, total
from lamella.lane import spread as spread_out
from lamella.roles import Floats, Indices, Ints
from lamella.solve import front_solution
from lamella.solve.lu_kernels import value

TINY = float(np.finfo(float).tiny)


class Rows(NamedTuple):
    """A matrix in compressed rows: number of each row, where each begins, and the column of each entry with the source of its
    value, see :func:`lamella.solve.lu_kernels.value`.
    """

    rows: Ints
    starts: Ints
    columns: Indices
    sources: Indices


class Motions(NamedTuple):
    """What becomes of coordinates; lists of all groups one after the other, with the places where those of each group begin.

    Args:
        coords, coords_at: coordinates of each group.
        rows, rows_at: its constraints.
        N, N_at: its motions (coordinate, motion), flat.
        P, P_at: the other coordinates (coordinate, constraint), flat.
        place, place_at: position of its motions in the factorised matrix.
        free, free_place: coordinates in no group, and their positions.
    """

    coords: Indices
    coords_at: Ints
    rows: Indices
    rows_at: Ints
    N: Floats
    N_at: Ints
    P: Floats
    P_at: Ints
    place: Indices
    place_at: Ints
    free: Indices
    free_place: Indices


class Panels(NamedTuple):
    """All K_fg, or the transposed K_gf, between groups g and coordinates f in no group.

    Args:
        near, near_at: the coordinates f of each group, and where they begin.
        kept, kept_at: values (g, f), flat, of each group, and where they begin; the f are filled up to whole lanes.
        room: for a number of each f of a group.
    """

    near: Indices
    near_at: Ints
    kept: Floats
    kept_at: Ints
    room: Floats


def filled_up(count: int) -> int:
    """The count of numbers in whole lanes."""
    return -(-count // WIDTH) * WIDTH


class Core(NamedTuple):
    """Entries of K between constrained coordinates."""

    rows: Ints
    cols: Ints
    values: Floats


@kernel
def reduce_panel(
    k: Floats, source: Indices, slots: Ints, stride: int, N: Floats, kept: Floats, room: Floats, out: Floats
) -> None:
    """Keep the values of a panel K_fg (m, f), and write K_fg N (f, n) to out[slots[f] + n stride].

    Args:
        k: values of the matrix.
        source: number of each value of the panel, flat, -1 where there is none.
        slots: place of each row of the product.
        stride: distance of its entries.
        N: motions of the group.
        kept: the values, flat, with f filled up to whole lanes.
        room: for a number of each f.
        out: the product.
    """
    m, n = N.shape
    wide = len(source) // m
    for e in range(len(source)):
        found = number_at(source, e)
        kept[e] = number_at(k, found) if found >= 0 else 0.0
    for a in range(n):
        for f in range(0, wide, WIDTH):
            sums = spread_out(0.0)
            for i in range(m):
                sums = sums + N[i, a] * load_at(kept, i * wide + f)
            store_at(room, f, sums)
        for f in range(len(slots)):
            out[number_at(slots, f) + a * stride] = number_at(room, f)


@kernel
def reduce_core(values: Floats, mixed: Ints, weights: Floats, out: Floats) -> None:
    """Add N_g^T K_gh N_h: value, place, length of the rows there, weights and motions of row and of column; (n, 7)."""
    for e in range(len(mixed)):
        slot, stride = mixed[e, 1], mixed[e, 2]
        of_row, high, of_column, wide = mixed[e, 3], mixed[e, 4], mixed[e, 5], mixed[e, 6]
        for a in range(high):
            part = values[mixed[e, 0]] * weights[of_row + a]
            for b in range(wide):
                out[slot + a * stride + b] += part * weights[of_column + b]


@kernel
def product(indptr: Ints, indices: Indices, k: Floats, x: Floats, out: Floats) -> None:
    """out = K x, in compressed rows."""
    for i in range(len(out)):
        total = 0.0
        for e in range(indptr[i], indptr[i + 1]):
            total += k[e] * x[indices[e]]
        out[i] = total


@kernel
def scaled(magnitude: Floats, probe: Floats, b: Floats, z: Floats) -> None:
    """A right-hand side b, and z, from the probe and the diagonal's magnitude."""
    for i in range(len(b)):
        b[i] = probe[i] * np.sqrt(max(magnitude[i], TINY))
        z[i] = b[i]


@inlined
def _term(A: Rows, k: Floats, more: Floats, x: Floats, e: int) -> float:
    return value(k, more, number_at(A.sources, e)) * number_at(x, number_at(A.columns, e))


@kernel
def residual(A: Rows, k: Floats, more: Floats, b: Floats, x: Floats, rest: Floats) -> None:
    """rest = b - A x, in compressed rows; zero in the rows that A has not."""
    rest[:] = 0.0
    for i in range(len(A.rows)):
        one, two, three, four = 0.0, 0.0, 0.0, 0.0  # several sums, as additions would wait for each other
        first, end = A.starts[i], A.starts[i + 1]
        for e in range(first, end - 3, 4):
            one += _term(A, k, more, x, e)
            two += _term(A, k, more, x, e + 1)
            three += _term(A, k, more, x, e + 2)
            four += _term(A, k, more, x, e + 3)
        for e in range(end - (end - first) % 4, end):
            one += _term(A, k, more, x, e)
        rest[A.rows[i]] = b[A.rows[i]] - (one + two + three + four)


@kernel
def largest(magnitude: Floats, rest: Floats, x: Floats) -> tuple[float, int, float, int]:
    """Largest entries of the residual and of the solution of a matrix scaled to a diagonal of 1, each with its place.

    A solution that holds what is not a number is infinite.
    """
    error, worst, size, softest = 0.0, 0, 0.0, 0
    for i in range(len(x)):
        scale = np.sqrt(max(magnitude[i], TINY))
        found = abs(x[i]) * scale
        if not found <= size:
            size, softest = found, i
            if not np.isfinite(found):
                return np.inf, i, np.inf, i
        if abs(rest[i]) > error * scale:
            error, worst = abs(rest[i]) / scale, i
    return error, worst, size, softest


@kernel
def gather(r: Floats, s: Floats, at: Motions, right: Panels, core: Core, x: Floats, rest: Floats, z: Floats) -> None:
    """z = N^T (r - K P s) by position, and x = P s."""
    z[:] = 0.0
    x[:] = 0.0
    for i in range(len(r)):
        rest[i] = r[i]
    violated = False
    for a in range(len(s)):
        violated = violated or s[a] != 0.0
    if violated:
        for g in range(len(at.coords_at) - 1):
            first, m = at.coords_at[g], at.coords_at[g + 1] - at.coords_at[g]
            row, n = at.rows_at[g], at.rows_at[g + 1] - at.rows_at[g]
            for i in range(m):
                for a in range(n):
                    x[at.coords[first + i]] += at.P[at.P_at[g] + i * n + a] * s[at.rows[row + a]]
        _subtract_panels(right, at, x, rest)
        _subtract_core(core, x, rest)
    for i in range(len(at.free)):
        z[at.free_place[i]] = rest[at.free[i]]
    for g in range(len(at.coords_at) - 1):
        first, m = at.coords_at[g], at.coords_at[g + 1] - at.coords_at[g]
        motion, n = at.place_at[g], at.place_at[g + 1] - at.place_at[g]
        for i in range(m):
            for a in range(n):
                z[at.place[motion + a]] += at.N[at.N_at[g] + i * n + a] * rest[at.coords[first + i]]


@kernel
def spread(r: Floats, z: Floats, at: Motions, down: Panels, core: Core, rest: Floats, x: Floats, y: Floats) -> None:
    """x += N z, z by position, and y = P^T (r - K x)."""
    for i in range(len(at.free)):
        x[at.free[i]] += z[at.free_place[i]]
    for g in range(len(at.coords_at) - 1):
        first, m = at.coords_at[g], at.coords_at[g + 1] - at.coords_at[g]
        motion, n = at.place_at[g], at.place_at[g + 1] - at.place_at[g]
        for i in range(m):
            for a in range(n):
                x[at.coords[first + i]] += at.N[at.N_at[g] + i * n + a] * z[at.place[motion + a]]
    for i in range(len(r)):
        rest[i] = r[i]
    _subtract_transposed(down, at, x, rest)
    _subtract_core(core, x, rest)
    for g in range(len(at.coords_at) - 1):
        first, m = at.coords_at[g], at.coords_at[g + 1] - at.coords_at[g]
        row, n = at.rows_at[g], at.rows_at[g + 1] - at.rows_at[g]
        for i in range(m):
            for a in range(n):
                y[at.rows[row + a]] += at.P[at.P_at[g] + i * n + a] * rest[at.coords[first + i]]


@kernel
def solve(r: Floats, s: Floats, x: Floats, y: Floats, z: Floats, rest: Floats, *arrays: Any) -> None:
    """x and y by one reduced solution: :func:`gather`, :func:`lamella.solve.front_solution.solve` and :func:`spread` in one call.

    Arrays cost a call from Python 0.05 us each, and those in a NamedTuple three times as much, which here is as long as the
    solution takes.

    Args:
        r, s, x, y, z, rest: as there.
        arrays: those of the motions, of the panels on the right and below, of the core, and of the factorisation.
    """
    at, right, down, core = Motions(*arrays[:12]), Panels(*arrays[12:17]), Panels(*arrays[17:22]), Core(*arrays[22:25])
    gather(r, s, at, right, core, x, rest, z)
    order, fronts, rows, runs, a, c, signs, of_fronts, column = arrays[25:]
    front_solution.solve(order, fronts, rows, runs, a, c, signs, z, of_fronts, column)
    spread(r, z, at, down, core, rest, x, y)


@inner
def _subtract_core(core: Core, x: Floats, out: Floats) -> None:
    """out -= K x for entries between constrained coordinates."""
    for e in range(len(core.rows)):
        out[core.rows[e]] -= core.values[e] * x[core.cols[e]]


@inner
def _subtract_panels(panels: Panels, motions: Motions, x: Floats, out: Floats) -> None:
    """out_f -= K_fg x_g for all groups g."""
    room = panels.room
    for g in range(len(panels.near_at) - 1):
        first, m = motions.coords_at[g], motions.coords_at[g + 1] - motions.coords_at[g]
        near, count, at = panels.near_at[g], panels.near_at[g + 1] - panels.near_at[g], panels.kept_at[g]
        wide = (panels.kept_at[g + 1] - at) // m
        for f in range(0, wide, WIDTH):
            sums = spread_out(0.0)
            for i in range(m):
                sums = sums + number_at(x, number_at(motions.coords, first + i)) * load_at(panels.kept, at + i * wide + f)
            store_at(room, f, sums)
        for f in range(count):
            out[number_at(panels.near, near + f)] -= number_at(room, f)


@inner
def _subtract_transposed(panels: Panels, motions: Motions, x: Floats, out: Floats) -> None:
    """out_g -= K_fg^T x_f for all groups g."""
    room = panels.room
    for g in range(len(panels.near_at) - 1):
        first, m = motions.coords_at[g], motions.coords_at[g + 1] - motions.coords_at[g]
        near, count, at = panels.near_at[g], panels.near_at[g + 1] - panels.near_at[g], panels.kept_at[g]
        wide = (panels.kept_at[g + 1] - at) // m
        for f in range(count):
            room[f] = number_at(x, number_at(panels.near, near + f))
        room[count:wide] = 0.0
        for i in range(m):
            sums = spread_out(0.0)
            for f in range(0, wide, WIDTH):
                sums = sums + load_at(panels.kept, at + i * wide + f) * load_at(room, f)
            out[motions.coords[first + i]] -= total(sums)
