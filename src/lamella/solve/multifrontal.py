"""Multifrontal factorisation K = L S L^T of symmetric matrices on the node blocks of a mesh."""

from __future__ import annotations

from functools import cached_property, partial

import numpy as np

from lamella import threads
from lamella.assembly.pattern import Pattern
from lamella.lane import WIDTH, aligned
from lamella.roles import Floats, Ints, Reals
from lamella.solve import front_columns, front_kernels, front_solution, panels
from lamella.solve.base import SymmetricFactor
from lamella.solve.layout import layout_of
from lamella.solve.panels import Panels
from lamella.solve.readable import Readable, Scaled
from lamella.solve.schedule import row_ranges, schedule_of
from lamella.threads import Workspace

SMALL_PIVOT = 1e-12
"""A pivot below this share of its diagonal entry may be rounding, which leaves up to some 1e-13 where a body turns freely; long
thin strips have 1e-9 and more. Where a matrix is regular all the same, a general solver finds that by its condition."""
LEAST_PIVOT = 1e-3
"""Pivots, as shares of their diagonal entries, from which a factor may be rounded to integers: that changes them by some 3e-5.
What the factor then leaves of a solution is up to 0.02 of it; in statics of thin plates, with pivots of 1e-4, it would be 0.4."""
SEVERAL = 3
"""Right-hand sides from which a substitution with all at once is faster than one with each."""


