"""Code lines of the package: `python tools/budget.py [--check]`; `--check` fails above the ceiling.

A code line is neither blank nor comment nor docstring. JavaScript, CSS, C and templates count beside Python; minified
libraries do not. Standard library only.
"""

import ast
import io
import re
import sys
import tokenize
from pathlib import Path

CEILING = 58_300
PACKAGE = Path(__file__).resolve().parent.parent / "src" / "strainwave"
OTHERS = {".js", ".css", ".html", ".j2", ".c", ".h"}
COMMENTS = re.compile(r"/\*.*?\*/|<!--.*?-->|\{#.*?#\}|^\s*//[^\n]*", re.DOTALL | re.MULTILINE)
LAYOUT = {tokenize.NL, tokenize.NEWLINE, tokenize.INDENT, tokenize.DEDENT, tokenize.ENDMARKER, tokenize.COMMENT}
DOCUMENTED = (ast.Module, ast.ClassDef, ast.FunctionDef, ast.AsyncFunctionDef)


def lines_of(path: Path) -> int:
    """Code lines of a file."""
    text = path.read_text(encoding="utf-8")
    if path.suffix != ".py":
        return sum(bool(line.strip()) for line in COMMENTS.sub("", text).splitlines())
    nodes = [node for node in ast.walk(ast.parse(text)) if isinstance(node, DOCUMENTED)]
    begins = [node.body[0] for node in nodes if ast.get_docstring(node, clean=False) is not None]
    docstrings = {(begin.lineno, begin.col_offset) for begin in begins}
    tokens = (token for token in tokenize.generate_tokens(io.StringIO(text).readline) if token.type not in LAYOUT)
    code = (token for token in tokens if token.type != tokenize.STRING or token.start not in docstrings)
    return len({line for token in code for line in range(token.start[0], token.end[0] + 1)})


def main() -> None:
    """Print the number, or compare it."""
    files = [path for path in PACKAGE.rglob("*") if path.suffix in {".py", *OTHERS} and ".min." not in path.name]
    total = sum(map(lines_of, files))
    print(f"{total} code lines in {sum(path.suffix == '.py' for path in files)} files of Python and others")
    if "--check" in sys.argv and total > CEILING:
        sys.exit(f"the ceiling is {CEILING} code lines; take away what the new ones make needless")


if __name__ == "__main__":
    main()
