"""Which fronts of a factorisation are worked on side by side: subtrees of the elimination tree, and what is above them."""

from __future__ import annotations

from itertools import pairwise
from weakref import WeakKeyDictionary

import numpy as np

from lamella import threads
from lamella.lane import WIDTH
from lamella.roles import Floats
from lamella.solve.layout import FrontLayout, Space
from lamella.solve.symbolic_kernels import operations

RATE = 1.2e10
"""Multiplications, each with an addition, that one thread does in a second."""
ONE_BY_ONE = 0.3
"""Share of a front above the subtrees that one thread does alone: panels and the updates of children."""
HANDED_OUT = 1e-4
"""Seconds that it takes to hand work out to threads and to wait for them: once, and for each front above the subtrees."""
SAVED = 0.75
"""Share of the time of one thread that may be left, else one does it all: the machine may have other work."""
SOLVED = 5e-10
"""Seconds for an entry of the factor in forward or in back substitution."""
TRIED = 16
"""Subtrees for each thread at which the search for better ones ends."""


class Schedule:
    """The fronts of a layout as subtrees, none of which needs another, and the fronts ``above`` them.

    Args:
        layout: the layout.
        count: number of threads; for 1, or where two would not pay, one subtree is all there is.

    Attributes:
        subtrees: first front and end of each; the longest work comes first.
        above: the other fronts, children before parents.
        fronts: the table of the layout, with updates that do not take the places of those of another subtree.
        update_size: entries of the workspace of updates.
        solves: whether substitutions go by subtrees as well.
    """

    def __init__(self, layout: FrontLayout, count: int) -> None:
        n = len(layout.fronts) - 1
        self.fronts, self.update_size = layout.fronts, layout.update_size
        self.subtrees, self.above = [(0, n)], np.zeros(0, np.int64)
        if count > 1 and layout.cost / RATE > threads.WORTHWHILE:
            self._split(layout, count)
        self.solves = len(self.subtrees) > 1 and SOLVED * layout.size > threads.WORTHWHILE

    def _split(self, layout: FrontLayout, count: int) -> None:
        table = layout.fronts
        n = len(table) - 1
        work = operations(table[:n, 1].astype(float), table[:n, 4].astype(float))
        first, below = np.arange(n), work.copy()
        children: list[list[int]] = [[] for _ in range(n)]
        for f in range(n):
            child = int(table[f, 9])
            while child >= 0:
                children[f].append(child)
                child = int(table[child, 10])
            if children[f]:
                first[f], below[f] = first[children[f]].min(), work[f] + below[children[f]].sum()
        roots = np.setdiff1d(np.arange(n), np.concatenate([np.zeros(0, int), *(np.array(c, int) for c in children)])).tolist()
        best, least = ([(0, n)], [0]), SAVED * float(work.sum())
        above: list[int] = []
        while len(roots) <= TRIED * count:
            alone = work[above].sum()
            time = _longest(below[roots], count) + alone * (ONE_BY_ONE + (1.0 - ONE_BY_ONE) / count)
            time += HANDED_OUT * RATE * (1 + len(above))
            if time < least:
                order = sorted(roots, key=lambda f: -below[f])
                best, least = ([(int(first[f]), f + 1) for f in order], sorted(above)), float(time)
            top = max(roots, key=lambda f: below[f])
            if not children[top]:
                break
            roots.remove(top)
            roots += children[top]
            above.append(top)
        if len(best[0]) > 1:
            self.subtrees, self.above = best[0], np.array(best[1], np.int64)
            self._place_updates()

    def _place_updates(self) -> None:
        """Let each subtree, and what is above, take its updates' places from a part of the workspace of its own."""
        self.fronts = table = self.fronts.copy()
        size = 0
        parts = [range(*subtree) for subtree in self.subtrees]
        for fronts in [*parts, self.above.tolist()]:
            space, members = Space(), set(fronts)
            for f in fronts:
                table[f, 6] = size + space.take(int(table[f, 5]) ** 2)
                child = int(table[f, 9])
                while child >= 0:
                    if child in members:
                        space.give(int(table[child, 6]) - size, int(table[child, 5]) ** 2)
                    child = int(table[child, 10])
            size += space.size
        self.update_size = size


def _longest(work: Floats, count: int) -> float:
    """Work of the busiest thread when each takes the longest piece that is left."""
    loads = np.zeros(count)
    for one in np.sort(work)[::-1]:
        loads[np.argmin(loads)] += one
    return float(loads.max())


_SCHEDULES: WeakKeyDictionary[FrontLayout, dict[int, Schedule]] = WeakKeyDictionary()


def schedule_of(layout: FrontLayout) -> Schedule:
    """The schedule for the threads in use: solvers of the same equations share one."""
    known, count = _SCHEDULES.setdefault(layout, {}), threads.number()
    if count not in known:
        known[count] = Schedule(layout, count)
    return known[count]


def row_ranges(rows: int, columns: int, n: int) -> list[tuple[int, int]]:
    """Ranges of rows of the lower triangle of (rows, columns) from which n columns are subtracted, the longest rows first.

    They begin at multiples of the rows that a kernel takes at once, and take about the same time each.
    """
    if not rows or not columns:
        return []
    height = 3 * WIDTH
    strips = -(-rows // height)
    lengths = np.minimum(columns, (np.arange(strips) + 1) * height)
    done = np.cumsum(lengths)
    pieces = len(threads.cut(strips, float(lengths.mean()) * height * n / RATE))
    ends = np.searchsorted(done, done[-1] * np.arange(1, pieces + 1) / pieces) + 1
    bounds = np.minimum(np.concatenate([[0], ends * height]), rows).tolist()
    return [(first, end) for first, end in pairwise(bounds) if first < end][::-1]
