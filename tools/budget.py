"""Size of the package against `tools/budget.toml`: `python tools/budget.py [--check | --write]`.

A code line is neither blank nor comment nor docstring. JavaScript, CSS, C and templates count beside Python; minified
libraries do not. A room is a folder of the package, or "top" for the modules beside them. Without an option all numbers
are printed; `--check` fails when a room or a count is above its budget; `--write` lowers budgets to what is there.
Standard library only.
"""

import ast
import io
import re
import statistics
import sys
import tokenize
import tomllib
from collections import Counter
from collections.abc import Iterator, Mapping
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
PACKAGE = ROOT / "src" / "strainwave"
BUDGET = Path(__file__).with_suffix(".toml")
OTHERS = {".js", ".css", ".html", ".j2", ".c", ".h"}
COMMENTS = re.compile(r"/\*.*?\*/|<!--.*?-->|\{#.*?#\}|^\s*//[^\n]*", re.DOTALL | re.MULTILINE)
LAYOUT = {tokenize.NL, tokenize.NEWLINE, tokenize.INDENT, tokenize.DEDENT, tokenize.ENDMARKER, tokenize.COMMENT}
KINDS = (ast.Module, ast.ClassDef, ast.FunctionDef, ast.AsyncFunctionDef)
BY_STRING_HERE = "base/above.py"  # the file that may import by string
SCOPE = 5  # lines over which a name may be a function word
WORDS = """
found said told own here rest near at way out given known kept seen taken wanted used made done shown asked there every
one each some any all both other others what which who why how when where now then also even more many much few enough
of to from with without by in on off over under above below beyond beside this that these those thus so as if but and
or not only just such them they it its again once still
"""
HEAD = """# Largest sizes of the package, which `python tools/budget.py --check` holds and `--write` lowers.
# Rooms have code lines. What is under `size` is compared, and fails nothing.

"""


def tokens(text: str, nodes: list[ast.AST]) -> list[tokenize.TokenInfo]:
    """Tokens without layout, comments and docstrings."""
    documented = [n.body[0] for n in nodes if isinstance(n, KINDS) and ast.get_docstring(n, clean=False) is not None]
    docstrings = {(text.lineno, text.col_offset) for text in documented}
    every = tokenize.generate_tokens(io.StringIO(text).readline)
    return [t for t in every if t.type not in LAYOUT and not (t.type == tokenize.STRING and t.start in docstrings)]


def other_lines(text: str) -> int:
    """Code lines of another language."""
    return sum(1 for line in COMMENTS.sub("", text).splitlines() if line.strip())


def room_of(path: Path, package: Path, depth: int) -> str:
    """Folder of a file down to a depth; of the modules at the top, "top"."""
    return "/".join(path.relative_to(package).parts[:-1][:depth]) or "top"


def quarter_of(path: Path, package: Path) -> str:
    """Room of the second level; a module at the top is one of its own."""
    room = room_of(path, package, 2)
    return path.stem if room == "top" else room


