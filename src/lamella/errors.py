"""Every exception lamella raises, each with one message that names the item, the value and what would be accepted."""

from __future__ import annotations

import difflib
from collections.abc import Collection


def no_such(kind: str, name: str, known: Collection[str]) -> str:
    """The sentences about a name that is none of those ``known``: what was perhaps meant, and what there is."""
    near = difflib.get_close_matches(name, known, 1)
    hint = f"; did you mean '{near[0]}'?" if near else "."
    return f"there is no {kind} '{name}'{hint} There are: {', '.join(known) or 'none'}"


class LamellaError(Exception):
    """Base of all errors raised on purpose; the command line prints its message and exits with code 2."""


class DeclarationError(LamellaError, ValueError):
    """A declaration (body, joint, load, ...) was given an impossible value.

    Args:
        item: what was declared, for example ``Plate 'wing'``.
        problem: what is wrong, with the value.
        accepted: what would be accepted.
    """

    def __init__(self, item: str, problem: str, accepted: str = "") -> None:
        self.item, self.problem, self.accepted = item, problem, accepted
        super().__init__(f"{item}: {problem}" + (f"; {accepted}" if accepted else ""))


class UnitError(LamellaError, ValueError):
    """A quantity carries a unit that cannot be converted to the one expected."""


class ModelFileError(LamellaError):
    """A model file cannot be read or does not describe a model; the message names file, line and key."""


class ConstraintError(LamellaError):
    """Constraints are contradictory or redundant; the message names them."""


class ModelError(LamellaError):
    """A system as a whole cannot be compiled or solved (no body, no constraint in statics, ...)."""


class FunctionError(ModelError):
    """A Python function of the model, a control law or a force, raised an error, which is its cause, or gave no numbers.

    Attributes:
        outcome, result: as those of :class:`ConvergenceError`; None where nothing had been computed.
    """

    outcome: object = None
    result: object = None


class ConvergenceError(LamellaError):
    """A solution procedure stopped before its end.

    Args:
        outcome: the :class:`lamella.result.Outcome`, with its numbers.
        result: what was computed until then; valid, and shorter than asked for.
    """

    def __init__(self, message: str, outcome: object = None, result: object = None) -> None:
        self.outcome, self.result = outcome, result
        super().__init__(message)


class SingularSystemError(LamellaError):
    """A matrix that must be regular is singular; the message names the coordinates that are free.

    Args:
        index: the independent coordinate (a multiplier counts behind the coordinates) that is most free, None when not known.
    """

    def __init__(self, message: str, index: int | None = None) -> None:
        self.index = index
        super().__init__(message)


class ResultFileError(LamellaError):
    """A result file cannot be written or read (read-only folder, full disk, not a result file)."""


class MissingExtraError(LamellaError, ImportError):
    """An optional library is needed; the message gives the ``pip install`` line."""


class WorkerError(LamellaError):
    """The processes or the cluster that run a study cannot be reached, or were lost; what was finished is kept."""
