"""Find the verification cases, run them, and lay their checks out as rows."""

from __future__ import annotations

import importlib
import time
import traceback
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from lamella.errors import DeclarationError, ModelError, no_such
from lamella.verification.check import Check
from lamella.verification.picture import Picture

FOLDER = Path(__file__).parent


@dataclass(frozen=True)
class Case:
    """A folder with ``case.py``; ``_`` and ``-`` in its name mean the same."""

    folder: Path
    package: str = "lamella.verification"

    @property
    def name(self) -> str:
        return self.folder.name.replace("_", "-")

    @property
    def title(self) -> str:
        """The heading of the case's README."""
        return next((line.lstrip("# ").strip() for line in self.text.splitlines() if line.startswith("#")), self.name)

    @property
    def text(self) -> str:
        """The case's README, in Markdown."""
        readme = self.folder / "README.md"
        return readme.read_text(encoding="utf-8") if readme.is_file() else ""

    def module(self) -> Any:
        """The imported ``case.py``."""
        return importlib.import_module(f"{self.package}.{self.folder.name}.case")

    @property
    def slow(self) -> bool:
        """True when ``case.py`` says ``slow = True``; read from the text, so that a list imports nothing."""
        lines = (self.folder / "case.py").read_text(encoding="utf-8").splitlines()
        return any(line.replace(" ", "").startswith("slow=True") for line in lines)


@dataclass(frozen=True)
class Outcome:
    """The checks of one case, or the failure that stopped it, and the data of its pictures."""

    case: Case
    checks: tuple[Check, ...]
    seconds: float
    failure: str = ""
    pictures: tuple[Picture, ...] = ()

    @property
    def passed(self) -> bool:
        return not self.failure and bool(self.checks) and all(check.passed for check in self.checks)

    def rows(self) -> list[dict[str, Any]]:
        """One plain dictionary for each check, as ``lamella verify --json`` prints them."""
        rows: list[dict[str, Any]] = [
            {
                "case": self.case.name,
                "quantity": check.quantity,
                "value": check.value,
                "reference": check.reference,
                "error": check.error,
                "tolerance": check.tolerance,
                "passed": check.passed,
                "kind": check.kind,
                "unit": check.unit,
                "source": check.source,
                "reason": check.reason,
            }
            for check in self.checks
        ]
        if self.failure or not rows:
            text = self.failure or "the case made no check"
            empty = dict.fromkeys(("value", "reference", "error", "tolerance"))
            blank = dict.fromkeys(("kind", "unit", "source", "reason"), "")
            rows.append({"case": self.case.name, "quantity": text, "passed": False, **empty, **blank})
        return rows


def find_cases(names: Sequence[str] = (), folder: Path = FOLDER, package: str = "lamella.verification") -> list[Case]:
    """The cases called ``names`` in the order given, or all of them in alphabetical order.

    Raises:
        ModelError: a name that is not a case.
    """
    cases = {case.name: case for case in (Case(path.parent, package) for path in sorted(folder.glob("*/case.py")))}
    chosen = [name.replace("_", "-") for name in names]
    for name in chosen:
        if name not in cases:
            raise ModelError(no_such("verification case", name, cases))
    return [cases[name] for name in chosen] if chosen else list(cases.values())


def run_case(case: Case) -> Outcome:
    """Run one case; an exception becomes a failed outcome that keeps the checks made until then."""
    start, checks, pictures = time.perf_counter(), [], []
    failure = ""
    try:
        for item in case.module().run():  # keeps what a generator yields before it fails
            if isinstance(item, Check):
                checks.append(item)
            elif isinstance(item, Picture):
                pictures.append(item)
            else:
                raise DeclarationError(
                    f"case '{case.name}'", f"run() gave {item!r}", "accepted are Check, Curves, Orders and Shape"
                )
    except Exception as error:  # noqa: BLE001  # one broken case must not hide the others
        place = traceback.extract_tb(error.__traceback__)[-1]
        failure = f"stopped by {type(error).__name__}: {error} ({Path(place.filename).name}, line {place.lineno})"
    return Outcome(case, tuple(checks), time.perf_counter() - start, failure, tuple(pictures))


def run_cases(cases: Sequence[Case]) -> Iterator[Outcome]:
    """Run the cases one after another, handing each outcome over as soon as it is there."""
    for case in cases:
        yield run_case(case)
