"""Hostile requests to the web app: is every answer 4xx with a sentence, and does the memory stay?

    python benchmarks/app_hostile.py [--count 10000] [--seed 1]

The app is a process of its own. The requests are of 29 kinds, their contents drawn with a fixed seed, 24 at a time. A
fifth of them comes before the memory is looked at first; 50 requests that are slow without end go beside the rest. It
needs psutil.
"""

import argparse
import asyncio
import contextlib
import json
import random
import time
from collections import Counter
from collections.abc import Callable
from typing import Any

from app import GEAR, answer, app, asked, request

AT_ONCE = 24


def hostile_request(port: int, rng: random.Random) -> tuple[str, bytes]:
    """A hostile request of a random kind: its name and bytes."""
    kind = rng.choice(list(HOSTILE))
    return kind, HOSTILE[kind](port, rng)


def posted(port: int, rng: random.Random, body: Any, path: str = "", **headers: str) -> bytes:
    """A request with a body, which is written as JSON unless it is bytes; to any path unless one is given."""
    raw = body if isinstance(body, bytes) else json.dumps(body).encode()
    return request(port, path or rng.choice(PATHS), raw, **headers)


def chunked(port: int, rng: random.Random, chunks: bytes) -> bytes:
    """A request with a body in chunks."""
    raw = posted(port, rng, b"", transfer_encoding="chunked", content_length="")
    return raw.replace(b"content-length: \r\n", b"") + chunks


def noise(rng: random.Random) -> bytes:
    """Random bytes."""
    return bytes(rng.randrange(256) for _ in range(rng.randrange(1, 200)))


def honest(rng: random.Random) -> dict[str, Any]:
    """What the app would answer, were it not for the rest of the request."""
    return {"state": {**GEAR, "values": {"load.inertia": f"{rng.uniform(0.5, 2):.4g} kg*m^2"}}}


def changed(name: str, value: str) -> dict[str, Any]:
    """A state with one changed value."""
    return {"state": {**GEAR, "values": {name: value}}, "speed": 5}


PATHS = ["/api/" + name for name in ("project", "response", "motion", "move", "jobs", "export/script")]
STRANGE_PATHS = [
    "/static/../server.py", "/static/%2e%2e/x", "/static/..%2fx", "/etc/passwd", "/%00", "/api/" + "a" * 3000,
    "/api/export/x%2f..", "//evil", "/static/%ff",
]  # fmt: skip
NAMES = ["load.inertia", "damping.ratio", "speed.from", "gear.K1", "limit.oscillation"]
VALUES = [
    "-1 kg*m^2", "nan", "inf %", "1e999 kg*m^2", "1 1", "", " ", "1 apple", "9" * 70, "0x10 kg", "\0", "\ud800",
    "1 kg*m^2" * 8,
]  # fmt: skip
PROJECTS = [
    "gear: ../../etc/passwd", "gear: {file: /etc/passwd, name: A}", "gear: {ratio: 50, law: {python: 'a.py:L'}}",
    "a: &a [*a]", "!!python/object/apply:os.system [ls]", "[" * 500, "{" * 500, "a: 1\n" * 30000, "\0", "",
    "- 1\n---\n- 2",
    "gear: CSG-40-50\nload: {inertia: 1e400 kg*m^2}", "&x " * 100, "gear: CSG-40-50\ngear: CSG-40-50",
    "%YAML 9.9\n---\na",
]  # fmt: skip
STATES = [5, None, [], "x", {"gear": 5}, {"gear": []}]
MAP = {"state": GEAR, "kind": "speed-map", "loads": [1.0] * 4000}
CHUNK = b"10000\r\n" + b" " * 65536 + b"\r\n"
LOGS = ["a.csv", "../../a.csv", "a.npz", "a.mat", "a.parquet", "a.mf4", "a.py", ""]
HOSTILE: dict[str, Callable[[int, random.Random], bytes]] = {
    "noise": lambda _, r: noise(r) + b"\r\n\r\n",
    "noise as body": lambda p, r: posted(p, r, noise(r)),
    "deep": lambda p, r: posted(p, r, r.choice([b"[", b'{"a":', b'{"state":']) * r.randrange(1000, 100000)),
    "no number": lambda p, r: posted(p, r, {**honest(r), "speed": r.choice([float("nan"), float("inf")])}),
    "huge number": lambda p, r: posted(p, r, b'{"speed": ' + b"9" * r.randrange(400, 9000) + b"}"),
    "unknown field": lambda p, r: posted(p, r, {**honest(r), "path": "/etc/passwd"}),
    "wrong type": lambda p, r: posted(p, r, {"state": r.choice(STATES)}),
    "wrong value": lambda p, r: posted(p, r, changed(r.choice(NAMES), r.choice(VALUES))),
    "wrong project": lambda p, r: posted(p, r, {"state": {"project": r.choice(PROJECTS)}, "speed": 5}),
    "file by a value": lambda p, r: posted(p, r, changed("gear.file", "/etc/passwd")),
    "no UTF-8": lambda p, r: posted(p, r, b'{"state": {"gear": "\xff\xfe\xc3\x28"}}'),
    "twice": lambda p, r: posted(p, r, b'{"state": {"gear": "CSG-40-50"}, "state": {"gear": "none"}, "state": 5}'),
    "speed": lambda p, r: posted(
        p, r, {"state": GEAR, "speed": r.choice([-1, 0, 1e6, 1e300, "5", True])}, "/api/motion"
    ),
    "many loads": lambda p, r: posted(p, r, MAP, "/api/jobs"),
    "wrong job": lambda p, r: request(
        p, "/api/jobs/" + r.choice(["0", "../x", "%00", "a" * 5000]), method=r.choice(["GET", "DELETE"])
    ),
    "wrong host": lambda p, r: posted(
        p, r, honest(r), host=r.choice(["evil.example", "127.0.0.1.evil.example", "", "a" * 3000])
    ),
    "wrong origin": lambda p, r: posted(
        p, r, honest(r), origin=r.choice(["http://evil.example", "null", "http://[", "x"])
    ),
    "wrong site": lambda p, r: posted(p, r, honest(r), sec_fetch_site="cross-site"),
    "wrong method": lambda p, r: request(
        p, r.choice(PATHS), method=r.choice(["GET", "PUT", "PATCH", "DELETE", "TRACE", "OPTIONS", "BREW"])
    ),
    "wrong path": lambda p, r: request(p, r.choice(STRANGE_PATHS), method="GET"),
    "large by its length": lambda p, r: posted(p, r, b"x", content_length=str(r.choice([2**21, 2**40, 10**30]))),
    "large": lambda p, r: posted(p, r, b" " * (1024 * 1024 + 1 + r.randrange(1000))),
    "large in chunks": lambda p, r: chunked(p, r, CHUNK * 18 + b"0\r\n\r\n"),
    "broken chunks": lambda p, r: chunked(p, r, b"zz\r\n"),
    "large head": lambda p, r: posted(p, r, b"", x_large="a" * 70000),
    "bad length": lambda p, r: posted(p, r, b"", content_length=r.choice(["-1", "x", "1.5", "\xb2"])),
    "log": lambda p, r: posted(p, r, noise(r), "/api/log?name=" + r.choice(LOGS)),
}


