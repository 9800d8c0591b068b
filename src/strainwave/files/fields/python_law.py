"""A law of the user's own, from a Python file beside the project file: {python: mylaws.py:MyLaw, K: 7160 N*m/rad}.

Reading such a project runs that file: a project file of a stranger may then do what any program may. The file lies in
the folder of the project file, and no path leads out of it.
"""

import copyreg
import hashlib
import os
import re
import sys
from contextlib import redirect_stdout
from pathlib import Path
from types import ModuleType
from typing import Any, get_args, get_origin, get_type_hints

import numpy as np

from ...base.law import check_law, states_of, torque_of
from ...base.protocols import Law
from ...base.quantities import checked
from ..yaml_text import Located, Problem, read_text, shown
from .kinds import Entry, Wrong
from .rows import problems_of, read_group

PLACES = ("law", "hysteresis", "drag", "first", "second")  # where "mylaws.py:MyLaw" alone is a law
NAMED = re.compile(r"(.+\.py):(\w+)")
EXAMPLE = "mylaws.py:MyLaw"
TRIED = (0.0, 1e-5, -1e-5, 1e-3, -1e-3)  # rad: torsions at which a law is asked for its torque
FILE_BYTES, LETTERS = 256 * 1024, 100  # bytes of a file, and letters of its name


def with_python_laws(located: Located, folder: Path) -> tuple[Any, list[Problem]]:
    """Content of a project file with the laws of Python files in place of their entries, and what is wrong with them.

    A law with a fault is None.
    """
    faults: list[Wrong] = []
    content = _replaced(located.content, Entry((), faults), folder)
    return content, list(problems_of(faults, located))


def _replaced(value: object, entry: Entry, folder: Path) -> Any:
    """A value of the file with its laws of Python files in place of their entries, at any depth."""
    if isinstance(value, list):
        return [_replaced(item, entry.inside(i), folder) for i, item in enumerate(value)]
    if isinstance(value, dict):
        inside = {key: _replaced(item, entry.inside(key), folder) for key, item in value.items()}
        return _law(inside, entry, folder) if "python" in inside else inside
    if isinstance(value, str) and entry.keys and entry.keys[-1] in PLACES and NAMED.fullmatch(value.strip()):
        return _law({"python": value}, entry, folder)
    return value


def _law(group: dict[str, Any], entry: Entry, folder: Path) -> Any:
    """Law of a group with the field `python`; None with a fault of its entry."""
    source = group["python"]
    source_entry = entry.inside("python") if len(group) > 1 else entry
    try:
        cls = _class_named(source, folder)
        _check_fields(cls)
        law = read_group({key: item for key, item in group.items() if key != "python"}, cls, entry, ("python",))
        if law is not None:
            _check_methods(law)
        return law
    except (TypeError, ValueError) as error:
        return source_entry.wrong("" if source is None else str(error))


def _class_named(given: object, folder: Path) -> Any:
    """The class that "mylaws.py:MyLaw" names (ValueError)."""
    match = NAMED.fullmatch(given.strip()) if isinstance(given, str) else None
    if match is None:
        raise ValueError(f"{shown(given)} names no class of a Python file; write for example {EXAMPLE}")
    file, cls = match.groups()
    if len(file) > LETTERS or re.search(r"[/\\:]|^\.", file) or (folder / file).resolve().parent != folder.resolve():
        raise ValueError(f"{shown(file)} is no plain file name; put the Python file beside the project file")
    if not (folder / file).exists():
        raise ValueError(f"{file} is not beside the project file; put it there, or check its name")
    module = _module(folder / file)
    laws = [word for word, thing in vars(module).items() if _is_law(thing) and thing.__module__ == module.__name__]
    if cls not in laws:
        choices = f"its NamedTuples with a torque are {', '.join(laws)}" if laws else "no NamedTuple there has a torque"
        raise ValueError(f"{file} has no law {cls!r}; {choices}")
    return vars(module)[cls]


def _is_law(thing: object) -> bool:
    """True for a NamedTuple class with a torque."""
    named = isinstance(thing, type) and issubclass(thing, tuple) and hasattr(thing, "_fields")
    return named and hasattr(thing, "torque")


