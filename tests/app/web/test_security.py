"""What the server refuses, each with a sentence and without a 5xx."""

import json

import pytest

GEAR = {"gear": "CSG-40-50"}
HOSTILE = {
    "not JSON": b"{",
    "not UTF-8": b"\xff\xfe{}",
    "NaN": b'{"state": {"gear": "CSG-40-50"}, "speed": NaN}',
    "infinity": b'{"state": {"gear": "CSG-40-50"}, "speed": 1e999}',
    "deep": b"[" * 200_000,
    "deep objects": b'{"a":' * 50_000,
    "a long number": b'{"speed": ' + b"9" * 6000 + b"}",
    "a list": b"[]",
    "unknown field": json.dumps({"state": GEAR, "path": "/etc/passwd"}).encode(),
    "wrong type": json.dumps({"state": {"gear": 5}}).encode(),
    "no gear": json.dumps({"state": {}}).encode(),
    "gear and project": json.dumps({"state": {"gear": "x", "project": "y"}}).encode(),
    "unknown gear": json.dumps({"state": {"gear": "../../etc/passwd"}}).encode(),
    "value out of range": json.dumps({"state": {**GEAR, "values": {"load.inertia": "-1 kg*m^2"}}}).encode(),
    "value without unit": json.dumps({"state": {**GEAR, "values": {"load.inertia": "1"}}}).encode(),
    "unknown value": json.dumps({"state": {**GEAR, "values": {"load.weight": "1 kg"}}}).encode(),
    "lone surrogate": b'{"state": {"gear": "\\ud800"}}',
    "null byte": b'{"state": {"project": "gear: \\u0000"}}',
}


def sentence_of(answer):
    assert 400 <= answer.status_code < 500, answer.text
    said = answer.json()["error"]
    assert said
    assert "Traceback" not in said
    assert "\n" not in said
    return said


@pytest.mark.parametrize("path", ["/api/project", "/api/motion", "/api/jobs"])
@pytest.mark.parametrize("what", HOSTILE)
def test_hostile_body_gets_a_sentence(client, path, what):
    answer = client.post(path, content=HOSTILE[what], headers={"content-type": "application/json"})
    if path == "/api/project" and "value" in what:  # the rest of the drive is told, with the sentence at its number
        told = answer.json()
        assert any(told["unknown"].values()) or any(one["wrong"] for one in told["parameters"])
    else:
        sentence_of(answer)


@pytest.mark.parametrize("host", ["evil.example", "127.0.0.1.evil.example", "127.0.0.1:80@evil.example", ""])
def test_other_host_is_refused(client, host):
    assert "this machine" in sentence_of(client.get("/", headers={"host": host}))


@pytest.mark.parametrize("method", ["POST", "DELETE"])
@pytest.mark.parametrize(
    "origin", ["http://evil.example", "null", "http://127.0.0.1:9999", "https://127.0.0.1.evil", "http://[", "x"]
)
def test_other_origin_is_refused(client, method, origin):
    answer = client.request(method, "/api/jobs/00", headers={"origin": origin})
    assert answer.status_code == 403
    assert "another site" in sentence_of(answer)


def test_own_origin_is_taken(client):
    answer = client.post("/api/project", json={"state": GEAR}, headers={"origin": "http://127.0.0.1:8765"})
    assert answer.status_code == 200


def test_large_body_is_refused_by_its_length(client):
    assert client.post("/api/project", content=b" " * (1024 * 1024 + 1)).status_code == 413


def test_log_may_be_larger_but_not_endless(client):
    assert client.post("/api/log?name=a.csv", content=b"x" * (2 * 1024 * 1024)).status_code == 422
    assert client.post("/api/log?name=a.csv", content=b"x" * (20 * 1024 * 1024 + 1)).status_code == 413


@pytest.mark.parametrize(
    "path", ["/static/../server.py", "/static/%2e%2e/server.py", "/static/..%2fserver.py", "/etc/passwd", "/static/"]
)
def test_path_tricks_find_nothing(client, path):
    answer = client.get(path)
    assert answer.status_code == 404
    sentence_of(answer)


@pytest.mark.parametrize(
    "text",
    [
        "gear: {ratio: 50, law: {python: 'server.py:Law', K: 1 N*m/rad}}",
        "gear: {file: gears.yaml, name: A}",
        "gear: CSG-40-50\nmove: {profile: [{type: angle_profile, file: a.csv}]}",
        "gear: {ratio: 50, law: 'laws.py:Law'}",
    ],
)
def test_project_may_not_name_a_file(client, text):
    sentence_of(client.post("/api/project", json={"state": {"project": text}}))


@pytest.mark.parametrize("name", ["../../etc/passwd", "a.py", "", "a.csv/../../b", "a.npz"])
def test_log_of_another_kind_or_content_is_refused(client, name):
    sentence_of(client.post("/api/log", params={"name": name}, content=b"\x00\x01\x02"))


@pytest.mark.parametrize("name", ["a.npz", "a.mat", "a.parquet", "a.mf4"])
@pytest.mark.parametrize(
    "content", [b"\x00", b"\x00\x01", b"\x00\x01\x02\x03" * 30, b"PK\x03\x04", b"MATLAB 5.0" + 200 * b"\x00"]
)
def test_a_damaged_packed_log_is_refused_in_a_sentence(client, name, content):
    sentence_of(client.post("/api/log", params={"name": name}, content=content))


def test_jobs_are_capped(client):
    body = {"state": GEAR, "kind": "speed-map", "loads": [-float(i) for i in range(40)]}
    answers = [client.post("/api/jobs", json=body) for _ in range(20)]
    for answer in answers:
        if answer.status_code == 201:
            client.delete(f"/api/jobs/{answer.json()['id']}")
    assert answers[-1].status_code == 429
    assert "16 jobs" in sentence_of(answers[-1])


def test_every_answer_has_the_strict_policy(client):
    for path in ("/", "/static/app.js", "/api/gears", "/nowhere"):
        policy = client.get(path).headers["content-security-policy"]
        assert policy.startswith("default-src 'none'; script-src 'self';")
        assert "unsafe-inline" not in policy
        assert "unsafe-eval" not in policy
