"""What a verification case hands back: computed values beside their references, each with a tolerance."""

from __future__ import annotations

import math
import tomllib
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, get_args

from lamella.errors import DeclarationError

if TYPE_CHECKING:
    from lamella.roles import Floats

Kind = Literal["relative", "absolute", "at most", "at least"]
KEYS = {"value", "tolerance", "kind", "unit", "source", "reason", "at"}


@dataclass(frozen=True)
class Check:
    """One computed quantity against its reference.

    Args:
        quantity: what is compared, for example ``tip deflection``.
        value: computed value.
        reference: value expected; for ``at most`` and ``at least`` the limit.
        tolerance: largest error accepted.
        kind: ``relative``: error = abs(value - reference) / abs(reference); ``absolute``: abs(value - reference);
            ``at most``: the part of the value above the limit; ``at least``: the part missing to the limit.
        source: where the reference is from (author, year, table or equation).
        unit: unit of value and reference, for example ``m``; empty for a pure number.
        reason: why this tolerance, no wider and no narrower.
    """

    quantity: str
    value: float
    reference: float
    tolerance: float
    kind: Kind = "relative"
    source: str = ""
    unit: str = ""
    reason: str = ""

    def __post_init__(self) -> None:
        for name in ("value", "reference", "tolerance"):
            object.__setattr__(self, name, float(getattr(self, name)))  # NumPy's numbers and verdicts are not JSON
        if self.kind not in get_args(Kind):
            raise DeclarationError(
                f"Check '{self.quantity}'", f"kind = {self.kind!r}", f"accepted is {', '.join(get_args(Kind))}"
            )
        if not (math.isfinite(self.tolerance) and self.tolerance >= 0):
            raise DeclarationError(
                f"Check '{self.quantity}'", f"tolerance = {self.tolerance}", "accepted is a finite number of at least 0"
            )
        if self.kind == "relative" and self.reference == 0:
            raise DeclarationError(
                f"Check '{self.quantity}'", "a relative error needs a reference that is not zero", "accepted is kind='absolute'"
            )

    @property
    def error(self) -> float:
        """The error in the sense of ``kind``; never negative, infinite when the value is not a finite number."""
        difference = self.value - self.reference
        if not math.isfinite(difference):
            return math.inf
        if self.kind == "relative":
            return abs(difference) / abs(self.reference)
        if self.kind == "absolute":
            return abs(difference)
        return max(0.0, difference if self.kind == "at most" else -difference)

    @property
    def passed(self) -> bool:
        return self.error <= self.tolerance


@dataclass(frozen=True)
class References:
    """The references of a case, read from the ``reference.toml`` beside its ``case.py``.

    Each quantity is a table ``[quantities."name"]`` with ``value``, ``tolerance`` and ``reason`` (why this tolerance), and
    optionally ``kind``, ``unit``, ``source`` (default: the file's ``source``) and ``at``, the abscissae of a list of values.
    """

    path: Path
    title: str
    source: str
    quantities: dict[str, dict[str, Any]] = field(repr=False)

    @classmethod
    def beside(cls, case_file: str) -> References:
        """Read ``reference.toml`` in the folder of ``case_file``; called as ``References.beside(__file__)``."""
        path = Path(case_file).with_name("reference.toml")
        content = tomllib.loads(path.read_text(encoding="utf-8"))
        quantities = content.get("quantities", {})
        for name, entry in quantities.items():
            missing, unknown = {"value", "tolerance", "reason"} - set(entry), set(entry) - KEYS
            if missing or unknown:
                problem = f"missing {sorted(missing)}" if missing else f"unknown {sorted(unknown)}"
                raise DeclarationError(
                    f"{path.parent.name}/reference.toml, '{name}'", problem, f"accepted are {', '.join(sorted(KEYS))}"
                )
        return cls(path, content.get("title", path.parent.name), content.get("source", ""), quantities)

    def value(self, quantity: str) -> Any:
        """The reference value of ``quantity``: a number, or a list where the file gives a list."""
        return self._entry(quantity)["value"]

    def at(self, quantity: str) -> list[float]:
        """The abscissae (load factors, times, ...) of a list of reference values."""
        return list(self._entry(quantity)["at"])

    def points(self, quantity: str) -> tuple[list[float], list[float]]:
        """Abscissae and values of a list of references, as a picture takes them; abscissae count from 1 where none are given."""
        entry = self._entry(quantity)
        return list(entry.get("at", range(1, len(entry["value"]) + 1))), list(entry["value"])

    def check(self, quantity: str, value: float) -> Check:
        """The computed ``value`` against the reference of ``quantity``."""
        return self._check(quantity, self._entry(quantity)["value"], value, quantity)

    def checks(self, quantity: str, values: Sequence[float] | Floats) -> Iterator[Check]:
        """Computed values against a list of references; each check is named ``quantity at abscissa``."""
        for place, reference, value in zip(*self.points(quantity), values, strict=True):
            yield self._check(quantity, reference, value, f"{quantity} at {place:g}")

    def _check(self, quantity: str, reference: float, value: float, label: str) -> Check:
        entry = self._entry(quantity)
        return Check(
            label,
            float(value),
            float(reference),
            float(entry["tolerance"]),
            entry.get("kind", "relative"),
            entry.get("source", self.source),
            entry.get("unit", ""),
            entry["reason"],
        )

    def _entry(self, quantity: str) -> dict[str, Any]:
        if quantity not in self.quantities:
            raise DeclarationError(
                f"{self.path.parent.name}/reference.toml", f"no quantity '{quantity}'", f"there are {', '.join(self.quantities)}"
            )
        return self.quantities[quantity]
