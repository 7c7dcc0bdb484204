"""Contraction of the Hessians at the Gauss points to element tangents, one direction after the other (sum factorisation).

For a pair of components (c, d) the entries are

    K[(a, b), (a', b')] = sum_ij sum_uv phi_a^(p)(xi_i) phi_b^(q)(eta_j) H_uv(i, j) phi_a'^(p')(xi_i) phi_b'^(q')(eta_j)

where u = (p, q) and v = (p', q') run over the five derivatives (1,0), (0,1), (2,0), (0,2), (1,1). The sum over j and the
derivatives by eta comes first, for all nine (p, p'), the sum over i second; sums are held in registers.
"""

from __future__ import annotations

from typing import Any

from lamella._jit import inlined, inner
from lamella.lane import WIDTH, load, spread, store
from lamella.roles import Floats

FEW_REGISTERS = WIDTH < 8
"""Sixteen registers of 256 bits, instead of 32 of 512, hold half as many sums at once."""


@inlined
def _z_row(hessian: Floats, at: int, v: int, f0: float, f1: float, f2: float, work: Floats, z: int) -> None:
    """Contract column v of a Hessian with phi_b(eta): rows of equal derivative by xi are merged."""
    store(work, z + v, f1 * load(hessian, at + 5 + v) + f2 * load(hessian, at + 15 + v))
    store(work, z + 5 + v, f0 * load(hessian, at + v) + f1 * load(hessian, at + 20 + v))
    store(work, z + 10 + v, f0 * load(hessian, at + 10 + v))


@inlined
def _t_row(t: Any, z: Any, f0: float, f1: float, f2: float) -> Any:
    return (t[0] + f1 * z[1] + f2 * z[3], t[1] + f0 * z[0] + f1 * z[4], t[2] + f0 * z[2])


@inlined
def _load5(work: Floats, at: int) -> Any:
    return (load(work, at), load(work, at + 1), load(work, at + 2), load(work, at + 3), load(work, at + 4))


@inlined
def _store3(work: Floats, at: int, t: Any) -> None:
    store(work, at, t[0])
    store(work, at + 1, t[1])
    store(work, at + 2, t[2])


@inlined
def _store9(work: Floats, at: int, t: Any) -> None:
    _store3(work, at, t[0])
    _store3(work, at + 3, t[1])
    _store3(work, at + 6, t[2])


@inlined
def _none9() -> Any:
    zero = spread(0.0)
    return (zero, zero, zero), (zero, zero, zero), (zero, zero, zero)


@inlined
def _load15(work: Floats, at: int) -> Any:
    return _load5(work, at), _load5(work, at + 5), _load5(work, at + 10)


@inlined
def _t_rows(t: Any, z: Any, table: Floats, k: int) -> Any:
    """Add what a point of a line gives, with phi_b and its derivatives from table[k] on."""
    f0, f1, f2 = table[k], table[k + 4], table[k + 8]
    return _t_row(t[0], z[0], f0, f1, f2), _t_row(t[1], z[1], f0, f1, f2), _t_row(t[2], z[2], f0, f1, f2)


@inlined
def line_sum(work: Floats, z: int, table: Floats, n: int, b: int) -> Any:
    """The sum over the points of a line, with phi_b."""
    t = _none9()
    for j in range(n):
        t = _t_rows(t, _load15(work, z + j * 15), table, 12 * j + b)
    return t


@inlined
def line_sums(work: Floats, z: int, table: Floats, n: int, b: int) -> Any:
    """The same with phi_b and phi_(b+1), for one reading of the points."""
    t, u = _none9(), _none9()
    for j in range(n):
        point = _load15(work, z + j * 15)
        t, u = _t_rows(t, point, table, 12 * j + b), _t_rows(u, point, table, 12 * j + b + 1)
    return t, u


