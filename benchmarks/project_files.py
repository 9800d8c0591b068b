"""Spoilt project files through `strainwave analyze --check`: a sentence for each, never a traceback.

    python benchmarks/project_files.py [number] [first seed] [processes]

Runs `number` files in this process and `processes` of them as real processes too. A refusal is sound if the exit code
is 3 and every line is `file:line:column: field: sentence` with a remedy after a semicolon or a comma.
"""

import subprocess
import sys
import tempfile
import time
from collections import Counter
from pathlib import Path

from click.testing import CliRunner

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "tests"))

from mutated_projects import fault, mutated

from strainwave.app.commands.cli import cli


def main(number=10_000, first=0, processes=300):
    seen, slow, begin = Counter(), 0.0, time.process_time()
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "drive.yaml"
        for seed in range(first, first + number):
            path.write_bytes(mutated(seed))
            before = time.process_time()
            run = CliRunner().invoke(cli, ["analyze", str(path), "--check"])
            slow = max(slow, time.process_time() - before)
            said = fault(run.exit_code, run.output.replace(folder + "/", ""))
            seen["unsound" if said else "valid" if run.exit_code == 0 else "refused"] += 1
            if said:
                print(f"{seed:6d} {said}", flush=True)
        print(f"{number} files: {dict(seen)}; {time.process_time() - begin:.0f} s of CPU time, {slow:.2f} s at most")
        unsound = 0
        for seed in range(first, first + processes):
            path.write_bytes(mutated(seed))
            command = [sys.executable, "-m", "strainwave", "analyze", str(path), "--check"]
            run = subprocess.run(command, capture_output=True, text=True, check=False)
            said = fault(run.returncode, (run.stderr + run.stdout).replace(folder + "/", ""))
            unsound += bool(said)
            if said:
                print(f"{seed:6d} as a process: {said}", flush=True)
        print(f"{processes} processes: {unsound} unsound")
    return seen["unsound"] + unsound


if __name__ == "__main__":
    sys.exit(bool(main(*(int(a) for a in sys.argv[1:]))))
