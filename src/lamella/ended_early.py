"""The error that stands for a solution which ended early, and holds what was computed."""

from __future__ import annotations

from lamella.errors import ConvergenceError
from lamella.result import Cause, Result


def error_of(result: Result, text: str) -> BaseException:
    """What to raise for a result that is not complete.

    Args:
        result: what was computed until then.
        text: what ended, and how.

    Returns:
        ``KeyboardInterrupt`` after one; the :class:`FunctionError` of a Python function of the model that failed, with outcome
        and result; else a :class:`ConvergenceError` with both.
    """
    outcome = result.outcome
    if outcome.cause is Cause.INTERRUPTED:
        return KeyboardInterrupt(text)
    if outcome.error is not None:
        outcome.error.outcome, outcome.error.result = outcome, result
        return outcome.error
    return ConvergenceError(text, outcome, result)
