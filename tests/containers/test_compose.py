"""The image and compose.yaml in real containers: `pytest --long tests/containers`."""

from __future__ import annotations

import csv
import json
import os
import re
import socket
import subprocess
import time
from collections.abc import Iterator
from fractions import Fraction
from pathlib import Path

import httpx
import pytest
import yaml

from rpr_solver import EXAMPLES, eliminate, solve_slice
from service import __version__
from service.client import Answer, Asked, cusp_table
from service.schemas.tables import CuspTable
from tests.support.containers import MISSING, ROOT, Installation, called, copied, engine
from tests.support.processes import until
from tests.support.service_server import GEOMETRY

pytestmark = [pytest.mark.long, pytest.mark.timeout(900)]
MANIPULATOR = EXAMPLES["innocenti"]
SLICES = 600
MOST_SECONDS = 600.0
MOST_BYTES = 180 * 10**6
"""What the image may add to its base."""


@pytest.fixture(scope="module", autouse=True)
def _engine() -> None:
    if engine() is None:  # it is looked for where a test runs, not where tests are collected
        pytest.skip(MISSING)


RECEIVER = """
import http.server, sys
class Handler(http.server.BaseHTTPRequestHandler):
    def do_POST(self):
        body = self.rfile.read(int(self.headers["Content-Length"])).decode()
        print("received", self.headers["webhook-signature"], body, flush=True)
        self.send_response(204)
        self.end_headers()
http.server.HTTPServer(("", 8080), Handler).serve_forever()
"""
HOOKS = {
    "services": {
        "api": {
            "environment": {
                "RPR_CUSPS_WEBHOOK_HOSTS": "receiver",
                "RPR_CUSPS_WEBHOOK_NETWORKS": "10.0.0.0/8,172.16.0.0/12,192.168.0.0/16",
                "RPR_CUSPS_WEBHOOK_SECRET_FILE": "/run/secrets/webhooks",
            },
            "volumes": ["./secrets/webhooks:/run/secrets/webhooks:ro"],
        },
        "receiver": {
            "image": "rpr-cusps",
            "entrypoint": ["python", "-c", RECEIVER],
            "healthcheck": {"test": ["CMD", "true"]},
            "networks": ["outside"],
        },
    }
}


def free_port() -> int:
    with socket.socket() as sock:
        sock.bind(("127.0.0.1", 0))
        return int(sock.getsockname()[1])


@pytest.fixture(scope="module")
def started(tmp_path_factory: pytest.TempPathFactory) -> Iterator[tuple[Installation, str, float]]:
    """What docker/first-table starts, what it prints, and how long it takes."""
    folder = copied(tmp_path_factory.mktemp("installation"))
    here = Installation(folder, f"rpr-cusps-test-{os.getpid()}", free_port())
    try:
        begin = time.monotonic()
        done = subprocess.run(
            [folder / "docker" / "first-table"],
            env=here.environment,
            capture_output=True,
            text=True,
            check=False,
        )
        assert done.returncode == 0, done.stderr[-4000:]
        found = re.search(r"with the key (\S+);", done.stderr)
        assert found is not None
        here.key = found[1]
        yield here, done.stdout, time.monotonic() - begin
    finally:
        here.more = ()
        here.down("--volumes")


@pytest.fixture
def here(started: tuple[Installation, str, float]) -> Installation:
    """The running installation, with two workers."""
    installation, _, _ = started
    for name in installation.names("worker")[installation.workers :]:
        installation.engine("rm", "-f", name)
    installation.up()
    return installation


def long_table(start: int) -> Asked[CuspTable]:
    """A question whose job takes some seconds."""
    return cusp_table(MANIPULATOR, [Fraction(start * 400 + n, 400) for n in range(SLICES)], digits=200)


def ask(here: Installation, l1: str, digits: int = 90) -> Answer[CuspTable]:
    with here.client() as client:
        return client.ask(cusp_table(MANIPULATOR, l1, digits=digits))


def test_the_lines_at_its_head_lead_to_a_table(started: tuple[Installation, str, float]) -> None:
    _, printed, seconds = started
    rows = list(csv.DictReader(printed[printed.index("l1,") :].splitlines()))
    cusps = solve_slice(eliminate(MANIPULATOR), "14.98").cusps
    assert {row["alpha_deg"][:9] for row in rows} == {f"{float(cusp.alpha_deg):.15f}"[:9] for cusp in cusps}
    assert len(rows) == len(cusps) == 6
    assert seconds < MOST_SECONDS
    print(f"docker/first-table took {seconds:.0f} s")


