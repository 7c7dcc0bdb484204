"""One line of the table of benchmarks."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from typing import Self

NAN = float("nan")


@dataclass(frozen=True, kw_only=True)
class Row:
    """What one code took for one piece of work; NaN and empty texts where a column does not apply.

    Attributes:
        case: the case's name.
        code: who did the work, with the settings that matter.
        what: the piece of work, for example the mesh.
        time: median of the CPU time, or of the elapsed one where ``unit`` says so.
        unit: of the time.
        ratio: time over that of lamella for the same work.
        steps, iterations, factorisations: counts, a step where the unit is a time a step; they do not depend on the machine.
        value: a result in ``quantity``, which shows that the work is one.
        quantity: name and unit of the value.
        error: relative error of the value.
        note: what the numbers do not say, for example how to install a peer.
    """

    case: str
    code: str
    what: str = ""
    time: float = NAN
    unit: str = ""
    ratio: float = NAN
    steps: float = NAN
    iterations: float = NAN
    factorisations: float = NAN
    value: float = NAN
    quantity: str = ""
    error: float = NAN
    note: str = ""

    def beside(self, own: Row) -> Self:
        """This row with the ratio of its time to that of ``own``."""
        return replace(self, ratio=self.time / own.time)

    def noting(self, text: str) -> Self:
        """This row with more in its note."""
        return replace(self, note=f"{self.note}, {text}" if self.note else text)


def beside_first(rows: Iterable[Row]) -> list[Row]:
    """Rows of the same work with their ratios to the first."""
    found = list(rows)
    return [row.beside(found[0]) for row in found]
