"""Hostile arguments to every command: is every answer a result or a sentence?

    python benchmarks/fuzz.py [--calls 20000] [--seed 1] [--seconds 10] [--only NAME ...]

The calls begin from a valid one, in which one or two arguments are replaced (`tests/hostile_commands.py`); the commands
take turns. With STRAINWAVE_JIT=0 all runs as Python, and what takes long is not told from what hangs. The same
arguments are run once. It prints a line for every call without a result or a sentence and for every slow one, and the
memory after each tenth of the calls.
"""

import argparse
import ctypes
import gc
import os
import sys
import time
from collections import Counter
from contextlib import chdir
from pathlib import Path
from tempfile import TemporaryDirectory

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "tests"))

from hostile_commands import VALID, answer_of, hostile_command

from strainwave.compile.tree import shown


def resident():
    """Memory of this process [MB], without what its allocator keeps of memory that was freed."""
    gc.collect()
    ctypes.CDLL(None).malloc_trim(0)
    return int(Path("/proc/self/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE") / 1e6


def main():
    """Run the calls; 1 where one of them has neither a result nor a sentence."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--calls", type=int, default=20_000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--seconds", type=float, default=10.0, help="of the processor, that a call may take")
    parser.add_argument("--only", nargs="*", default=[])
    given = parser.parse_args()
    names = [name for name in VALID if not given.only or name in given.only]
    seen, taken, known = Counter(), Counter(), {}
    for i in range(given.calls):
        name = names[i % len(names)]
        seed, start = f"{given.seed} {i // len(names)}", time.process_time()
        call = " ".join(map(shown, arguments := hostile_command(name, seed)))
        if tuple(arguments) not in known:
            known[*arguments] = answer_of(arguments, given.seconds)
        kind, said = known[*arguments]
        taken[name] += time.process_time() - start
        seen["fault" if said else kind] += 1
        if said or kind == "late":
            print(f"{i} {call}: {said or kind}", flush=True)
        if (made := i + 1) % max(1, given.calls // 10) == 0:
            print(f"{made} calls: {dict(seen)}, {resident():.0f} MB", flush=True)
    print(f"{given.calls} calls of {len(names)} commands: {dict(seen)}; {len(known)} run; {resident():.0f} MB")
    print("longest:", ", ".join(f"{name} {t:.0f} s" for name, t in taken.most_common(12)))
    return int(seen["fault"] > 0)


if __name__ == "__main__":
    with TemporaryDirectory() as folder, chdir(folder):
        sys.exit(main())
