"""The server with real connections and processes: what is slow, what is left behind, what is killed, a full disk."""

import asyncio
import contextlib
import json
import math
import os
import signal
import socket
import subprocess
import sys
import threading
import time
from functools import partial

import pytest
import uvicorn
from app_work import compiled, dying, endless, faulty, full, mode, never_interpreted, pid, until_there, without_progress
from small_drive import PROJECT

from strainwave.app.commands import app as command
from strainwave.app.web import api, guard, server
from strainwave.app.web.requests import Refused, State
from strainwave.app.web.state import of_state
from strainwave.app.web.views import response
from strainwave.app.web.worker import Died, Unexpected, Worker, done
from strainwave.app.web.workers import Abandoned, Workers
from strainwave.base.results import SolveError
from strainwave.drive.train_curve import NO_MOTION

PATIENCE = 120.0  # s
GEAR = State(gear="CSG-40-50")


def gone(process):
    """Whether a process has ended."""
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return True
    return False


async def until(true, what):
    end = time.monotonic() + PATIENCE
    while not true():
        assert time.monotonic() < end, what
        await asyncio.sleep(0.02)


def run(work):
    return asyncio.run(asyncio.wait_for(work, PATIENCE))


async def told(work, *args, **options):
    """JSON that one process gives for a piece of work."""
    workers = Workers(1, **options)
    try:
        return json.loads((await workers.run(work, *args))[0])
    finally:
        await workers.close()


def test_a_process_gives_the_answer_of_this_one():
    meant = json.loads(done(of_state, (response, GEAR), {})[1][0])
    assert run(told(of_state, response, GEAR))["message"] == meant["message"]


@pytest.mark.parametrize(
    ("work", "error", "words"),
    [
        (partial(full, 100_000), Refused, "temporary file cannot be written .* make room"),
        (dying, Refused, "ended unexpectedly"),
        (faulty, Unexpected, "ZeroDivisionError"),
        (partial(of_state, response, State(gear="nowhere")), Refused, "nowhere"),
    ],
)
def test_what_goes_wrong_in_a_process_is_said(work, error, words):
    with pytest.raises(error, match=words):
        run(told(work))


def test_an_interpreted_process_answers_until_machine_code_is_ready_which_then_does_what_that_has_not_finished(
    tmp_path, monkeypatch
):
    monkeypatch.delenv("STRAINWAVE_JIT", raising=False)

    async def work():
        workers = Workers(2)
        warming = asyncio.create_task(workers.warm(until_there, tmp_path / "ready", later=0.0))
        await until(lambda: workers._all, "no process is started")
        assert json.loads((await workers.run(mode))[0]) == "0"
        asking = asyncio.create_task(workers.run(never_interpreted))
        await until(lambda: len([one for one in workers._all if not one.idle]) == 2, "the two do not work side by side")
        (tmp_path / "ready").touch()
        assert json.loads((await asking)[0]) == "1"
        await warming
        assert [one.interpreted for one in workers._all] == [False, False]
        await workers.close()

    run(work())


def test_compiling_in_a_process_is_told():
    async def work():
        workers, stages = Workers(1), []
        asking = asyncio.create_task(workers.run(compiled, progress=lambda stage, share: stages.append((stage, share))))
        await until(lambda: workers.compiling, "nothing is said of the compilation")
        said = workers.compiling
        await asking
        assert workers.compiling == ""
        await workers.close()
        return said, stages

    said, stages = run(work())
    assert said == "preparing machine code, once per machine"
    assert stages == [("begun", 0.1), (said, 0.0), ("compiled", 0.5)]


def test_work_that_takes_too_long_is_killed_and_the_next_is_done():
    async def work():
        workers = Workers(1, longest=0.5)
        with pytest.raises(Refused, match=r"longer than 0.5 s"):
            await workers.run(time.sleep, 3600.0)
        workers._longest = math.inf
        assert json.loads((await workers.run(pid))[0]) > 0
        await workers.close()

    run(work())


@pytest.mark.slow
def test_a_response_to_many_high_orders_ends_in_a_sentence():
    lines = ", ".join(f"{{order: {order}, amplitude: 0.5 arcsec}}" for order in range(837, 901))
    drive = State(project=PROJECT.replace("{order: 2, amplitude: 10 arcsec}", lines))
    with pytest.raises(Refused, match=r"longer than 1.5 s of computing.* use fewer or lower orders"):
        run(told(of_state, response, drive, longest=1.5))


def test_a_refusal_names_no_call_that_a_page_has_not():
    assert done(refused, (), {}) == ("refused", NO_MOTION.split(", drive_run")[0])


def refused():
    raise SolveError(NO_MOTION)


