"""SIGKILL at random moments of `strainwave analyze -o` and `strainwave sweep`: nothing half-written, nothing lost.

    python benchmarks/kills.py [kills] [seed]

A quarter of the kills hit `analyze` into a folder that holds an older report, a quarter `analyze --compare` of two
drives into one that holds an older comparison: afterwards every file there must be, byte for byte, an older or a new
one. The other half hit a sweep that is started again in the same store: the
number of finished chunks must never fall, and the store that is complete at last must be, byte for byte, that of a
sweep that nothing disturbed.
"""

import random
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import zarr

ROOT = Path(__file__).parent.parent
PROJECT = ROOT / "examples" / "projects" / "article.yaml"
COMMAND = [sys.executable, "-m", "strainwave"]
GRID = ["--grid", "omega=10:60:100", "--chunk", "2", "--settle", "20", "--periods", "2"]
QUIET = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}


def contents(folder):
    """Files of a folder by their names; drafts, which begin with a dot, are left out."""
    return {
        str(path.relative_to(folder)): path.read_bytes()
        for path in folder.rglob("*")
        if path.is_file() and not any(part.startswith(".") for part in path.relative_to(folder).parts)
    }


def run(call):
    """Run a command to its end; its seconds."""
    started = time.monotonic()
    subprocess.run([*COMMAND, *map(str, call)], check=True, **QUIET)
    return time.monotonic() - started


def killed(call, after):
    """Run a command and kill it after so many seconds; whether it was still running."""
    process = subprocess.Popen([*COMMAND, *map(str, call)], **QUIET)
    try:
        process.wait(after)
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait()
        return True
    assert process.returncode == 0, process.returncode
    return False


def reports(home, kills, rng, drives, *options):
    """Kill `analyze` of so many drives; how many kills hit, and how many left new files beside old ones."""
    text, commands = PROJECT.read_text(encoding="utf-8"), []
    for age, end in (("older", ""), ("newer", "limit: {oscillation: 60 arcsec}\n")):
        paths = [home / age / f"drive-{i}.yaml" for i in range(drives)]
        for path in paths:
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(text.rstrip("\n") + "\n" + end, encoding="utf-8")
        commands.append(["analyze", *paths, *options, "-o"])
    older, newer = commands
    run([*newer, home / "new"])  # compiles
    took = run([*newer, home / "new"])
    run([*older, home / "out"])
    old, new = contents(home / "out"), contents(home / "new")
    hits, mixed = 0, 0
    while hits < kills:
        hits += killed([*newer, home / "out"], rng.uniform(0.0, 1.05 * took))
        now = contents(home / "out")
        wrong = [name for name, bytes_ in now.items() if bytes_ not in (old.get(name), new.get(name))]
        assert not wrong, wrong
        assert set(old) <= set(now)
        mixed += now not in (old, new)
        print(f"analyze of {drives}: {hits} of {kills} kills", flush=True)
        if now == new:
            run([*older, home / "out"])
    run([*newer, home / "out"])
    assert {name: contents(home / "out")[name] for name in new} == new
    return hits, mixed


def sweeps(home, kills, rng):
    """Kill `sweep`; how many kills hit, and how many stores were completed."""
    took = run(["sweep", PROJECT, *GRID, "-o", home / "quiet"])
    quiet, hits, stores, done = contents(home / "quiet"), 0, 0, 0
    while hits < kills or done:
        store = home / f"store-{stores}"
        hit = hits < kills and killed(["sweep", PROJECT, *GRID, "-o", store], rng.uniform(0.0, 1.2 * took))
        hits += hit
        if not hit:
            run(["sweep", PROJECT, *GRID, "-o", store])  # does nothing where the last one came to its end
            assert contents(store) == quiet
            print(f"sweep: {hits} of {kills} kills, {stores + 1} stores complete", flush=True)
            stores, done = stores + 1, 0
        elif (store / "done").exists():
            before, done = done, int(zarr.open_array(store / "done", mode="r")[:].sum())
            assert done >= before, (done, before)
    return hits, stores


def main():
    """Say what the kills did."""
    given = [int(text) for text in sys.argv[1:]]
    kills, seed = (*given, *(100, 0)[len(given) :])
    rng = random.Random(seed)
    with tempfile.TemporaryDirectory() as folder:
        hits, stores = sweeps(Path(folder), kills - kills // 2, rng)
        print(f"{hits} kills of sweep: no chunk lost; {stores} stores completed, byte for byte those of a quiet run")
        for drives, options in ((1, ()), (2, ("--compare",))):
            hits, mixed = reports(Path(folder) / str(drives), kills // 4, rng, drives, *options)
            said = " ".join(["analyze", *options])
            print(f"{hits} kills of {said}: every file whole, {mixed} times new ones beside old ones")


if __name__ == "__main__":
    main()
