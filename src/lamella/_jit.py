"""Numba as lamella uses it: compilation options, the cache of compiled kernels and the watch over a first compilation.

Numba's own cache does not notice that a function called from another file has changed. Here the cache folder carries a hash of
every source file that is compiled, so an edit anywhere in a kernel starts a fresh folder; folders left unused are removed.
"""

from __future__ import annotations

import hashlib
import os
import shutil
import tempfile
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Protocol, TypeVar, cast

import numba
from numba.core import event
from numba.extending import overload, register_jitable
from platformdirs import user_cache_path

from lamella._compiler import InnerCompiler, KernelCache

Function = TypeVar("Function", bound=Callable[..., Any])

FAST_MATH = {"contract", "nsz"}
"""Fused multiply-add and signed zeros only: NaN and infinity keep their meaning, so that a failed step is seen."""

OPTIONS: dict[str, Any] = {"fastmath": FAST_MATH, "error_model": "numpy", "no_cfunc_wrapper": True}
"""Of all that is compiled. No kernel is called from C, so that no wrapper is made for it: a tenth of the time."""

KEPT_FOLDERS = 3
"""Cache folders of other versions that are kept beside the one in use."""


def _source_hash() -> str:
    """Hash of all source files of the package that take part in compilation, and of Numba's version."""
    digest = hashlib.sha256(numba.__version__.encode())
    package = os.path.dirname(__file__)
    for folder, folders, names in os.walk(package):  # each start reads all files, for which pathlib takes twice as long
        folders.sort()
        for name in sorted(names):
            if not name.endswith(".py"):
                continue
            with open(f"{folder}/{name}", "rb") as file:
                text = file.read()
            if name in ("_jit.py", "_compiler.py", "lane.py") or b"lamella._jit" in text:
                digest.update(f"{os.path.relpath(folder, package)}/{name}".encode() + b"\0" + text)
    return digest.hexdigest()[:16]


def _prune(parent: Path, current: Path) -> None:
    """Remove all but the most recently used cache folders of other versions."""
    others = [path for path in parent.iterdir() if path.is_dir() and path != current]
    others.sort(key=lambda path: path.stat().st_mtime, reverse=True)
    for path in others[KEPT_FOLDERS:]:
        shutil.rmtree(path, ignore_errors=True)


def _usable(folder: Path) -> bool:
    """Create a private folder, mark it as used now, and say whether it is ours and files can be written to it."""
    try:
        folder.parent.mkdir(parents=True, exist_ok=True)
        folder.mkdir(mode=0o700, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            os.utime(folder)
        return not hasattr(os, "getuid") or folder.stat().st_uid == os.getuid()  # code is loaded from it: nobody else's
    except OSError:
        return False


def _cache_parents() -> Iterator[Path]:
    """Where the folder may be; a folder for temporary files is looked for, and need not be there, only where it is needed."""
    yield user_cache_path("lamella") / "kernels"
    yield Path(tempfile.gettempdir()) / "lamella-kernels"


def _cache_folder() -> Path:
    """Folder of the compiled kernels of these sources: in the user's cache, else below the folder for temporary files."""
    key = _source_hash()
    for parent in _cache_parents():
        if _usable(parent / key):
            _prune(parent, parent / key)
            return parent / key
    return Path(tempfile.mkdtemp(prefix="lamella-kernels-"))


CACHE_FOLDER = _cache_folder()


def njit(function: Function) -> Function:
    """Compile a kernel without the interpreter; the machine code is cached in :data:`CACHE_FOLDER`."""
    return _compiled(function)


def kernel(function: Function) -> Function:
    """As :func:`njit`, for a kernel that makes no arrays, so that references to them need not be counted.

    Numba counts each array that a function is called with up and down again, atomically, also where the call is inlined: some
    40 cycles an array, which in loops over points or small blocks cost more than the arithmetic. A kernel that makes arrays
    after all does not compile: "NRT required but not enabled".
    """
    return _compiled(function, _nrt=False)


def shared(function: Function) -> Function:
    """As :func:`kernel`, for one that threads run side by side: the interpreter's lock is given up meanwhile, at 40 ns a call."""
    return _compiled(function, _nrt=False, nogil=True)


def _compiled(function: Function, **options: Any) -> Function:
    compiled: Any = numba.njit(**OPTIONS, **options)(function)
    compiled._cache = KernelCache(function, str(CACHE_FOLDER))
    return cast("Function", compiled)


def inlined(function: Function) -> Function:
    """Let compiled kernels call a function, inserted in place, while Python still calls it as it stands (also with arrays)."""
    return register_jitable(forceinline=True, pipeline_class=InnerCompiler, **OPTIONS)(function)


def inner(function: Function) -> Function:
    """As :func:`inlined`, for one that is called rather than inserted, unless LLVM thinks better of it. Only kernels call it."""
    return register_jitable(pipeline_class=InnerCompiler, **OPTIONS)(function)


def compiled_as(function: Callable[..., Any]) -> Callable[[Callable[..., Any]], Callable[..., Any]]:
    """Let compiled kernels call, in place of a function, what the decorated one returns for the types of the arguments."""
    return cast("Any", overload)(function, jit_options={"forceinline": True, **OPTIONS})


def is_array(of: Any, numbers: str = "") -> bool:
    """Whether the type of an argument, as :func:`compiled_as` hands it over, is an array, of numbers of that name if given."""
    return isinstance(of, numba.types.Array) and (not numbers or of.dtype.name == numbers)


class Watch(Protocol):
    """Is told of each kernel that is compiled; functions that it calls count as parts of it."""

    def begin(self, name: str) -> None:
        """A kernel is about to be compiled."""

    def end(self) -> None:
        """It is compiled, or has failed."""


class _Watcher(event.Listener):
    """Tells a watch of the outermost of nested compilations."""

    def __init__(self, watch: Watch) -> None:
        self.watch, self.depth = watch, 0

    def on_start(self, event: event.Event) -> None:
        """Tell of a kernel, not of its parts."""
        self.depth += 1
        if self.depth == 1:
            function = cast("Any", event.data)["dispatcher"].py_func
            self.watch.begin(f"{function.__module__.rpartition('.')[2]}.{function.__name__.lstrip('_')}")

    def on_end(self, event: event.Event) -> None:
        """Tell that it is done."""
        self.depth -= 1
        if self.depth == 0:
            self.watch.end()


@contextmanager
def watched(watch: Watch) -> Iterator[None]:
    """Tell ``watch`` of every kernel that has to be compiled within the context; with a warm cache it hears nothing."""
    listener = _Watcher(watch)
    event.register("numba:compile", listener)
    try:
        yield
    finally:
        event.unregister("numba:compile", listener)