async def slow(port: int, head: bool) -> tuple[str, str]:
    """A request that never comes to its end: what is wrong with the answer, or nothing."""
    reader, writer = await asyncio.open_connection("127.0.0.1", port)
    raw = request(port, "/api/project", b"", content_length="1000")
    writer.write(raw[:20] if head else raw)
    waited = asyncio.create_task(answer(reader))
    with contextlib.suppress(ConnectionError):
        for byte in b"x" * 60:
            if waited.done():
                break
            writer.write(bytes([byte]))
            await asyncio.sleep(0.5)
    status, _, content = await waited
    writer.close()
    return f"slow {'head' if head else 'body'}", judged(status, content)


def judged(status: int, content: bytes) -> str:
    """What is wrong with the answer to a hostile request; nothing where it is 4xx with a sentence."""
    try:
        said = json.loads(content)["error"]
    except (ValueError, KeyError, TypeError):
        return f"{status} without a sentence: {content[:100]!r}"
    good = 400 <= status < 500 and isinstance(said, str) and said and "Traceback" not in said and "\n" not in said
    return "" if good else f"{status} {said[:200]!r}"


def memory(pid: int) -> tuple[float, float]:
    """Resident memory [MiB] of the server and of the processes that it has started."""
    import psutil

    server = psutil.Process(pid)
    return server.memory_info().rss / 2**20, sum(child.memory_info().rss for child in server.children()) / 2**20


async def hostile(port: int, pid: int, count: int, seed: int) -> None:
    """Print how the app answers hostile requests, and its memory before and after."""
    rng, wrong, kinds = random.Random(seed), Counter[str](), Counter[str]()
    gate = asyncio.Semaphore(AT_ONCE)

    async def one(kind: str, raw: bytes) -> None:
        async with gate:
            try:
                status, _, content = await asked(port, raw)
                fault = judged(status, content)
            except Exception as error:
                fault = f"no answer ({type(error).__name__})"
        kinds[kind] += 1
        if fault:
            wrong[f"{kind}: {fault}"] += 1

    async def many(number: int) -> None:
        for start in range(0, number, 500):
            await asyncio.gather(*(one(*hostile_request(port, rng)) for _ in range(min(500, number - start))))

    curve = request(port, "/api/response", json.dumps({"state": GEAR}).encode())
    await asyncio.gather(*(asked(port, curve) for _ in range(4)))
    await many(count // 5)
    before = memory(pid)
    slow_ones = [asyncio.create_task(slow(port, i % 2 == 0)) for i in range(50)]
    begun = time.monotonic()
    await many(count - count // 5 - len(slow_ones))
    for kind, fault in await asyncio.gather(*slow_ones):
        kinds[kind] += 1
        if fault:
            wrong[f"{kind}: {fault}"] += 1
    after = memory(pid)
    print(f"{sum(kinds.values())} hostile requests of {len(kinds)} kinds, {sum(wrong.values())} answers are wrong")
    print(f"  memory of the server {before[0]:.1f} -> {after[0]:.1f} MiB")
    print(f"  memory of its processes {before[1]:.0f} -> {after[1]:.0f} MiB")
    print(f"  {time.monotonic() - begun:.0f} s for the last four fifths")
    for what, times in wrong.most_common(20):
        print(f"  {times} x {what}")
    status, _, _ = await asked(port, curve)
    print(f"  an honest request afterwards: {status}")


def main() -> None:
    """Start the app and send it hostile requests."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--count", type=int, default=10_000)
    parser.add_argument("--seed", type=int, default=1)
    given = parser.parse_args()
    with app() as (process, port):
        asyncio.run(hostile(port, process.pid, given.count, given.seed))


if __name__ == "__main__":
    main()