def test_work_that_nobody_waits_for_is_not_done():
    async def nobody():
        return False

    async def work():
        workers = Workers(1)
        with pytest.raises(Abandoned):
            await workers.run(dying, waiting=nobody)
        await workers.close()

    run(work())


def test_long_work_that_nobody_waits_for_any_more_is_killed():
    asked = []

    async def at_first():
        asked.append(len(asked))
        return len(asked) < 3

    async def work():
        workers = Workers(1, patience=0.2)
        with pytest.raises(Abandoned):
            await workers.run(time.sleep, 3600.0, waiting=at_first)
        assert json.loads((await workers.run(pid))[0]) > 0
        await workers.close()

    run(work())
    assert asked == [0, 1, 2]


def test_visitors_with_slow_answers_leave_a_process_to_the_others(monkeypatch):
    monkeypatch.setattr("strainwave.app.web.workers.SLOW_S", 0.0)  # any answer is slow
    begun = []

    async def work():
        workers = Workers(2)
        for visitor in "ab":
            await workers.run(pid, visitor=visitor)
        held = [
            asyncio.create_task(workers.run(time.sleep, 3600.0, visitor=visitor, begun=partial(begun.append, visitor)))
            for visitor in "ab"
        ]
        await until(lambda: begun, "no slow work begins")
        assert json.loads((await workers.run(pid, visitor="c"))[0]) > 0
        assert begun == ["a"]
        held[0].cancel()  # the next slow one has its turn
        await until(lambda: begun == ["a", "b"], "the second slow work does not begin")
        held[1].cancel()
        await asyncio.gather(*held, return_exceptions=True)
        await workers.close()

    run(work())


def test_processes_end_with_the_server():
    async def work():
        workers = Workers(2)
        await workers.warm(pid, later=0.0)
        found = [json.loads((await worker.ask(pid))[0]) for worker in workers._all]
        await workers.close()
        return found

    found = run(work())
    assert len(set(found)) == 2
    assert all(map(gone, found))


def test_a_process_that_was_killed_while_idle_is_replaced():
    async def work():
        workers = Workers(1)
        first = json.loads((await workers.run(pid))[0])
        os.kill(first, signal.SIGKILL)
        await until(lambda: not next(iter(workers._all)).alive, "the process lives on")
        assert json.loads((await workers.run(pid))[0]) != first
        await workers.close()

    run(work())


def test_a_process_ends_in_the_middle_of_its_work_when_the_server_has_gone():
    async def work():
        worker, begun = await Worker.start(), asyncio.Event()
        asking = asyncio.create_task(worker.ask(endless, progress=lambda *_: begun.set()))
        await begun.wait()
        worker._process.stdin.close()
        await worker.ended()
        with pytest.raises(Died):
            await asking

    run(work())


async def running(held):
    """Name of a job that never ends by itself, once it runs."""
    name = held.begin("endless", endless)
    await until(lambda: held.find(name) is None or held.find(name).share == 0.5, "the job does not begin")
    return name


def test_a_cancelled_job_stops_in_the_middle_and_the_next_one_runs():
    async def work():
        held = api.Jobs()
        name = await running(held)
        waiting = held.begin("pid", pid)
        assert held.find(waiting).state == "waiting"
        (process,) = held._workers._all
        assert held.cancel(name).state == "cancelled"
        assert held.cancel(name) is None  # from the second tab
        await process.ended()
        await until(lambda: held.find(waiting).state == "done", "the next job does not run")
        assert held.find(waiting).result > 0
        await held.close()

    run(work())


def test_job_of_a_page_that_has_gone_is_stopped():
    async def work():
        held = api.Jobs(left=1.0)
        name = await running(held)
        (process,) = held._workers._all
        await process.ended()
        assert held.find(name) is None
        await held.close()

    run(work())


def test_finished_job_is_forgotten_later():
    async def work():
        held = api.Jobs(kept=0.5)
        name = held.begin("pid", pid)
        await until(lambda: name not in held._jobs, "the job is kept for ever")
        await held.close()

    run(work())


@pytest.mark.parametrize(
    ("work", "words"), [(faulty, "unexpectedly (ZeroDivisionError)"), (partial(full, 10**5), "make room")]
)
def test_failed_job_says_why(work, words):
    async def waited():
        held = api.Jobs()
        name = held.begin("wrong", partial(without_progress, work))
        await until(lambda: held.find(name).state == "failed", "the job does not fail")
        error = held.find(name).error
        await held.close()
        return error

    assert words in run(waited())


# --- connections ------------------------------------------------------------------------------------------------------