def test_the_image_is_small_and_whole(here: Installation) -> None:
    base = re.search(r"^FROM (\S+)", (ROOT / "docker" / "Dockerfile").read_text(), re.MULTILINE)
    assert base is not None
    whole, part = (here.inspect(name)["Size"] for name in ("rpr-cusps", base[1]))
    more = whole - part
    assert more < MOST_BYTES, f"{more / 1e6:.0f} MB beside its base"
    print(f"{whole / 1e6:.0f} MB, of which {part / 1e6:.0f} MB are the base")
    script = """
        rpr-cusps --version
        rpr-cusps solve innocenti --l1 14.98 --json > /tmp/table && rpr-cusps verify /tmp/table
        rpr-cusps census innocenti --json > /tmp/census && rpr-cusps verify /tmp/census
        rpr-cusps help serve
        ! command -v pip
    """
    run = ("run", "--rm", "--network", "none", "--read-only", "--tmpfs", "/tmp", "--cap-drop", "ALL")
    said = here.engine(*run, "--entrypoint", "sh", "rpr-cusps", "-ec", script)
    assert f"rpr-cusps {__version__}" in said
    assert said.count("ESTABLISHED") == 2


def test_every_container_is_contained_and_healthy(here: Installation) -> None:
    services = yaml.safe_load((here.folder / "docker" / "compose.yaml").read_text())["services"]
    for service in services:
        for name in here.names(service):
            status = here.engine("exec", name, "cat", "/proc/1/status")
            fields = dict(line.split(":", 1) for line in status.splitlines())
            assert set(fields["Uid"].split()) == {"999"}
            for capabilities in ("CapEff", "CapPrm", "CapBnd", "CapAmb"):
                assert int(fields[capabilities], 16) == 0
            assert fields["NoNewPrivs"].strip() == "1"
            assert fields["Seccomp"].strip() == "2"
            script = "for d in / /opt /etc /usr; do touch $d/x && exit 1; done; touch /tmp/x && rm /tmp/x"
            here.engine("exec", name, "sh", "-c", script)
            limits = here.inspect(name)["HostConfig"]
            assert limits["ReadonlyRootfs"] is True
            assert limits["Memory"] > 0
            assert here.is_healthy(name)


def test_no_one_without_a_key_is_answered(here: Installation) -> None:
    body = {"geometry": GEOMETRY, "l1": "3"}
    for headers in ({}, {"Authorization": "Bearer " + here.key[:-1] + "!"}):
        answer = httpx.post(f"{here.url}/v1/cusp-tables", json=body, headers=headers)
        assert answer.status_code == 401
    here.engine("exec", here.names("api")[0], "rpr-cusps", "keys", "create", "another")
    assert "another" in here.engine("exec", here.names("api")[0], "rpr-cusps", "keys", "list")


def test_every_line_of_the_logs_is_an_object_that_names_its_request_and_job(here: Installation) -> None:
    headers = {"Authorization": f"Bearer {here.key}", "X-Request-ID": "asked-once", "Prefer": "wait=60"}
    body = {"geometry": GEOMETRY, "l1": "16.25", "digits": 15}
    answer = httpx.post(f"{here.url}/v1/cusp-tables", json=body, headers=headers, timeout=60)
    assert answer.status_code == 200
    names = [name for service in ("api", "worker", "light-worker") for name in here.names(service)]

    def found() -> list[dict[str, str]]:
        lines = [json.loads(line) for name in names for line in here.logs(name)]
        assert all({"time", "level", "logger", "message"} <= line.keys() for line in lines)
        about = [line for line in lines if line.get("request_id") == "asked-once"]
        return about if len(about) > 1 else []

    about = until(found)
    assert {line["logger"] for line in about} == {"rpr_cusps.access", "rpr_cusps.worker"}
    assert all(line["job"].startswith("ct-") for line in about if line["message"].startswith("chunk"))