class Multifrontal(SymmetricFactor):
    """L S L^T with S = diag(+-1) and pivots on the diagonal in a fixed order, in dense fronts.

    For a positive definite matrix this is Cholesky's factorisation. An indefinite one is factorised without exchange of rows:
    its accuracy must be checked, and the signs then give the number of negative eigenvalues.

    Args:
        pattern: a symmetric pattern; its multipliers are ignored.
    """

    def __init__(self, pattern: Pattern) -> None:
        self.pattern = pattern
        self._layout = layout = layout_of(pattern)
        self._plan = plan = schedule_of(layout)
        self.cost, self.size = layout.cost, layout.size
        self.shortens = self.size >= panels.SHORTENED
        self._panels, self._u = Panels(layout.size), aligned(plan.update_size)
        self._scaled: Scaled | None = None
        self._singles = False
        n = len(layout.coordinate)
        self._signs, self._magnitude = np.ones(n), np.zeros(n)
        self._z, self._rest = np.zeros(len(layout.coordinate)), np.zeros(len(layout.rows))
        self._b = Workspace(front_kernels.BLOCK * layout.longest + WIDTH)
        self._y, self._order = Workspace(layout.longest + WIDTH), np.arange(len(layout.fronts) - 1)
        self._orders = [self._order[slice(*subtree)] for subtree in plan.subtrees]

    def factorise(self, k: Floats) -> int:
        """Factorise; -1, or the coordinate whose pivot is rounding error."""
        at, plan, a = self._layout, self._plan, self._panels.written
        self._panels.renew()
        self._scaled = None
        self._magnitude = at.magnitude(k)
        limits = SMALL_PIVOT * self._magnitude

        def subtree(first: int, end: int) -> int:
            return front_kernels.factorise(
                k, *at.entries, first, end, plan.fronts, at.runs, limits, a, self._u, self._signs, self._b.array
            )

        found = threads.run([partial(subtree, *fronts) for fronts in plan.subtrees])
        failed = min((position for position in found if position >= 0), default=-1)
        for f in plan.above:
            if failed < 0:
                failed = self._factorise_above(k, int(f), limits)
        self.negative_pivots = int(np.count_nonzero(self._signs < 0))
        return int(at.coordinate[failed]) if failed >= 0 else -1

    def _factorise_above(self, k: Floats, f: int, limits: Floats) -> int:
        """Factorise a front above the subtrees, the rows of whose update go to the threads; -1, or the position that failed."""
        plan, a, u, b = self._plan, self._panels.written, self._u, self._b.array
        front_kernels.assemble(k, *self._layout.entries, f, plan.fronts, self._layout.runs, a, u)
        position, p, a_len, a0, _, u_len, u0 = plan.fronts[f, :7].tolist()
        for first in range(0, p, front_kernels.BLOCK):
            failed = front_kernels.factorise_block(a, a0, a_len, p, first, limits, self._signs, position, b)
            if failed >= 0:
                return position + failed
            last = min(first + front_kernels.BLOCK, p)
            left, n = a0 + first * a_len, last - first
            panel = a, a0 + last * (a_len + 1), a_len
            update = u, u0, u_len
            of_update, of_panel = row_ranges(u_len, u_len, n), row_ranges(a_len - last, p - last, n)
            calls = [
                partial(front_kernels.subtract_rows, *update, *rows, u_len, a, left + p, a_len, b, (p - last) * n, n)
                for rows in of_update
            ]
            calls += [
                partial(front_kernels.subtract_rows, *panel, *rows, p - last, a, left + last, a_len, b, 0, n) for rows in of_panel
            ]
            threads.run(calls, worthwhile=max(len(of_update), len(of_panel)) > 1)
        return -1

    def shorten(self, singles: bool = True) -> None:
        """Read the factor in single precision, or as integers, from now on, where that is faster."""
        self._singles = singles
        if self._panels.fresh and self.shortens:
            self._scaled = self._in_integers()
        self._panels.shorten()

    def _in_integers(self) -> Scaled | None:
        """The factor as integers; None where a pivot is so small beside its diagonal entry that rounding would count."""
        at, by_position = self._layout, np.ones(len(self._signs))
        diagonal = self._magnitude[at.position]
        if not np.all(diagonal > 0.0):
            return None
        by_position[at.position] = 1.0 / np.sqrt(diagonal)
        inverse_roots = self._panels.written[at.pivots]
        if not np.all((by_position / inverse_roots) ** 2 >= LEAST_PIVOT):
            return None
        return self._panels.scale(at.fronts, at.rows, at.longest, by_position, by_position[at.position])

    @property
    def _factor(self) -> Readable:
        return self._scaled or self._panels.read

    def _reals(self, space: Floats) -> Reals:
        """Work space of a substitution: of single numbers where these serve."""
        return space.view(np.float32)[: len(space)] if self._singles and self._scaled is not None else space

    def solve(self, r: Floats) -> Floats:
        """K^-1 r by forward and back substitution."""
        if r.ndim == 1:
            return self._solve(r)
        rows = np.ascontiguousarray(r.T)
        x = np.empty_like(rows)
        for first in range(0, len(rows), WIDTH):
            some = rows[first : first + WIDTH]
            if len(some) >= SEVERAL and self._scaled is None:  # each integer would be made a number by itself
                self._solve_columns(some, x[first : first + WIDTH])
            else:
                for i, row in enumerate(some, first):
                    x[i] = self._solve(row)
        return x.T

    @cached_property
    def _columns(self) -> tuple[Floats, Floats, Workspace]:
        """Work space for several right-hand sides: by position, by remaining row, and of a front."""
        at = self._layout
        return aligned(len(self._z) * WIDTH), aligned(len(at.rows) * WIDTH), Workspace((at.longest + WIDTH) * WIDTH)

    def _solve_columns(self, r: Floats, out: Floats) -> None:
        at, plan, (x, rest, y), factor = self._layout, self._plan, self._columns, self._factor

        def forward(order: Ints) -> None:
            front_columns.forward(order, plan.fronts, at.runs, factor, self._signs, x, rest, y.array)

        def backward(order: Ints) -> None:
            front_columns.backward(order, plan.fronts, at.rows, factor, x, y.array)

        front_columns.spread_columns(r, factor, at.position, x)
        subtrees = self._orders if plan.solves else [self._order]
        above = plan.above if plan.solves else self._order[:0]
        threads.run([partial(forward, order) for order in subtrees])
        forward(above)
        backward(above)
        threads.run([partial(backward, order) for order in subtrees])
        front_columns.gather_columns(x, factor, at.position, out)

    def _solve(self, r: Floats) -> Floats:
        at, plan, x, factor = self._layout, self._plan, np.empty_like(r), self._factor
        z, rest = self._reals(self._z), self._reals(self._rest)
        if not plan.solves:
            work = z, rest, self._reals(self._y.array)
            fronts = plan.fronts, at.rows, at.runs, factor, self._signs
            front_solution.solve_coordinates(self._order, *fronts, at.position, r, *work, x)
            return x

        def forward(order: Ints) -> None:
            front_solution.forward(order, plan.fronts, at.runs, factor, self._signs, z, rest, self._reals(self._y.array))

        def backward(order: Ints) -> None:
            front_solution.backward(order, plan.fronts, at.rows, factor, z, self._reals(self._y.array))

        front_solution.spread_positions(r, factor, at.position, z)
        threads.run([partial(forward, order) for order in self._orders])
        forward(plan.above)
        backward(plan.above)
        threads.run([partial(backward, order) for order in self._orders])
        front_solution.gather_coordinates(z, factor, at.position, x)
        return x