@pytest.fixture
def port(monkeypatch):
    """Port of a server in another thread, which waits half a second for a head or a body."""
    monkeypatch.setattr(server, "PATIENCE", 0.5)
    monkeypatch.setattr(guard, "PATIENCE", 0.5)
    sock, own = server.listening(8980)
    sock.listen(8)
    served = uvicorn.Server(server.configured(server.application(warm=False)))
    thread = threading.Thread(target=served.run, kwargs={"sockets": [sock]})
    thread.start()
    yield own
    served.should_exit = True
    thread.join()


def answered(port, *parts, every=0.05):
    """Status and sentence of the answer to a request that is sent in parts."""
    with socket.create_connection(("127.0.0.1", port), timeout=PATIENCE) as client:
        with contextlib.suppress(ConnectionError):
            for part in parts:
                client.sendall(part)
                time.sleep(every)
        found = b""
        while b"}" not in found and (more := client.recv(65536)):
            found += more
    head, _, body = found.partition(b"\r\n\r\n")
    return int(head.split()[1]), json.loads(body)["error"]


def head(port, **headers):
    lines = {"host": f"127.0.0.1:{port}"} | headers
    text = "".join(f"{name.replace('_', '-')}: {value}\r\n" for name, value in lines.items())
    return f"POST /api/project HTTP/1.1\r\n{text}\r\n".encode()


def test_slow_head_and_slow_body_are_refused(port):
    status, said = answered(port, *[b"P"] + [b"O"] * 30)
    assert (status, "head of the request" in said) == (408, True)
    status, said = answered(port, head(port, content_length=1000), *[b"x"] * 30)
    assert (status, "body of the request" in said) == (408, True)


@pytest.mark.parametrize(
    "raw", [b"\x00\xff\r\n\r\n", b"GET HTTP/1.1\r\n\r\n", b"GET / HTTP/1.1\r\nx: " + b"a" * 80_000]
)
def test_what_is_not_http_gets_a_sentence(port, raw):
    status, said = answered(port, raw)
    assert (status, "not HTTP" in said) == (400, True)


def test_chunks_beyond_the_cap_and_broken_ones_are_refused(port):
    chunk = b"10000\r\n" + b" " * 65536 + b"\r\n"
    status, said = answered(port, head(port, transfer_encoding="chunked"), *[chunk] * 20, every=0.0)
    assert (status, "larger than 1024 KiB" in said) == (413, True)
    assert answered(port, head(port, transfer_encoding="chunked"), b"zz\r\n")[0] == 400


def test_no_part_of_an_answer_waits_for_an_acknowledgement():
    async def option():
        served, seen = asyncio.get_running_loop().create_future(), []

        class Protocol(asyncio.Protocol):
            def connection_made(self, transport):
                accepted = transport.get_extra_info("socket")
                seen.append(accepted.getsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY))
                served.set_result(None)

        listener, port = server.listening(8995)
        async with await asyncio.get_running_loop().create_server(Protocol, sock=listener):
            with socket.create_connection(("127.0.0.1", port)):
                await asyncio.wait_for(served, PATIENCE)
        return seen

    assert asyncio.run(option())[0]


def test_taken_port_gives_the_next_one():
    first, own = server.listening(8990)
    first.listen(1)
    second, next_one = server.listening(own)
    first.close()
    second.close()
    assert own < next_one < own + server.TRIES


def test_range_of_taken_ports_is_said(monkeypatch):
    monkeypatch.setattr(server, "taken", lambda _: None)
    with pytest.raises(RuntimeError, match=r"ports 8765 to 8784 are all in use; choose a free one with --port"):
        server.listening(8765)


def test_without_a_browser_the_address_is_said(monkeypatch, capsys):
    monkeypatch.setattr(command.webbrowser, "open", lambda _: False)
    command._open("http://127.0.0.1:1/")
    assert "no browser was found; open http://127.0.0.1:1/" in capsys.readouterr().err


def test_killed_server_leaves_no_process_and_no_file(tmp_path):
    environment = {**os.environ, "TMPDIR": str(tmp_path), "STRAINWAVE_JIT": "1"}  # it ends after an answer
    with subprocess.Popen(
        [sys.executable, "-m", "strainwave", "app", "--no-browser", "--port", "8951"],
        stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True, env=environment,
    ) as process:  # fmt: skip
        process.stdout.readline()
        end = time.monotonic() + PATIENCE
        while not list(tmp_path.iterdir()):
            assert time.monotonic() < end, "no process of the server begins"
            time.sleep(0.02)
        process.kill()
    while list(tmp_path.iterdir()):
        assert time.monotonic() < end, "a process of the server lives on"
        time.sleep(0.02)