def test_a_batch_and_a_webhook(here: Installation) -> None:
    secrets = here.folder / "docker" / "secrets"
    (secrets / "webhooks").write_text("whsec_" + "c2VjcmV0" * 6 + "\n")
    (here.folder / "docker" / "hooks.yaml").write_text(yaml.safe_dump(HOOKS))
    here.more = ("docker/hooks.yaml",)
    here.up()
    try:
        with here.client() as client:
            items = [cusp_table(MANIPULATOR, f"7.{number}", digits=15) for number in range(30)]
            batch = client.submit(items, callback_url="http://receiver:8080/hook")
            assert len(list(client.results(batch.id))) == len(items)
        [receiver] = here.names("receiver")
        [said] = until(lambda: [line for line in here.logs(receiver) if line.startswith("received")])
        assert re.search(r"received v1,\S+ \{.*\"batch\.succeeded\"", said)
        assert batch.id in said
    finally:
        here.more = ()
        [receiver] = here.names("receiver")
        here.engine("rm", "-f", receiver)


@pytest.mark.parametrize("service", ["redis", "api", "worker", "light-worker"])
def test_a_killed_container_is_started_again_and_the_job_goes_on(here: Installation, service: str) -> None:
    """All containers of the service, while their work is not done."""
    name, number = here.names(service)[0], ["redis", "api", "worker", "light-worker"].index(service)
    with here.client() as client:
        asked = long_table(number + 2)
        job = client.begin(asked)
        before = {name: here.starts(name) for name in here.names(service)}
        time.sleep(1)  # everything that is asked is in the append-only file, which is written once a second
        for name in before:
            here.kill(name)
        until(lambda: all(here.starts(name) != time_ for name, time_ in before.items()))
        here.ready()
        answer = client.ask(asked)
    assert len(answer.document["slices"]) == SLICES
    assert not isinstance(job, Answer)


def test_workers_are_added_and_taken_away_while_a_job_runs(here: Installation) -> None:
    with here.client() as client:
        asked = long_table(20)
        client.begin(asked)
        here.workers = 4
        try:
            here.up()
            assert len(here.names("worker")) == 4
            assert httpx.get(f"{here.url}/readyz").json()["workers"] == 5
        finally:
            here.workers = 2
        for name in here.names("worker")[1:]:
            here.engine("stop", "-t", "15", name)
            assert here.inspect(name)["State"]["ExitCode"] == 0
            here.engine("rm", name)
        assert len(client.ask(asked).document["slices"]) == SLICES
    until(lambda: httpx.get(f"{here.url}/readyz").json()["workers"] == 2)


def test_everything_is_there_after_down_and_up(here: Installation) -> None:
    before = ask(here, "14.98").content
    here.down()
    assert here.names() == []
    here.up()
    known = httpx.post(
        f"{here.url}/v1/cusp-tables",
        json={"geometry": GEOMETRY, "l1": "14.98", "digits": 90},
        headers={"Authorization": f"Bearer {here.key}", "Prefer": "respond-async"},
    )
    assert known.status_code == 200, "the answer and the key are in the volume"
    assert known.content == before


def test_the_image_before_is_replaced_by_this_one(here: Installation, tmp_path: Path) -> None:
    """A job that the older workers have begun is finished by the newer ones; keys and answers stay."""
    git = ("git", "-C", str(ROOT))
    if not (ROOT / ".git").exists():
        pytest.skip("needs the history of the sources")
    paths = ("--", "rpr_solver", "worker", "service", "docker/Dockerfile", "docker/requirements.txt")
    _, before = called([*git, "log", "-2", "--format=%H", *paths]).split()
    archive = tmp_path / "before.tar"
    called([*git, "archive", "--output", str(archive), before])
    sources = tmp_path / "before"
    sources.mkdir()
    called(["tar", "-xf", str(archive), "-C", str(sources)])
    here.engine(
        "build", "-f", f"{sources}/docker/Dockerfile", "-t", "rpr-cusps-before", "--build-arg",
        f"SOURCE_COMMIT={before}", str(sources),
    )  # fmt: skip
    image = {"image": "rpr-cusps-before"}
    override = {"services": dict.fromkeys(("api", "worker", "light-worker"), image)}
    (here.folder / "docker" / "before.yaml").write_text(yaml.safe_dump(override))

    here.down()
    here.more = ("docker/before.yaml",)
    here.up()
    answer = ask(here, "15.5").content
    with here.client() as client:
        assert client.version()["commit"] == before
        asked = long_table(22)
        client.begin(asked)
        here.more = ()
        here.up()
        assert client.version()["commit"] != before
        assert len(client.ask(asked).document["slices"]) == SLICES
    assert ask(here, "15.5").content == answer
