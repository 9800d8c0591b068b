"""Hostile arguments to every public verb and command: is every answer a result or a sentence?

    python benchmarks/fuzz.py [--calls 20000] [--seed 1] [--seconds 10] [--only NAME ...]

The calls begin from a valid one (`tests/valid_calls.py`), in which one or two arguments are replaced
(`tests/hostile_calls.py`); the verbs take turns. With STRAINWAVE_JIT=0 all runs as Python, and what takes long is
not told from what hangs. The same arguments of a command are run once. It prints a line for every call without a
result or a sentence and for every slow one, and the memory after each tenth of the calls. What is slow as Python is
called again with compiled kernels, and is late where it is slow there too.
"""

import argparse
import ctypes
import gc
import os
import subprocess
import sys
import time
from collections import Counter
from contextlib import chdir
from pathlib import Path
from tempfile import TemporaryDirectory

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "tests"))

from hostile_calls import answer, hostile_call
from hostile_commands import VALID, answer_of, hostile_command
from valid_calls import CALLS

from strainwave.compile.tree import shown


def resident():
    """Memory of this process [MB], without what its allocator keeps of memory that was freed."""
    gc.collect()
    ctypes.CDLL(None).malloc_trim(0)
    return int(Path("/proc/self/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE") / 1e6


def is_slow(name, seed, i):
    """Whether call i of a verb is slow with compiled kernels too; what it needs is compiled in a call before."""
    command = [sys.executable, Path(__file__).resolve(), "--only", name, "--seed", seed, "--first", i, "--calls", "1"]
    environment = os.environ | {"STRAINWAVE_JIT": "1"}
    for seconds in ("300", "10"):
        run = subprocess.run(
            [*map(str, command), "--seconds", seconds], env=environment, stdout=subprocess.PIPE, text=True, check=False
        )  # fmt: skip
    return "'late'" in run.stdout or not run.stdout


def main():
    """Run the calls; 1 where one of them has neither a result nor a sentence."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--calls", type=int, default=20_000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--seconds", type=float, default=10.0, help="of the processor, that a call may take")
    parser.add_argument("--only", nargs="*", default=[])
    parser.add_argument("--commands", action="store_true", help="the commands in place of the verbs")
    given = parser.parse_args()
    every = VALID if given.commands else CALLS
    names = [name for name in every if not given.only or name in given.only]
    seen, taken, known = Counter(), Counter(), {}
    for i in range(given.first, given.first + given.calls):
        name = names[i % len(names)]
        seed, start = f"{given.seed} {i // len(names)}", time.process_time()
        if given.commands:
            call = " ".join(map(shown, arguments := hostile_command(name, seed)))
            if tuple(arguments) not in known:
                known[*arguments] = answer_of(arguments, given.seconds)
            kind, said = known[*arguments]
        else:
            function, arguments, spoilt = hostile_call(name, seed)
            call = f"{name}({', '.join(f'{k}={shown(v)}' for k, v in spoilt.items())})"
            kind, said = answer(function, arguments, given.seconds)
            if kind == "late" and os.environ.get("STRAINWAVE_JIT") == "0" and not is_slow(name, *seed.split()):
                kind = "slow as Python"
        taken[name] += time.process_time() - start
        seen["fault" if said else kind] += 1
        if said or kind in ("late", "slow as Python"):
            print(f"{i} {call}: {said or kind}", flush=True)
        if (made := i - given.first + 1) % max(1, given.calls // 10) == 0:
            print(f"{made} calls: {dict(seen)}, {resident():.0f} MB", flush=True)
    print(f"{given.calls} calls of {len(names)} kinds: {dict(seen)}; {len(known)} commands run; {resident():.0f} MB")
    print("longest:", ", ".join(f"{name} {t:.0f} s" for name, t in taken.most_common(12)))
    return int(seen["fault"] > 0)


if __name__ == "__main__":
    with TemporaryDirectory() as folder, chdir(folder):
        sys.exit(main())