@inner
def contract_eta(work: Floats, hessian: int, z: int, target: int, table: Floats, n: int, i: int, symmetric: bool) -> None:
    """Contract the Hessians on a line xi = const with phi_b(eta) phi_b'(eta).

    work[target:] gets (b, b', i, derivative of the row, derivative of the column); b' >= b suffices when symmetric.
    """
    for b in range(4):
        for j in range(n):
            f0, f1, f2 = table[12 * j + b], table[12 * j + 4 + b], table[12 * j + 8 + b]
            for v in range(5):
                _z_row(work, hessian + j * 25, v, f0, f1, f2, work, z + j * 15)
        if FEW_REGISTERS:
            for b2 in range(b if symmetric else 0, 4):
                t = line_sum(work, z, table, n, b2)
                _store9(work, target + ((4 * b + b2) * n + i) * 9, t)
        else:
            for pair in range(b // 2 if symmetric else 0, 2):
                t, u = line_sums(work, z, table, n, 2 * pair)
                at = target + ((4 * b + 2 * pair) * n + i) * 9
                _store9(work, at, t)
                _store9(work, at + n * 9, u)


@inlined
def _k_row(k: Any, t: Any, table: Floats, i: int, a: int) -> Any:
    """Add the contribution of points xi_i to the entries (a, a' = 0 1 2 3)."""
    f, s, c = table[i + a], table[i + 4 + a], table[i + 8 + a]
    y0 = f * t[0] + s * t[3] + c * t[6]
    y1 = f * t[1] + s * t[4] + c * t[7]
    y2 = f * t[2] + s * t[5] + c * t[8]
    return (
        k[0] + table[i] * y0 + table[i + 4] * y1 + table[i + 8] * y2,
        k[1] + table[i + 1] * y0 + table[i + 5] * y1 + table[i + 9] * y2,
        k[2] + table[i + 2] * y0 + table[i + 6] * y1 + table[i + 10] * y2,
        k[3] + table[i + 3] * y0 + table[i + 7] * y1 + table[i + 11] * y2,
    )


@inlined
def _load9(work: Floats, at: int) -> Any:
    return (
        load(work, at), load(work, at + 1), load(work, at + 2), load(work, at + 3), load(work, at + 4),
        load(work, at + 5), load(work, at + 6), load(work, at + 7), load(work, at + 8),
    )  # fmt: skip


@inlined
def _store_row(k: Floats, at: int, row: Any, first: int) -> int:
    """Store the entries a' >= first of a row; the position after them."""
    for m in range(first, 4):
        store(k, at + m - first, row[m])
    return at + 4 - first


@inlined
def two_rows(work: Floats, line: int, table: Floats, n: int, a: int) -> Any:
    """The rows a and a + 1 of entries."""
    zero = spread(0.0)
    k0, k1 = (zero, zero, zero, zero), (zero, zero, zero, zero)
    for i in range(n):
        t = _load9(work, line + i * 9)
        k0, k1 = _k_row(k0, t, table, 12 * i, a), _k_row(k1, t, table, 12 * i, a + 1)
    return k0, k1


@inlined
def four_rows(work: Floats, line: int, table: Floats, n: int) -> Any:
    """All rows of entries, for one reading of the points."""
    zero = spread(0.0)
    k0, k1 = (zero, zero, zero, zero), (zero, zero, zero, zero)
    k2, k3 = (zero, zero, zero, zero), (zero, zero, zero, zero)
    for i in range(n):
        t = _load9(work, line + i * 9)
        k0, k1 = _k_row(k0, t, table, 12 * i, 0), _k_row(k1, t, table, 12 * i, 1)
        k2, k3 = _k_row(k2, t, table, 12 * i, 2), _k_row(k3, t, table, 12 * i, 3)
    return k0, k1, k2, k3


@inner
def contract_xi(work: Floats, source: int, table: Floats, n: int, k: Floats, at: int, symmetric: bool) -> int:
    """Contract the result of :func:`contract_eta` with phi_a(xi) phi_a'(xi) and store entries (b, b', a, a') from k[at:].

    When symmetric, b' >= b, and a' >= a where b' = b. Returns the position after the last entry.
    """
    for b in range(4):
        for b2 in range(b if symmetric else 0, 4):
            line, upper = source + (4 * b + b2) * n * 9, symmetric and b == b2
            if FEW_REGISTERS:
                k0, k1 = two_rows(work, line, table, n, 0)
                at = _store_row(k, at, k0, 0)
                at = _store_row(k, at, k1, 1 if upper else 0)
                k2, k3 = two_rows(work, line, table, n, 2)
            else:
                k0, k1, k2, k3 = four_rows(work, line, table, n)
                at = _store_row(k, at, k0, 0)
                at = _store_row(k, at, k1, 1 if upper else 0)
            at = _store_row(k, at, k2, 2 if upper else 0)
            at = _store_row(k, at, k3, 3 if upper else 0)
    return at
