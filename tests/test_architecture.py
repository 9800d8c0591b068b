"""The house rules: sizes, layers, start-up and documented public names."""

import ast
import inspect
import subprocess
import sys
from operator import attrgetter
from pathlib import Path

import pytest
from public_names import PUBLIC

import strainwave
from strainwave.base.above import HOMES, NAMESPACES, above, listed_in, namespaces

ROOT = Path(__file__).resolve().parent.parent
SOURCES = sorted((ROOT / "src").rglob("*.py"))
HEAVY = {"numba", "scipy", "xarray", "zarr", "pint", "matplotlib", "dask", "sympy"}


def name_of(path: Path) -> str:
    return path.relative_to(ROOT / "src").as_posix()


def body_lines(function: ast.FunctionDef | ast.AsyncFunctionDef) -> int:
    """Lines from the first statement after the docstring to the end."""
    body = function.body[1:] if ast.get_docstring(function, clean=False) is not None else function.body
    return function.end_lineno - body[0].lineno + 1 if body else 0


def functions_of(path: Path) -> list[ast.FunctionDef | ast.AsyncFunctionDef]:
    nodes = ast.walk(ast.parse(path.read_text(encoding="utf-8")))
    return [node for node in nodes if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef)]


def test_files_have_at_most_400_lines():
    lines = {name_of(path): len(path.read_text(encoding="utf-8").splitlines()) for path in SOURCES}
    assert len(lines) > 300
    assert {name: count for name, count in lines.items() if count > 400} == {}


def test_functions_have_at_most_60_lines():
    lines = [(name_of(path), f.name, body_lines(f)) for path in SOURCES for f in functions_of(path)]
    assert len(lines) > 2000
    assert [function for function in lines if function[2] > 60] == []


def test_folders_have_at_most_16_files_and_13_folders():
    def counts(folder: Path) -> tuple[int, int]:
        folders = [child for child in folder.iterdir() if child.is_dir() and any(child.glob("*.py"))]
        return len(list(folder.glob("*.py"))), len(folders)

    crowded = {name_of(folder): counts(folder) for folder in {path.parent for path in SOURCES}}
    assert {name: (files, folders) for name, (files, folders) in crowded.items() if files > 16 or folders > 13} == {}


def test_at_most_120_names_stand_at_the_top_and_each_is_listed_once():
    names = [name for name, _ in listed_in(ROOT / "src/strainwave/__init__.pyi")]
    assert sorted(names) == sorted(set(strainwave.__all__))
    assert len(names) <= 120


@pytest.mark.parametrize("space", NAMESPACES)
def test_a_namespace_loads_each_of_its_names(space):
    home = getattr(strainwave, space)
    names = namespaces()
    assert home.__doc__
    listed = [name for name in dir(home) if name in names]
    assert listed
    assert [name for name in listed if getattr(home, name, None) is None] == []
    with pytest.raises(AttributeError, match="nothing"):
        attrgetter("nothing")(home)


@pytest.mark.parametrize("space", [space for space in NAMESPACES if hasattr(getattr(strainwave, space), "__path__")])
def test_no_module_of_a_namespace_has_the_name_of_one_of_its_functions(space):
    """Importing such a module would put it in the place of the function."""
    home = getattr(strainwave, space)
    modules = {path.stem for path in Path(home.__path__[0]).iterdir()} - {"catalogue"}
    assert modules & {name for name, place in namespaces().items() if place == space} == set()


@pytest.mark.parametrize(
    ("wrong", "place"),
    [("Coulomb", "laws.Coulomb"), ("freq_response", "frequency_response"), ("exceedence", "exceedance")],
)
def test_a_name_that_is_not_there_says_the_nearest(wrong, place):
    for home, name in ((strainwave, "strainwave"), (strainwave.results, "strainwave.results")):
        said = rf"^{name} has no name '{wrong}'; dir\({name}\) lists what it has; did you mean strainwave\.{place}\?$"
        with pytest.raises(AttributeError, match=said):
            getattr(home, wrong)
    with pytest.raises(AttributeError, match=r"lists what it has$"):
        attrgetter("qwertz")(strainwave)


@pytest.mark.parametrize("module", ["strainwave", "strainwave.app.commands.cli", "strainwave.app"])
def test_import_leaves_the_heavy_libraries_alone(module):
    code = f"import sys, {module}; print(*sorted({HEAVY} & set(sys.modules)))"
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert run.returncode == 0, run.stderr
    assert run.stdout.split() == []


def test_all_names_can_be_imported_without_the_extras_and_what_needs_one_says_which():
    code = (
        "import sys; sys.modules.update(dict.fromkeys(['sympy', 'matplotlib', 'jinja2', 'distributed', 'dask']))\n"
        "from strainwave import *\n"
        "try: theory.derive()\n"
        "except ModuleNotFoundError as error: print(error, HDC_40_050.N)"
    )
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False)
    assert run.returncode == 0, run.stderr
    assert run.stdout.split(" which")[0] == "the derivation needs SymPy,"
    assert run.stdout.endswith("pip install 'strainwave[sym]' 50.0\n")


def own_docstring(thing) -> str:
    """The docstring somebody wrote: not an inherited one, nor the signature that the class builders put there."""
    if not inspect.isclass(thing):
        return inspect.getdoc(thing) or ""
    written = vars(thing).get("__doc__") or ""
    return "" if written.startswith(f"{thing.__name__}(") else written


def test_public_names_have_docstrings():
    assert len(PUBLIC) > 300
    assert [name for name in PUBLIC if not own_docstring(attrgetter(name)(strainwave)).strip()] == []


def test_public_functions_have_at_most_8_parameters_beside_options_with_defaults():
    functions = {name: attrgetter(name)(strainwave) for name in PUBLIC}
    for function in filter(inspect.isfunction, functions.values()):
        parameters = inspect.signature(function).parameters.values()
        options = [p for p in parameters if p.kind is p.KEYWORD_ONLY and p.default is not p.empty]
        assert len(parameters) - len(options) <= 8, function.__name__


def test_what_guard_txt_names_is_there_and_slow():
    lines = (ROOT / "tests/guard.txt").read_text(encoding="utf-8").splitlines()
    named = [line.partition("[")[0].split("::") for line in lines if line[:1] != "#"]
    assert len(named) > 20
    for file, *name in named:
        text = (ROOT / "tests" / file).read_text(encoding="utf-8")
        assert "pytest.mark.slow" in text, file
        assert all(f"def {one}(" in text for one in name), (file, name)


def test_what_is_named_as_a_string_is_there():
    for name in HOMES:
        assert callable(above(name))
