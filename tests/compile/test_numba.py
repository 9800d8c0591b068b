"""Places of Numba that are no documented interface: each that the package uses is named here and is there."""

import re
from functools import reduce
from importlib import import_module
from pathlib import Path

import pytest

import strainwave

ROOT = Path(strainwave.__file__).parent
PLACES = {
    "numba.core.bytecode": ["FunctionIdentity._unique_ids"],
    "numba.core.cgutils": ["alloca_once", "if_unlikely"],
    "numba.core.codegen": ["JITCodeLibrary.add_ir_module", "JITCodeLibrary._ensure_finalized"],
    "numba.core.compiler": [
        "CompileResult._rebuild", "CompilerBase.define_pipelines", "Compiler.compile_extra",
        "DefaultPassBuilder.define_nopython_pipeline",
    ],
    "numba.core.compiler_lock": ["global_compiler_lock"],
    "numba.core.errors": ["NumbaError"],
    "numba.core.registry": ["cpu_target.target_context"],
    "numba.core.runtime": ["rtsys.initialize"],
    "numba.core.serialize": ["NumbaPickler"],
    "numba.core.types": ["BaseNamedTuple", "Function"],
    "numba.core.typing.templates": [
        "infer", "infer_getattr", "infer_global", "make_overload_method_template", "make_overload_template",
    ],
    "numba.np.arraymath": [],
    "numba.np.arrayobj": ["populate_array"],
}  # fmt: skip


@pytest.mark.slow
def test_each_place_is_there():
    for module, names in PLACES.items():
        for name in names:
            reduce(getattr, name.split("."), import_module(module))


def test_each_place_that_the_package_imports_is_named():
    text = "".join(path.read_text(encoding="utf-8") for path in ROOT.rglob("*.py"))
    used = set(re.findall(r'import_module\("(numba\.(?:core|np)[\w.]*)"\)', text))
    used |= {f"numba.core.{name}" for name in re.findall(r"from numba\.core import (\w+)", text)}
    assert used == set(PLACES)
