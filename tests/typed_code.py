"""Types that compiled code finds for the drives of project files, without machine code: `python typed_code.py < TEXTS`.

The standard input is a JSON list of project files' texts; what is printed is a JSON list of the sentences about those
drives that cannot be compiled. The compiler stops after it has found all types, which is ten times faster and where
code that it does not know is refused. A process of its own, as the compiler keeps what it has typed.
"""

import json
import sys
from itertools import chain
from pathlib import Path

import numba
from numba.core import compiler, typed_passes
from numba.core.compiler_machinery import LoweringPass, register_pass
from numba.core.typing import signature

import strainwave as sw
from strainwave.base.law import is_spring, torsion
from strainwave.compile import address, calls, inner, jit, numba_import
from strainwave.compile.tree import classes
from strainwave.files.reading import from_text
from strainwave.model.train.train_forms import AtLoad, Metered
from strainwave.numerics.balance import second_order as balance
from strainwave.numerics.integration import methods as integrate


@register_pass(mutates_CFG=True, analysis_only=False)
class Typed(LoweringPass):
    """Ends a compilation with types and no code; `len` stands for the entry that is never called."""

    _name = "types_alone"

    def __init__(self):
        LoweringPass.__init__(self)

    def run_pass(self, state):
        state.cr = compiler.compile_result(
            typing_context=state.typingctx, target_context=state.targetctx, entry_point=len, typing_error=None,
            type_annotation=None, library=None, signature=signature(state.return_type, *state.args), objectmode=False,
            lifted=(), fndesc=None, environment=None, metadata=state.metadata, reload_init=[], call_helper=None,
        )  # fmt: skip
        return True


def pipelines(self):
    """Passes of the compiler up to the types."""
    passes = compiler.DefaultPassBuilder.define_untyped_pipeline(self.state)
    passes.add_pass(typed_passes.NopythonTypeInference, "types")
    passes.add_pass(Typed, "no code")
    passes.finalize()
    return [passes]


def rates(system, phase, y):
    """What an integration calls."""
    return system.rhs(phase, y), torsion(system, phase, y)


def dispatcher(function, classes):
    """Compiled form of a function for models of these classes, with all known that its compilation asks for."""
    numba_import.numba_module()
    jit.expose(*classes)
    return jit.dispatcher_of(function, classes)


class TypedError(Exception):
    """Ends a computation whose first kernel has types."""


def typed(function, *arguments, **_options):
    """Find the types of a kernel with its arguments, and of what it calls by address, in place of a run of it."""
    things = [arg.native() if isinstance(arg, address.ByAddress) else arg for arg in arguments]
    dispatcher(function, classes(things)).get_call_template(tuple(map(numba.typeof, things)), {})
    raise TypedError


def typed_entry(function, thing, _known, kinds):
    """Find the types of a function that kernels call by address, in place of its machine code."""
    written = calls.signature(numba.types, numba.typeof(thing), kinds)
    dispatcher(function, classes((thing,))).get_call_template(written, {})
    return 0


def forms(project):
    """What an analysis of the project computes with, as far as it is compiled."""
    yield project.system(project.speeds.given[0], reduced=True)
    train = project.train
    if train is None:
        return
    if isinstance(train.motor.control, sw.train.Free):
        yield sw.train.SteadyTrain(train, 100.0)
    else:
        yield AtLoad(train, train.omega)
        yield Metered(train._replace(reference=sw.train.SpeedProfile((0.0, 1.0, 2.0), (100.0, 100.0, 200.0))))


def complaints(text):
    """Sentences about what of a drive cannot be compiled."""
    for system in forms(from_text(text, Path("project.yaml"))):
        whole = system.train if isinstance(system, AtLoad) else system
        states = (0.1,) * len(whole.state_names())
        jobs = [lambda system=system, states=states: typed(rates, system, 0.3, states)]
        if isinstance(system, sw.Oscillator) and is_spring(system):
            jobs.append(lambda system=system: sw.frequency_response(system, (1.0, 2.0), harmonics=3))
        for job in jobs:
            try:
                job()
            except TypedError:
                pass
            except numba.errors.NumbaError as error:
                yield f"{type(system).__name__} of {text}: {error}"


if __name__ == "__main__":
    for each in (compiler.Compiler, *inner.compilers()):
        each.define_pipelines = pipelines
    balance.run = integrate.run = typed
    jit._address_of = typed_entry
    jit.CodeCache.location = lambda *_: ([], None, "")  # types alone are not kept
    print(json.dumps(list(chain.from_iterable(map(complaints, json.load(sys.stdin))))))
