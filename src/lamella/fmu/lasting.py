"""Units that may be called on after an error, and a process that ends in order, whatever the binary that calls them gives up."""

from __future__ import annotations

import atexit
import ctypes
import os
import sys
import threading
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
ENDING: set[Path] = set()
"""Binaries whose end is in order."""


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
    _end_in_order(resources.parent)
    if "_interface" not in vars(of):
        of._interface = read_interface(resources)
    return of._interface


def _end_in_order(unzipped: Path) -> None:
    """Let a unit's binary give up its hold on Python before the process ends.

    When all its instances are freed it does so twice at the very end, the second time by memory that is freed already, which
    ended a fifth of all processes by a signal. Where the binary itself has started Python, its hold is what ends Python. On
    Windows the order is right.
    """
    if sys.platform != "linux" or threading.main_thread().native_id != os.getpid():
        return
    for path in set(unzipped.glob("binaries/*/*.so")) - ENDING:
        try:
            binary = ctypes.CDLL(str(path), mode=os.RTLD_NOLOAD)
        except OSError:  # it is not loaded, as when the unit is built
            continue
        if hasattr(binary, "finalizePythonInterpreter"):
            atexit.register(binary.finalizePythonInterpreter)
        ENDING.add(path)
