"""Verification: cases with a known answer, run by ``lamella verify`` (see docs/verification.md).

A case is a folder ``<case>/`` of this package with ``case.py`` (``run() -> Iterable[Check]``), ``reference.toml``
and ``README.md``.
"""

from lamella.verification.check import Check, References
from lamella.verification.runner import Case, Outcome, find_cases, run_cases

__all__ = ["Case", "Check", "Outcome", "References", "find_cases", "run_cases"]
