"""Does the key of a kernel's machine code change wherever its code does?

    python benchmarks/code_keys.py [CHANGES] [SEED]

The kernels of `response`, `analyze` and `move` of the README's drive are listed. In copies of the package one constant
of one function is changed at a time, drawn among the functions that the kernels read. All kernels are compiled without
optimisation. Where the LLVM code of one differs, its key must too. Then every file of the package gets a comment
at its head and every docstring another text: no key may change.
"""

import ast
import hashlib
import os
import pickle
import random
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
DRIVE = ROOT / "benchmarks" / "readme_drive.yaml"
MOVE = "trapezoid, angle: 90 deg, time: 0.6 s"
OWN_NUMBERS = re.compile(r"B\d+v\d+|[bcdfs]_?\d{2,}|i64 \d{9,}|0x[0-9a-f]{6,}|\[\d+ x i8\]")


def listed(file: Path) -> None:
    """Run the three commands in this process and write the kernels that they ask for, with the functions they read."""
    from strainwave.compile import cache, cache_key

    kernels, load = {}, cache.CodeCache.load_overload

    def loaded(self, kinds, target):
        classes = tuple(dict.fromkeys(cache._classes(kinds)))
        kernels[self.function, kinds] = classes
        return load(self, kinds, target)

    cache.CodeCache.load_overload = loaded
    from strainwave.app.commands.cli import cli

    folder = str(file.parent / "out")
    for command in (["response"], ["analyze", "-o", folder], ["move", MOVE, "-o", folder]):
        cli([command[0], str(DRIVE), *command[1:]], standalone_mode=False)
    read = set()
    text = cache_key._text

    def noted(thing):
        read.add(thing)
        return text(thing)

    cache_key._text = noted
    for (function, _), classes in kernels.items():
        cache_key.key(function, classes)
    functions = {(f.__module__, f.__code__.co_firstlineno, f.__qualname__) for f in read if hasattr(f, "__code__")}
    names = [(f.__module__, f.__qualname__, pickle.dumps(kinds)) for f, kinds in kernels]
    file.write_bytes(pickle.dumps((names, sorted(functions))))


def made(file: Path, compiled: bool) -> None:
    """Write the keys of listed kernels and, if they are compiled, hashes of their code.

    All are compiled, in one order: the name of an inner function holds the flags of its first caller.
    """
    import importlib
    import itertools

    from numba.core import bytecode
    from numba.core.codegen import JITCodeLibrary

    from strainwave.compile import cache, cache_key, jit, numba_import

    names, _ = pickle.loads((file.parent / "listed").read_bytes())
    JITCodeLibrary._optimize_functions = JITCodeLibrary._optimize_final_module = lambda *_: None
    result = {}
    for module, path, kinds in names:
        name = module, path, kinds
        thing = importlib.import_module(module)
        for part in path.split("."):
            thing = getattr(thing, part)
        types = pickle.loads(kinds)
        classes = tuple(dict.fromkeys(cache._classes(types)))
        key, code = cache_key.key(thing, classes), ""
        if compiled:
            numba_import.numba_module()
            jit.expose(*classes)
            dispatcher = jit.dispatcher_of(thing, classes)
            dispatcher._cache = cache.CodeCache(thing)
            cache.CodeCache.place = lambda *_: ([], None, "")
            bytecode.FunctionIdentity._unique_ids = itertools.count(1)
            try:
                dispatcher.compile(types)
                text = text_of(dispatcher.overloads[types].library.get_llvm_str())
            except Exception as error:  # a constant may have made what no compiler takes
                text = repr(error)
            code = hashlib.sha256(text.encode()).hexdigest()
        result[name] = key, code
    file.write_bytes(pickle.dumps(result))


def text_of(code: str) -> str:
    """LLVM code without what numbers functions and objects of one process."""
    return OWN_NUMBERS.sub("", code)


def run(package: Path, *arguments: str) -> None:
    """Run a part of this script with a copy of the package."""
    env = os.environ | {"PYTHONPATH": str(package.parent), "PYTHONHASHSEED": "0", "STRAINWAVE_JIT": "1"}
    subprocess.run([sys.executable, __file__, *arguments], check=True, env=env, stdout=subprocess.DEVNULL)


