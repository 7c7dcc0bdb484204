"""How Numba compiles lamella's kernels in three fifths of its time: functions are optimised once, operators found at once.

Numba optimises every function that a kernel calls and makes machine code of it, and does the same again within each caller, five
levels deep in a factorisation. Functions compiled by :class:`InnerCompiler` are handed to their callers as they are, and
optimised with the outermost. They have no machine code of their own and cannot be called from Python.

For ``a[i]`` Numba asks unicode, lists, dictionaries and tuples before arrays. Signatures that name the target are asked first.
"""

from __future__ import annotations

import gc
import importlib
import operator
from functools import cache, cached_property
from typing import Any, Literal, cast

from llvmlite import binding
from numba.core import caching, codegen, compiler, compiler_machinery, event, typed_passes
from numba.core import config as numba_config
from numba.core.typing import arraydecl, templates

_dynfunc: Any = importlib.import_module("numba._dynfunc")  # compiled, so that type checkers do not see it
_runtime: Any = importlib.import_module("numba.core.runtime._nrt_python")  # likewise

FIRST = {"target": "cpu"}
"""Metadata of signatures that are asked before all others of an operator."""

llvm = cast("Any", binding)  # without annotations
NOTHING = llvm.parse_assembly("").as_bitcode()
"""A module without content, in the form in which others take it in."""

config = cast("Any", numba_config)  # its attributes are made at run time
infer_global = cast("Any", templates.infer_global)  # its type is too narrow


@infer_global(operator.getitem)
class _ReadArray(arraydecl.GetItemBuffer):
    metadata = FIRST


@infer_global(operator.setitem)
class _WriteArray(arraydecl.SetItemBuffer):
    metadata = FIRST


class _InnerLibrary(codegen.JITCodeLibrary):
    """Code that goes into the libraries of its callers, and is optimised and made machine code there."""

    def _optimize_final_module(self) -> None:
        """Nothing is optimised."""

    def _finalize_final_module(self) -> None:
        """Nothing is made machine code."""
        self._finalized = True


@compiler_machinery.register_pass(mutates_CFG=True, analysis_only=False)
class _InnerLowering(typed_passes.NativeLowering):
    _name = "inner_lowering"

    def run_pass(self, state: Any) -> Literal[True]:
        """Lower to LLVM's language, and let kernels know the function by a name that stands for no code."""
        state.library = library = _InnerLibrary(state.targetctx.codegen(), state.func_id.func_qualname)
        super().run_pass(state)
        lowered = state["cr"]
        library._ensure_finalized()
        name = state.func_id.func_name
        entry = _dynfunc.make_function(lowered.fndesc.lookup_module(), name, "part of kernels", 0, lowered.env, (library,))
        state.targetctx.insert_user_function(entry, lowered.fndesc, [library])
        state.reload_init.extend(getattr(library, "_reload_init", ()))  # of newer versions of Numba
        state["cr"] = lowered._replace(cfunc=entry)
        return True


class InnerCompiler(compiler.CompilerBase):
    """Compiles a function that only kernels call."""

    def __init__(self, *args: Any) -> None:
        super().__init__(*args)
        self.state.flags.no_compile = True

    def define_pipelines(self) -> list[Any]:
        """Numba's own passes, but for the last."""
        passes = compiler.DefaultPassBuilder.define_nopython_pipeline(self.state)
        passes.passes = [
            (_InnerLowering, text) if step is typed_passes.NativeLowering else (step, text) for step, text in passes.passes
        ]
        passes.finalize()
        return [passes]


class _StoredLibrary(codegen.JITCodeLibrary):
    """Machine code from the cache; what callers that have yet to be compiled take in of it is read when there is one."""

    bitcode = b""

    def _get_module_for_linking(self) -> Any:
        if self._shared_module is None:
            self._shared_module = llvm.parse_bitcode(self.bitcode)
        return self._shared_module


class _Storage(caching.CompileResultCacheImpl):
    """Numba's storage of a kernel, which parses both forms of its code at every start, and so takes twice as long to read."""

    def reduce(self, cres: Any) -> tuple[Any, ...]:
        """What is written: Numba's own, and the names that the code defines."""
        module = cres.library._get_module_for_linking()
        symbols = (*module.functions, *module.global_variables)
        return {symbol.name for symbol in symbols if not symbol.is_declaration}, *super().reduce(cres)

    def rebuild(self, target_context: Any, payload: tuple[Any, ...]) -> Any:
        """The kernel of what was written."""
        names, (name, kind, (machine_code, bitcode)), *rest = payload
        target_context.codegen()._engine._defined_symbols.update(names)
        kernel = super().rebuild(target_context, ((name, kind, (machine_code, NOTHING)), *rest))
        library = kernel.library
        library.__class__, library.bitcode, library._shared_module = _StoredLibrary, bitcode, None
        return kernel


@cache
def _announce_runtime() -> None:
    """Tell LLVM where the functions are that make and release arrays for kernels.

    Numba does so too when something has to be compiled, and compiles what counts references, which stored kernels have in them.
    """
    for name, address in _runtime.c_helpers.items():
        llvm.add_symbol(name if name.startswith("_") else f"NRT_{name}", address)


class _Cache(caching.FunctionCache):
    """Numba's cache, without the tables of all functions and types that Numba makes before it reads machine code: 0.15 s.

    When something has to be compiled, Numba makes them all the same.
    """

    _impl_class = _Storage

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """The compiled kernel, or None when it is not in the cache."""
        _announce_runtime()
        with self._guard_against_spurious_io_errors():
            return self._load_overload(sig, target_context)

    def save_overload(self, sig: Any, data: Any) -> None:
        """Write a compiled kernel, and connect the environments of the functions it has taken in."""
        for environment in data._find_referenced_environments():
            data.library.codegen.set_env(environment.env_name, environment)
        super().save_overload(sig, data)


class KernelCache:
    """The cache of one kernel, made when it is first called: of a hundred kernels a model calls twenty.

    Args:
        function: what is compiled.
        folder: where the machine code goes.
    """

    def __init__(self, function: Any, folder: str) -> None:
        self.function, self.folder = function, folder

    @cached_property
    def _cache(self) -> _Cache:
        user_setting = config.CACHE_DIR
        config.CACHE_DIR = self.folder  # read by the cache that is made; other packages keep their setting
        try:
            return _Cache(self.function)
        finally:
            config.CACHE_DIR = user_setting

    def __getattr__(self, name: str) -> Any:
        return getattr(self._cache, name)


class _Uncollected(event.Listener):
    """Keeps Python from looking for garbage while a kernel is compiled: hundreds of thousands of objects that mostly stay."""

    def __init__(self) -> None:
        self.depth, self.was_enabled = 0, False

    def on_start(self, event: event.Event) -> None:
        """Stop at the first kernel."""
        if self.depth == 0:
            self.was_enabled = gc.isenabled()
            gc.disable()
        self.depth += 1

    def on_end(self, event: event.Event) -> None:
        """Go on after the last, also when it did not compile."""
        self.depth -= 1
        if self.depth == 0 and self.was_enabled:
            gc.enable()


event.register("numba:compile", _Uncollected())
