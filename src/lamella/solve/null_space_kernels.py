"""Compiled kernels of the reduction of a matrix to the motions that constraints allow."""

from __future__ import annotations

from lamella._jit import njit
from lamella.roles import Floats, Indices, Ints


@njit
def couple(k: Floats, source: Indices, slots: Indices, out: Floats) -> None:
    """out[slots] = k[source], all else zero."""
    out[:] = 0.0
    for e in range(len(source)):
        out[slots[e]] = k[source[e]]


@njit
def reduce_panel(k: Floats, source: Indices, slots: Ints, stride: int, N: Floats, kept: Floats, out: Floats) -> None:
    """Keep the values of a panel K_fg (f, m), and write K_fg N (f, n) to out[slots[f] + n stride].

    Args:
        k: values of the matrix.
        source: number of each value of the panel, -1 where there is none.
        slots: place of each row of the product.
        stride: distance of its entries.
        N: motions of the group.
        kept, out: results.
    """
    m, n = N.shape
    for f in range(len(slots)):
        for i in range(m):
            kept[f, i] = k[source[f, i]] if source[f, i] >= 0 else 0.0
        for a in range(n):
            total = 0.0
            for i in range(m):
                total += kept[f, i] * N[i, a]
            out[slots[f] + a * stride] = total


@njit
def reduce_core(values: Floats, mixed: Ints, weights: Floats, out: Floats) -> None:
    """Add N_g^T K_gh N_h: value, place, length of the rows there, weights and motions of row and of column; (n, 7)."""
    for e in range(len(mixed)):
        slot, stride = mixed[e, 1], mixed[e, 2]
        of_row, high, of_column, wide = mixed[e, 3], mixed[e, 4], mixed[e, 5], mixed[e, 6]
        for a in range(high):
            part = values[mixed[e, 0]] * weights[of_row + a]
            for b in range(wide):
                out[slot + a * stride + b] += part * weights[of_column + b]


@njit
def product(indptr: Ints, indices: Indices, k: Floats, x: Floats, out: Floats) -> None:
    """out = K x, in compressed rows."""
    for i in range(len(out)):
        total = 0.0
        for e in range(indptr[i], indptr[i + 1]):
            total += k[e] * x[indices[e]]
        out[i] = total


@njit
def subtract(rows: Ints, cols: Ints, k: Floats, x: Floats, out: Floats) -> None:
    """out -= K x for listed entries."""
    for e in range(len(rows)):
        out[rows[e]] -= k[e] * x[cols[e]]


@njit
def subtract_panels(
    near: Indices, near_at: Ints, coords: Indices, coords_at: Ints, kept: Floats, kept_at: Ints, x: Floats, out: Floats
) -> None:
    """out_f -= K_fg x_g for the panels (f, m) of all groups g, one after the other in ``kept``."""
    for g in range(len(near_at) - 1):
        first, m = coords_at[g], coords_at[g + 1] - coords_at[g]
        at = kept_at[g]
        for f in range(near_at[g], near_at[g + 1]):
            total = 0.0
            for i in range(m):
                total += kept[at + i] * x[coords[first + i]]
            out[near[f]] -= total
            at += m


@njit
def subtract_transposed(
    near: Indices, near_at: Ints, coords: Indices, coords_at: Ints, kept: Floats, kept_at: Ints, x: Floats, out: Floats
) -> None:
    """out_g -= K_fg^T x_f, with panels as in :func:`subtract_panels`."""
    for g in range(len(near_at) - 1):
        first, m = coords_at[g], coords_at[g + 1] - coords_at[g]
        at = kept_at[g]
        for f in range(near_at[g], near_at[g + 1]):
            factor = x[near[f]]
            for i in range(m):
                out[coords[first + i]] -= kept[at + i] * factor
            at += m