def changed(file: Path, line: int, name: str, draw: random.Random) -> str:
    """Change a number in a function of a file, and say which; "" where it has none."""
    text = file.read_text(encoding="utf-8")
    functions = [n for n in ast.walk(ast.parse(text)) if isinstance(n, ast.FunctionDef) and n.name == name]
    inside = [n for f in functions if min(d.lineno for d in (f, *f.decorator_list)) == line for n in ast.walk(f)]
    numbers = [n for n in inside if isinstance(n, ast.Constant) and type(n.value) in (int, float)]
    if not numbers:
        return ""
    node = draw.choice(numbers)
    rows = text.encode().splitlines(keepends=True)
    row = rows[node.lineno - 1]
    new = str(node.value + 1).encode()
    rows[node.lineno - 1] = row[: node.col_offset] + new + row[node.end_col_offset :]
    file.write_bytes(b"".join(rows))
    return f"{file.name}:{node.lineno} {name}: {node.value} -> {new.decode()}"


def commented(package: Path) -> None:
    """Give every file a comment at its head, and every docstring of a function another text."""
    for file in package.rglob("*.py"):
        text = file.read_text(encoding="utf-8")
        rows = text.encode().splitlines(keepends=True)
        for node in ast.walk(ast.parse(text)):
            at = node.body[0].lineno - 1 if isinstance(node, ast.FunctionDef) else 0
            if at and ast.get_docstring(node) and rows[at].strip().startswith(b'"""'):
                rows[at] = rows[at].replace(b'"""', b'"""Other words. ', 1)
        if package / "compile" not in file.parents:  # which counts by its bytes
            file.write_bytes(b"# A comment.\n\n" * (b"from __future__" not in b"".join(rows)) + b"".join(rows))


def main() -> None:
    """Draw, change, compare."""
    count, seed = map(int, (sys.argv[1:] + ["40", "1"][len(sys.argv) - 1 :])[:2])
    draw, misses, moved = random.Random(seed), 0, []
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        copy = folder / "strainwave"
        shutil.copytree(ROOT / "src" / "strainwave", copy, ignore=shutil.ignore_patterns("__pycache__"))
        os.environ["STRAINWAVE_CACHE_DIR"] = str(folder / "cache")
        run(copy, "--list", str(folder / "listed"))
        run(copy, "--keys", str(folder / "before"))
        before = pickle.loads((folder / "before").read_bytes())
        functions = pickle.loads((folder / "listed").read_bytes())[1]
        print(f"{len(before)} kernels, {len(functions)} functions that they read")
        draw.shuffle(functions)
        while len(moved) < count and functions:
            module, line, path = functions.pop()
            file = copy.joinpath(*module.split(".")[1:]).with_suffix(".py")
            text = file.read_bytes() if file.is_file() else b""
            what = changed(file, line, path.rpartition(".")[2], draw) if text else ""
            if not what:
                continue
            run(copy, "--keys", str(folder / "after"))
            after = pickle.loads((folder / "after").read_bytes())
            keys = sum(after[one][0] != before[one][0] for one in before)
            wrong = [one[:2] for one in before if after[one][0] == before[one][0] and after[one][1] != before[one][1]]
            moved.append(keys)
            misses += len(wrong)
            print(f"{what}: {keys} keys change, {len(wrong)} should too {wrong or ''}", flush=True)
            file.write_bytes(text)
        commented(copy)
        run(copy, "--only-keys", str(folder / "after"))
        after = pickle.loads((folder / "after").read_bytes())
        same = sum(after[one][0] == before[one][0] for one in before)
    print(f"{misses} misses of {len(moved)} changes; with other comments and docstrings {same} keys are the same")


if __name__ == "__main__":
    match sys.argv[1:]:
        case ["--list", file]:
            listed(Path(file))
        case ["--keys" | "--only-keys" as what, file]:
            made(Path(file), what == "--keys")
        case _:
            main()
