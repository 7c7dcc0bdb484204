"""Units that may be called on after an error, whatever the binary that calls them gives up."""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from functools import wraps
from pathlib import Path
from typing import Any, TypeVar

from lamella.fmu.plant import Interface, read_interface

Unit = TypeVar("Unit", bound=type)

CALLS = (
    *("setup_experiment", "enter_initialization_mode", "exit_initialization_mode", "do_step", "terminate"),
    *("_get_fmu_state", "_set_fmu_state"),
    *(f"{verb}_{kind}" for verb in ("get", "set") for kind in ("real", "integer", "boolean", "string")),
    *(f"{verb}_{kind}" for verb in ("get", "set") for kind in ("float64", "int32", "int64", "uint64")),
)
"""Methods that the binaries of pythonfmu and pythonfmu3 call."""


def lasting(unit: Unit) -> Unit:
    """Let the instances of a unit outlast errors in their methods.

    Where one raises, the binary answers *fatal* with the message, gives up its references to class, instance and messages, and
    uses them again when it is called once more, if only to free the instance: that ended the whole process. So each error is
    given references of its own.
    """
    for name in CALLS:
        if hasattr(unit, name):
            setattr(unit, name, _lasting(getattr(unit, name)))
    return unit


def _lasting(method: Callable[..., Any]) -> Callable[..., Any]:
    @wraps(method)
    def call(self: Any, *args: Any) -> Any:
        try:
            return method(self, *args)
        except Exception:
            for held in (type(self), self, self.log_queue):
                ctypes.pythonapi.Py_IncRef(ctypes.py_object(held))
            raise

    return call


def interface_of(unit: Any) -> Interface:
    """What a unit shows, read from its resources once for its class.

    A reset makes the instance anew, and the binary uses what it has given up when that fails: nothing must be read then.

    Raises:
        ModelError: the interface is missing or damaged.
    """
    resources, of = Path(unit.resources), type(unit)
    if "_interface" not in vars(of):
        of._interface = read_interface(resources)
    return of._interface
