"""Verification: cases with a known answer, run by ``lamella verify`` (see docs/verification.md).

A case is a folder ``<case>/`` of this package with ``case.py`` (``run() -> Iterable[Evidence]``), ``reference.toml``
and ``README.md``.
"""

from lamella.verification.check import Check, References
from lamella.verification.picture import Curves, Orders, Picture, Shape
from lamella.verification.runner import Case, Outcome, find_cases, run_cases

Evidence = Check | Picture
"""What a case yields: checks, and pictures that say more than they do."""

__all__ = ["Case", "Check", "Curves", "Evidence", "Orders", "Outcome", "References", "Shape", "find_cases", "run_cases"]