def _module(path: Path) -> ModuleType:
    """The module of a file, run once for each content of it."""
    text = read_text(path, "Python file", FILE_BYTES)
    if isinstance(text, Problem):
        raise ValueError(f"{path.name} {text.sentence}")
    module_name = "strainwave_law_" + hashlib.sha256(f"{path.resolve()}\n{text}".encode()).hexdigest()[:16]
    if module_name in sys.modules:
        return sys.modules[module_name]
    module = ModuleType(module_name)
    module.__file__ = str(path)
    sys.modules[module_name] = module  # where pickle and the types of annotations look for it
    folder = os.getcwd()
    try:
        with redirect_stdout(sys.stderr):  # what it prints is no part of a result
            exec(compile(text, str(path), "exec"), vars(module))
    except KeyboardInterrupt:
        del sys.modules[module_name]
        raise
    except BaseException as error:
        del sys.modules[module_name]
        raise ValueError(f"{path.name} does not run: {_brief(error)}{_origin(error, path)}; correct it") from None
    finally:
        os.chdir(folder)  # that of the process is not the file's to change
    for cls in filter(_is_law, list(vars(module).values())):
        copyreg.pickle(cls, _reduced)  # a worker process knows the file, and not the module
    return module


def _reduced(law: Any) -> tuple[Any, ...]:
    """A law as pickle takes it: what makes it again, and the file, the class and the numbers."""
    cls = type(law)
    return restored, (sys.modules[cls.__module__].__file__, cls.__name__, tuple(law))


def restored(file: str, cls: str, numbers: tuple[Any, ...]) -> Any:
    """Law of a Python file by its class and numbers, in a process that has not read the file (ValueError)."""
    path = Path(file)
    return _class_named(f"{path.name}:{cls}", path.parent)(*numbers)


def _brief(error: BaseException) -> str:
    """Kind and message of an error, on one line."""
    return f"{type(error).__name__}: {' '.join(str(error).split())[:100]}".removesuffix(": ")


def _origin(error: BaseException, path: Path) -> str:
    """Line of a file from which an error comes, in words; empty for an unknown one."""
    line = error.lineno if isinstance(error, SyntaxError) else None
    step = error.__traceback__
    while step is not None:
        if step.tb_frame.f_code.co_filename == str(path):
            line = step.tb_lineno
        step = step.tb_next
    return "" if line is None else f" in line {line}"


def _check_fields(cls: type[Any]) -> None:
    """Refuse a class whose fields a project file cannot give (ValueError)."""
    try:
        hints = get_type_hints(cls, include_extras=True)
    except Exception as error:
        raise ValueError(f"the annotations of {cls.__name__} cannot be read: {_brief(error)}; correct them") from None
    for field, hint in hints.items():
        if hint is float or (hint not in (int, Any) and get_origin(hint) is not tuple and len(get_args(hint)) < 2):
            remedy = f"{field}: Annotated[float, 'N*m/rad'], int, or Any for a law inside"
            raise ValueError(f"{cls.__name__}.{field} has no unit; write in the class {remedy}")
    if not hasattr(cls, "stiffness"):
        raise ValueError(f"{cls.__name__} has no stiffness(x), the slope of its torque; write that method too")


def _check_methods(law: Law) -> None:
    """Refuse a law that raises or gives no finite number (ValueError), or whose methods do not fit (TypeError)."""
    checked(law)
    cls = type(law).__name__
    check_law(cls, law)

    def torque(x: Any) -> Any:
        return torque_of(law, x, 0.0, (0.0,) * states_of(law))

    for method, function in (("torque", torque), ("stiffness", law.stiffness)):
        for x in TRIED:
            try:
                value = function(x)
                finite = abs(float(value)) < float("inf")
            except Exception as error:
                raise ValueError(f"{cls}.{method} at {x:g} rad raises {_brief(error)}; correct it") from None
            if not finite:
                raise ValueError(f"{cls}.{method} at {x:g} rad gives {value!r}; it must be a finite number")
    twists: Any = np.array(TRIED)
    try:
        torques: Any = np.asarray(torque(twists) + 0.0 * twists)
        slopes: Any = np.asarray(law.stiffness(twists) + 0.0 * twists)
    except Exception as error:
        raise ValueError(
            f"{cls} raises {_brief(error)} for an array of torsions; write it without 'if' and without math, with the "
            "functions of strainwave.maths, abs and NumPy"
        ) from None
    if torques.shape != twists.shape or slopes.shape != twists.shape:
        raise ValueError(f"{cls} gives {torques.shape} torques for {twists.shape} torsions; it must give one for each")