def imported(path: Path, nodes: list[ast.AST], package: Path, files: set[Path]) -> Iterator[Path]:
    """Files of the package that a file imports."""
    for node in nodes:
        if isinstance(node, ast.Import):
            names = [alias.name.split(".") for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            home = path.relative_to(package.parent).parts[: -node.level] if node.level else ()
            begin = [*home, *(node.module.split(".") if node.module else ())]
            names = [[*begin, alias.name] for alias in node.names]
        else:
            continue
        for name in names:
            place = package.parent.joinpath(*name)
            homes = [end for at in (place, place.parent) for end in (at.with_suffix(".py"), at / "__init__.py")]
            yield from [file for file in homes if file in files][:1]


def by_string(nodes: list[ast.AST], package: Path) -> int:
    """Calls of `import_module` with a text that names the package."""
    calls = [n for n in nodes if isinstance(n, ast.Call) and n.args]
    named = [c.args[0] for c in calls if ast.unparse(c.func).endswith("import_module")]
    begins = [a.values[0] if isinstance(a, ast.JoinedStr) and a.values else a for a in named]
    texts = [b.value for b in begins if isinstance(b, ast.Constant) and isinstance(b.value, str)]
    return sum(text.startswith((".", package.name)) for text in texts)


def style(nodes: list[ast.AST]) -> Iterator[str]:
    """What plain code has not, each time by its name, and parameters, of which few are `Any`."""
    for node in nodes:
        match node:
            case ast.FunctionDef() | ast.AsyncFunctionDef():
                yield from function_words(node)
                for argument in (*node.args.posonlyargs, *node.args.args, *node.args.kwonlyargs):
                    yield "parameters"
                    if isinstance(argument.annotation, ast.Name) and argument.annotation.id == "Any":
                        yield "parameters_any"
            case ast.Assign(targets=[ast.Tuple()], value=ast.GeneratorExp()):
                yield "unpacked_generators"
            case ast.BinOp(op=ast.Add() | ast.Sub() | ast.Mult(), left=left, right=right):
                if any(isinstance(n, ast.Compare) or isinstance(getattr(n, "op", 0), ast.Not) for n in (left, right)):
                    yield "arithmetic_on_booleans"


def function_words(function: ast.FunctionDef | ast.AsyncFunctionDef) -> Iterator[str]:
    """One for each name of a function that is a function word, over more than SCOPE lines."""
    lines: dict[str, list[int]] = {}
    for node in ast.walk(function):
        name = node.id if isinstance(node, ast.Name) else node.arg if isinstance(node, ast.arg) else None
        if name in WORDS.split():
            lines.setdefault(name, []).append(node.lineno)
    for places in lines.values():
        if max(places) - min(places) > SCOPE:
            yield "function_words"


def measured(package: Path = PACKAGE) -> dict[str, dict[str, int]]:
    """Numbers of the package: code lines of rooms, counts, and size in other units."""
    rooms, counts, size = Counter[str](), Counter[str](), Counter[str]()
    functions, arrows, files = [], set(), set(package.rglob("*.py"))
    for path in files:
        text = path.read_text(encoding="utf-8")
        nodes = list(ast.walk(ast.parse(text)))
        found = tokens(text, nodes)
        lines = {line for token in found for line in range(token.start[0], token.end[0] + 1)}
        rooms[room_of(path, package, 1)] += len(lines)
        counts["lines_over_100"] += sum(len(line) > 100 for i, line in enumerate(text.splitlines(), 1) if i in lines)
        counts["imports_by_string"] += by_string(nodes, package) * (path != package / BY_STRING_HERE)
        counts.update(style(nodes))
        size.update(tokens=len(found), ast_nodes=len(nodes))
        own = quarter_of(path, package)
        arrows |= {(own, quarter_of(file, package)) for file in imported(path, nodes, package, files)} - {(own, own)}
        for node in nodes:
            if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
                body = node.body[1:] if ast.get_docstring(node, clean=False) is not None else node.body
                functions.append((node.end_lineno or 0) - body[0].lineno + 1 if body else 0)
    for path in package.rglob("*"):
        if path.suffix in OTHERS and ".min." not in path.name:
            rooms[room_of(path, package, 1)] += other_lines(path.read_text(encoding="utf-8"))
    quarters = {quarter_of(path, package) for path in files} - {"__init__"}
    counts.update(files=len(files), rooms_of_second_level=len(quarters), arrows_between_them=len(arrows))
    every, untyped = counts.pop("parameters", 0), counts.pop("parameters_any", 0)
    counts.update(percent_of_parameters_any=round(100 * untyped / max(every, 1)))
    counts.update(longest_function=max(functions), median_function=int(statistics.median(functions)))
    return {"rooms": {**rooms}, "counts": {**counts}, "size": {"code_lines": rooms.total(), **size}}


def exceeded(now: Mapping[str, Mapping[str, int]], budget: Mapping[str, Mapping[str, int]]) -> list[str]:
    """Return a sentence for each room and each count above its budget."""
    return [
        f"{name}: {value}{' code lines' if table == 'rooms' else ''}, the budget is {budget[table].get(name, 0)}; "
        "shorten it, or raise the budget in a commit of its own that says why"
        for table in ("rooms", "counts")
        for name, value in now[table].items()
        if value > budget[table].get(name, 0)
    ]


def lowered(now: Mapping[str, Mapping[str, int]], budget: Mapping[str, Mapping[str, int]]) -> str:
    """Return the text of a budget that is nowhere above the former one; a room that is gone has none."""
    tables = {
        table: {name: min(value, budget.get(table, {}).get(name, value)) for name, value in sorted(values.items())}
        for table, values in now.items()
    }
    text = [f"[{table}]\n" + "".join(f"{k} = {v}\n" for k, v in values.items()) for table, values in tables.items()]
    return HEAD + "\n".join(text)


def main() -> None:
    """Print, check or lower the budget."""
    now, budget = measured(), tomllib.loads(BUDGET.read_text(encoding="utf-8"))
    if sys.argv[1:] == ["--write"]:
        BUDGET.write_text(lowered(now, budget), encoding="utf-8")
    elif sys.argv[1:] == ["--check"]:
        sys.exit("\n".join(exceeded(now, budget)) or 0)
    else:
        for table, values in now.items():
            for name, value in sorted(values.items()):
                print(f"{table:7} {name:24} {value:8} of {budget.get(table, {}).get(name, 0):8}")


if __name__ == "__main__":
    main()
