"""Functions inside machine code: parts of the kernels that call them, without machine code of their own.

Numba makes machine code of every function that it compiles. Those which kernels call are run as a part of a kernel
alone, into which they are linked before its machine code is made: theirs would never run.
"""

import gc
from functools import cache
from importlib import import_module
from typing import Any

_waiting: dict[str, Any] = {}  # Python objects of parts, until a kernel that links them is in memory


@cache
def _part() -> Any:
    """Class of code that has no address."""

    class Part(import_module("numba.core.codegen").JITCodeLibrary):  # type: ignore[misc]
        """Code that others link, and that is at no address."""

        def add_ir_module(self, module: Any) -> None:
            """Keep routines what they are, functions that are called: the compiler would inline them everywhere."""
            defined = [function for function in module.functions if not function.is_declaration]
            self.inlined = any("alwaysinline" in function.attributes for function in defined)
            for function in defined:
                if "alwaysinline" not in function.attributes:
                    function.attributes.add("noinline")
            super().add_ir_module(module)

        def _optimize_functions(self, module: Any) -> None:
            """Optimise what is inlined; the kernel that links the other functions optimises them, once."""
            module.data_layout = self._codegen._data_layout
            if self.inlined:
                super()._optimize_functions(module)

        def _optimize_final_module(self) -> None:
            if self.inlined:
                super()._optimize_final_module()

        def _finalize_final_module(self) -> None:
            self._finalize_dynamic_globals()
            self._finalized = True

        def get_pointer_to_function(self, name: str) -> int:
            self._ensure_finalized()
            return 0

        @property
        def codegen(self) -> Any:  # whose set_env is called then
            return self

        def set_env(self, name: str, environment: Any) -> None:
            _waiting[name] = environment

    return Part


@cache
def compilers() -> tuple[Any, Any]:
    """Numba's compiler (its `pipeline_class`) for kernels, and that for the functions inside them."""
    numba: Any = import_module("numba.core.compiler")
    part, steps = _part(), list[Any]()  # Numba's steps, put together once: they are the same for every function

    def steps_for(state: Any) -> list[Any]:
        if not steps:
            steps.append(numba.DefaultPassBuilder.define_nopython_pipeline(state))
        return steps

    class Parts(numba.CompilerBase):  # type: ignore[misc]
        """Numba's own steps, which put the code into a `Part`."""

        def define_pipelines(self) -> list[Any]:
            self.state.library = part(self.state.targetctx.codegen(), self.state.func_id.func_qualname)
            return steps_for(self.state)

    class Kernels(numba.Compiler):  # type: ignore[misc]
        """Numba's own, which gives the parts of a kernel their Python objects too: a `print` in a law has some."""

        def define_pipelines(self) -> list[Any]:
            return steps_for(self.state)

        def compile_extra(self, function: Any) -> Any:
            collecting = gc.isenabled()
            gc.disable()  # nearly all that is made is kept: looking for garbage takes a tenth of the time
            try:
                compiled = super().compile_extra(function)
            finally:
                if collecting:
                    gc.freeze()  # with `unfreeze`: what is new becomes old, and is not looked through now
                    gc.unfreeze()
                    gc.enable()
            if compiled.library is None:  # types alone
                return compiled
            codegen = compiled.library.codegen
            for name in [name for name in _waiting if codegen._engine.is_symbol_defined(name)]:
                codegen.set_env(name, _waiting.pop(name))
            return compiled

    return Kernels, Parts
