"""Findings: statements of a paper and whether a computation agrees with them, with numbers."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass, field
from pathlib import Path

from lamella.whole import write_text


@dataclass(frozen=True)
class Finding:
    """One statement and what was found.

    Args:
        finding: the statement in a sentence, with its source.
        agrees: whether the computation agrees.
        numbers: the numbers that decide, by a name that carries the unit, such as ``mean deflection of C [m]``.
        comment: a sentence on why, where it needs one.
    """

    finding: str
    agrees: bool
    numbers: Mapping[str, float | str] = field(default_factory=dict)
    comment: str = ""

    def __post_init__(self) -> None:
        object.__setattr__(self, "agrees", bool(self.agrees))  # NumPy's verdicts are not JSON


def write_findings(findings: Iterable[Finding], path: Path) -> Path:
    """Write findings as a JSON list.

    Raises:
        ResultFileError: the file cannot be written.
    """
    write_text(path, json.dumps([asdict(finding) for finding in findings], indent=2, ensure_ascii=False) + "\n")
    return path


def read_findings(path: Path) -> list[Finding]:
    """Read the findings of a run; none when it wrote none."""
    if not path.is_file():
        return []
    return [Finding(**entry) for entry in json.loads(path.read_text(encoding="utf-8"))]
