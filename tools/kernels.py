"""Make the LLVM code of kernels for a release: `python tools/kernels.py` writes build/kernels.xz.

It is what `demo` compiles and what `analyze` does for drives of the README, tests and benchmarks: the code of each
kernel before LLVM's passes, which every machine runs for its own processor. The first line says what it was made of.
"""

import lzma
import os
import pickle
import runpy
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / "tests"))
sys.path.insert(0, str(ROOT / "benchmarks"))
README = ROOT / "benchmarks" / "readme_drive.yaml"
KERNELS = ROOT / "build" / "kernels.xz"


def keep(folder: Path) -> None:
    """Write every kernel that this process compiles into a folder too."""
    from llvmlite import binding
    from numba.core import ir
    from numba.core.codegen import JITCodeLibrary
    from numba.core.registry import cpu_target

    from strainwave.compile import cache

    cache.is_empty = lambda: False  # no other process makes any
    optimize, make = JITCodeLibrary._optimize_final_module, cache.CodeCache.made
    locate = ir.Loc.__init__

    def located(self: Any, filename: str, *more: Any, **named: Any) -> None:
        locate(self, filename.rpartition("site-packages/")[2], *more, **named)  # the same wherever they are made

    def optimized(self: Any) -> None:
        self.plain = self._final_module.as_bitcode()
        optimize(self)

    def without_names(code: bytes) -> bytes:
        module, machine = binding.parse_bitcode(code), cpu_target.target_context.codegen()._tm
        passes = binding.create_pass_builder(machine, binding.create_pipeline_tuning_options(speed_level=0))
        manager = binding.create_new_module_pass_manager()
        manager.add_strip_symbols_pass()
        manager.run(module, passes)
        return bytes(module.as_bitcode())

    def made(self: Any, compile_: Any, kinds: Any, *result: Any) -> Any:
        code = make(self, compile_, kinds, *result)
        classes, path, name = self.location(kinds, code.codegen)
        if path is not None and path.is_file():
            library = code.library.name, without_names(code.library.plain)
            cache.write(folder / name, classes, (library, *cache.parts_of(code)[1:]))
        return code

    JITCodeLibrary._optimize_final_module, cache.CodeCache.made = optimized, made
    ir.Loc.__init__ = located


def run(folder: Path, *arguments: str) -> None:
    """Run the command line in a process that keeps what it compiles."""
    subprocess.run([sys.executable, __file__, "--keep", str(folder), *arguments], check=True, cwd=folder.parent)


def main() -> None:
    """Make them."""
    from first_answer import CASCADE, COUPLED, ELBOW, FILTERS, HYSTERESIS
    from numba.core.registry import cpu_target
    from twelve_projects import PROJECTS

    from strainwave.compile import cache

    drives = [*PROJECTS.values(), ELBOW + HYSTERESIS, COUPLED, CASCADE.replace("FILTERS", FILTERS)]
    with tempfile.TemporaryDirectory() as name:
        top = Path(name)
        os.environ["STRAINWAVE_CACHE_DIR"] = str(top / "cache")
        (top / "kernels").mkdir()
        run(top / "kernels", "demo")
        for i, text in enumerate([README.read_text(encoding="utf-8"), *drives]):
            (top / f"{i}.yaml").write_text(text, encoding="utf-8")
            run(top / "kernels", "analyze", f"{i}.yaml", "-o", str(i))
        kernels = {path.name: path.read_bytes()[cache.DIGEST :] for path in sorted((top / "kernels").iterdir())}
    filters = [{"id": lzma.FILTER_LZMA2, "preset": 9 | lzma.PRESET_EXTREME, "lc": 4, "pb": 0}]
    packed = lzma.compress(pickle.dumps(kernels, protocol=4), filters=filters)
    mark = cache.stamp(cpu_target.target_context.codegen().magic_tuple()[0])
    KERNELS.parent.mkdir(exist_ok=True)
    KERNELS.write_bytes(mark.encode() + b"\n" + packed)


if __name__ == "__main__":
    if "--keep" in sys.argv:
        place = sys.argv.index("--keep")
        keep(Path(sys.argv[place + 1]))
        sys.argv[1:] = sys.argv[place + 2 :]
        runpy.run_module("strainwave", run_name="__main__")
    else:
        main()
