"""The budget counts code as its page says, and is only lowered."""

import ast
import tomllib
from collections import Counter
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path

import pytest

TOOL = Path(__file__).resolve().parent.parent / "tools" / "budget.py"
MODULE = '''"""Docstring."""

from importlib import import_module
from ...second.other import one  # a comment
from ... import plain


def twice(x: float) -> float:
    """Docstring of
    two lines.
    """
    # a comment
    text = """in
    code"""

    return import_module("small.plain").f(x, text, one, plain)
'''
SCRIPT = "/* two\nlines */\n\nlet a = 1; // said\n// said\nlet b = 'http://c';\n"


@pytest.fixture(scope="module")
def budget():
    spec = spec_from_file_location("budget", TOOL)
    module = module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.fixture
def package(tmp_path):
    texts = {
        "__init__.py": "", "plain.py": "def f(x, *_):\n    return x\n", "first/deep/use.py": MODULE,
        "second/__init__.py": "", "second/other.py": "one = 1\n",
        "second/page.js": SCRIPT, "second/page.min.js": SCRIPT,
    }  # fmt: skip
    for name, text in texts.items():
        path = tmp_path / "small" / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")
    return tmp_path / "small"


def test_code_lines_rooms_arrows_and_imports_by_string_are_counted(budget, package):
    now = budget.measured(package)
    assert now["rooms"] == {"top": 2, "first": 7, "second": 3}
    assert now["size"]["code_lines"] == 12
    assert now["counts"] == {
        "lines_over_100": 0, "imports_by_string": 1, "files": 5, "rooms_of_second_level": 3, "arrows_between_them": 2,
        "longest_function": 4, "median_function": 2, "percent_of_parameters_any": 0,
    }  # fmt: skip


def test_what_plain_code_has_not_is_counted(budget):
    text = """def f(x: Any, at, b):
    first, second = (g(y) for y in x)
    found = first + (b > 2)



    return found, at, not b, 3 * (not b)
"""
    assert Counter(budget.style(list(ast.walk(ast.parse(text))))) == {
        "function_words": 1, "unpacked_generators": 1, "arithmetic_on_booleans": 2, "parameters": 3,
        "parameters_any": 1,
    }  # fmt: skip


def test_what_is_above_its_budget_is_named_with_the_remedy(budget, package):
    now = budget.measured(package)
    assert budget.exceeded(now, now) == []
    (sentence,) = budget.exceeded(now, now | {"rooms": {"top": 2, "first": 6, "second": 3}})
    assert sentence.startswith("first: 7 code lines, the budget is 6; shorten it, or raise the budget in a commit of")


def test_a_budget_is_lowered_and_never_raised(budget, package):
    now = budget.measured(package)
    former = now | {"rooms": {"top": 9, "first": 6, "gone": 5}}
    rooms = tomllib.loads(budget.lowered(now, former))["rooms"]
    assert rooms == {"top": 2, "first": 6, "second": 3}
