"""Webhooks, from the question to a real receiver."""

from __future__ import annotations

import base64
import hmac
import ipaddress
import itertools
import json
import os
import shutil
import signal
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import httpx
import pytest
from pydantic import ValidationError
from redis import Redis

from rpr_solver.errors import InputError
from service.api.job_views import event_documents
from service.api.settings import Settings
from service.stack.embedded_valkey import EmbeddedValkey
from service.webhooks.callbacks import MAX_CALLBACKS_PER_JOB, Callbacks, DeliveryAttempt
from service.webhooks.deliverer import Deliverer, signature
from service.webhooks.target import WebhookSettings, is_allowed, target_of
from tests.support.pages import NOT_RUN
from tests.support.processes import PATIENCE, started, until
from tests.support.receivers import Receiver, receiving, silent
from tests.support.service_server import GEOMETRY, NO_WAIT, serving
from tests.support.stack import running
from tests.support.tls import Certificates
from worker.settings import WorkerSettings, written

SECRETS = [f"whsec_{base64.b64encode(bytes([n]) * 32).decode()}" for n in (1, 2)]
EVERY = itertools.count(1)


@pytest.fixture
def webhooks(tmp_path: Path) -> Callable[..., WebhookSettings]:
    """Makes settings that allow receivers on this computer, with quick retries."""
    path = tmp_path / "secrets"
    path.write_text("\n".join(SECRETS) + "\n")

    def make(**changes: Any) -> WebhookSettings:
        usual: dict[str, Any] = {
            "webhook_hosts": "127.0.0.1",
            "webhook_secret_file": path,
            "webhook_networks": "127.0.0.0/8",
            "webhook_retry_seconds": (0.1, 0.1),
            "webhook_timeout_seconds": 2,
        }
        return WebhookSettings(**{**usual, **changes})

    return make


@contextmanager
def delivering(redis: Redis, settings: WebhookSettings, margin: float = 1.0) -> Iterator[None]:
    stop, own = threading.Event(), WorkerSettings()
    deliverer = Deliverer(redis, settings, own, event_documents(own), margin)
    thread = threading.Thread(target=deliverer.run, args=(stop,), daemon=True)
    thread.start()
    try:
        yield
    finally:
        stop.set()
        thread.join(PATIENCE)


@pytest.fixture
def idle(
    valkey: EmbeddedValkey, idle_redis: Redis, webhooks: Callable[..., WebhookSettings]
) -> Iterator[httpx.Client]:
    """A client of a service without a worker and without deliveries."""
    assert idle_redis.dbsize() == 0
    settings = Settings(redis_url=f"{valkey.url}?db=2", webhooks=webhooks())
    with serving(settings) as url, httpx.Client(base_url=url, timeout=PATIENCE) as client:
        yield client


def question(url: object, number: int | None = None) -> dict[str, Any]:
    a3y = f"11.{next(EVERY) if number is None else number:05d}"
    return {"geometry": {**GEOMETRY, "a3y": a3y}, "l1": "14.98", "digits": 15, "callback_url": url}


def canceled(client: httpx.Client, url: str) -> str:
    """Returns a job that has ended, with a callback."""
    answer = client.post("/v1/cusp-tables", json=question(url), headers=NO_WAIT)
    assert answer.status_code == 202, answer.text
    assert client.delete(answer.json()["links"]["self"]).json()["status"] == "canceled"
    job_id: str = answer.json()["id"]
    return job_id


def log_of(client: httpx.Client, job_id: str) -> list[dict[str, Any]]:
    kind = "batches" if job_id.startswith("ba-") else "jobs"
    deliveries: list[dict[str, Any]] = client.get(f"/v1/{kind}/{job_id}").json().get("deliveries", [])
    return deliveries


def over(client: httpx.Client, job_id: str) -> dict[str, Any]:
    """Returns the one delivery of a job once it is over."""

    def one() -> dict[str, Any] | None:
        deliveries = log_of(client, job_id)
        return next((delivery for delivery in deliveries if delivery["state"] != "pending"), None)

    return until(one)


def verified(receiver: Receiver, secret: str) -> list[Any]:
    library = pytest.importorskip("standardwebhooks")
    return [library.Webhook(secret).verify(body, headers) for headers, body in receiver.received]


@pytest.mark.usefixtures("worker")
def test_a_job_and_a_batch_that_succeed(
    valkey: EmbeddedValkey, redis: Redis, webhooks: Callable[..., WebhookSettings]
) -> None:
    settings = Settings(redis_url=valkey.url, webhooks=webhooks())
    with (
        receiving() as receiver,
        serving(settings) as url,
        httpx.Client(base_url=url, timeout=PATIENCE) as client,
        delivering(redis, settings.webhooks),
    ):
        asked = question(receiver.url)
        job = client.post("/v1/cusp-tables", json=asked, headers=NO_WAIT).json()
        assert "callback_url" not in job
        assert over(client, job["id"])["state"] == "delivered"
        known = client.post("/v1/cusp-tables", json=asked)
        assert known.status_code == 200
        item = {"kind": "cusp-table", "request": {k: asked[k] for k in ("geometry", "l1", "digits")}}
        batch = client.post("/v1/batches", json={"callback_url": receiver.url, "items": [item]}).json()
        assert over(client, batch["id"])["state"] == "delivered"
        events = verified(receiver, SECRETS[0])
        assert verified(receiver, SECRETS[1]) == events  # either secret is enough while they change
        assert [event["type"] for event in events] == ["job.succeeded", "batch.completed"]
        now = [client.get(f"/v1/jobs/{job['id']}").json(), client.get(f"/v1/batches/{batch['id']}").json()]
        assert all(state.pop("deliveries") for state in now)
        assert [event["data"] for event in events] == now
        assert [event["timestamp"] for event in events] == [state["ended_at"] for state in now]
        assert 'rpr_cusps_webhook_attempts_total{state="delivered"} 2.0' in client.get("/metrics").text


def test_it_is_sent_again_with_the_same_id_until_it_is_received(
    idle: httpx.Client, idle_redis: Redis, webhooks: Callable[..., WebhookSettings]
) -> None:
    with receiving(500, (302, {"Location": "http://127.0.0.1:1/"}), 200) as receiver:
        job_id = canceled(idle, receiver.url)
        [waiting] = log_of(idle, job_id)
        assert (waiting["state"], waiting["attempts"], waiting["host"]) == ("pending", [], "127.0.0.1")
        with delivering(idle_redis, webhooks()):
            delivery = over(idle, job_id)
    assert delivery["state"] == "delivered"
    assert [attempt["status"] for attempt in delivery["attempts"]] == [500, 302, 200]
    assert "redirects" in delivery["attempts"][1]["problem"]
    assert {headers["webhook-id"] for headers, _ in receiver.received} == {delivery["webhook_id"]}
    assert len({body for _, body in receiver.received}) == 1
    assert [event["type"] for event in verified(receiver, SECRETS[0])] == ["job.canceled"] * 3


@pytest.mark.parametrize(("replies", "state", "count"), [((410,), "gone", 1), ((500,), "exhausted", 3)])
def test_it_ends_at_a_410_or_with_the_last_attempt(
    idle: httpx.Client,
    idle_redis: Redis,
    webhooks: Callable[..., WebhookSettings],
    replies: tuple[int, ...],
    state: str,
    count: int,
) -> None:
    with receiving(*replies) as receiver, delivering(idle_redis, webhooks()):
        delivery = over(idle, canceled(idle, receiver.url))
        assert (delivery["state"], len(delivery["attempts"]), len(receiver.received)) == (state, count, count)
        assert delivery["next_attempt_at"] is None


def test_the_receiver_says_when_to_come_again(
    idle: httpx.Client, idle_redis: Redis, webhooks: Callable[..., WebhookSettings]
) -> None:
    with receiving((503, {"Retry-After": "3000"})) as receiver, delivering(idle_redis, webhooks()):
        job_id = canceled(idle, receiver.url)
        until(lambda: log_of(idle, job_id)[0]["attempts"][:1])
        until(lambda: log_of(idle, job_id)[0]["attempts"][0]["status"] == 503)
    [(_, due)] = idle_redis.zrange("cusps:deliveries", 0, -1, withscores=True)
    assert 2900 < due - time.time() < 3001


def authority(folder: Path, host: str = "127.0.0.1") -> Certificates:
    folder.mkdir()
    return Certificates(folder, host)


def trusting(path: Path, *authorities: Certificates) -> str:
    """Returns a file of authorities, as `SSL_CERT_FILE` names it."""
    path.write_text("".join(Path(certificates["authority.pem"]).read_text() for certificates in authorities))
    return str(path)


def test_a_certificate_must_be_for_the_host_and_of_a_trusted_authority(
    idle: httpx.Client,
    idle_redis: Redis,
    webhooks: Callable[..., WebhookSettings],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    ours, strange = authority(tmp_path / "ours"), authority(tmp_path / "strange")
    elsewhere = authority(tmp_path / "elsewhere", "127.0.0.2")
    monkeypatch.setenv("SSL_CERT_FILE", trusting(tmp_path / "trusted.pem", ours, elsewhere))
    settings = webhooks(webhook_retry_seconds=())
    with (
        receiving(certificates=ours) as trusted,
        receiving(certificates=strange) as unknown,
        receiving(certificates=elsewhere) as misnamed,
        delivering(idle_redis, settings),
    ):
        assert over(idle, canceled(idle, trusted.url))["state"] == "delivered"
        assert [event["type"] for event in verified(trusted, SECRETS[0])] == ["job.canceled"]
        for receiver, reason in ((unknown, "certificate verify failed"), (misnamed, "IP address mismatch")):
            delivery = over(idle, canceled(idle, receiver.url))
            assert (delivery["state"], receiver.received) == ("exhausted", [])
            assert reason in delivery["attempts"][0]["problem"]


def test_a_secret_is_replaced_by_the_lines_of_its_page_while_the_service_runs(tmp_path: Path) -> None:
    library = pytest.importorskip("standardwebhooks")
    if shutil.which("openssl") is None:
        pytest.skip("needs openssl")
    [enabling, _, replacing] = [
        block.text.splitlines()
        for block in NOT_RUN
        if block.page == "docs/webhooks.md" and block.language == "sh"
    ]
    path = tmp_path / "webhook-secrets"

    def secrets_after(line: str) -> list[str]:
        subprocess.run(["sh", "-c", line], cwd=tmp_path, check=True)
        assert path.stat().st_mode & 0o077 == 0
        return path.read_text().split()

    [old] = secrets_after(enabling[0])
    settings = {"webhook_hosts": "127.0.0.1", "webhook_networks": "127.0.0.0/8"}
    with (
        receiving() as receiver,
        running(tmp_path / "data", webhook_secret_file=path, **settings) as stack,
        httpx.Client(base_url=stack.base, timeout=PATIENCE) as client,
    ):

        def signers(*secrets: str) -> list[bool]:
            """Which of these secrets verify the event of one more job."""
            answer = client.post(
                "/v1/cusp-tables", json=question(receiver.url), headers={"Prefer": "respond-async"}
            )
            assert answer.status_code == 202
            assert over(client, answer.json()["id"])["state"] == "delivered"
            headers, body = receiver.received[-1]
            valid = []
            for secret in secrets:
                try:
                    library.Webhook(secret).verify(body, headers)
                except library.WebhookVerificationError:
                    valid.append(False)
                else:
                    valid.append(True)
            return valid

        assert signers(old) == [True]
        before, new = secrets_after(replacing[0])
        assert before == old
        assert signers(old, new) == [True, True]
        assert secrets_after(replacing[1]) == [new]
        assert signers(old, new) == [False, True]


def test_a_private_address_is_refused_whatever_its_name(
    idle: httpx.Client, idle_redis: Redis, webhooks: Callable[..., WebhookSettings]
) -> None:
    with receiving() as receiver, delivering(idle_redis, webhooks(webhook_networks="")):
        delivery = over(idle, canceled(idle, receiver.url.replace("http", "https")))
    assert (delivery["state"], receiver.received) == ("refused", [])
    assert "not a public address" in delivery["attempts"][0]["problem"]


SPECIAL = [
    *("0.0.0.0/8", "10.0.0.0/8", "100.64.0.0/10", "127.0.0.0/8", "169.254.0.0/16", "172.16.0.0/12"),
    *("192.0.0.0/24", "192.0.2.0/24", "192.88.99.0/24", "192.168.0.0/16", "198.18.0.0/15"),
    *("198.51.100.0/24", "203.0.113.0/24", "224.0.0.0/4", "240.0.0.0/4", "255.255.255.255/32"),
    *("::/128", "::1/128", "::/96", "::ffff:0:0:0/96", "64:ff9b::/96", "64:ff9b:1::/48", "100::/64"),
    *("100:0:0:1::/64", "2001::/23", "2001::/32", "2001:2::/48", "2001:10::/28", "2001:20::/28"),
    *("2001:db8::/32", "2002::/16", "3fff::/20", "5f00::/16", "fc00::/7", "fe80::/10", "fec0::/10"),
    *("ff00::/8", "4000::/3", "e000::/4"),
    *("::ffff:10.0.0.0/104", "::ffff:127.0.0.0/104", "::ffff:192.168.0.0/112", "::ffff:224.0.0.0/100"),
]
"""The special-purpose addresses of IANA's registries, what was in them, and what is not assigned."""


def test_addresses_that_are_not_public() -> None:
    for special in SPECIAL:
        network = ipaddress.ip_network(special)
        size = network.num_addresses
        for place in (0, size // 3, size - 1):
            address = str(network[place])
            assert not is_allowed(address, ()), address
            assert is_allowed(address, (network,)) == (":ffff:" not in special or "0:0/" in special), address


def test_addresses_that_are_public() -> None:
    for address in (
        *("1.0.0.0", "9.255.255.255", "11.0.0.0", "100.63.255.255", "100.128.0.0", "126.255.255.255"),
        *("128.0.0.0", "169.253.255.255", "172.15.255.255", "172.32.0.0", "192.0.1.0", "192.0.3.0"),
        *("192.88.98.255", "192.167.255.255", "198.17.255.255", "198.20.0.0", "223.255.255.255"),
        *("192.31.196.1", "192.175.48.1", "2000::", "2001:200::1", "2001:4860:4860::8888", "2003::1"),
        *("2606:4700::1111", "2620:4f:8000::1", "3ffd:ffff::1", "::ffff:8.8.8.8"),
    ):
        assert is_allowed(address, ()), address


@pytest.mark.parametrize(
    ("url", "message"),
    [
        ("https://example.org/", "names the host 'example.org'"),
        ("https://example.com.evil.org/", "names the host"),
        ("https://a.example.com@evil.org/", "user, password"),
        ("https://a.example.com\\@evil.org/", "give a URL"),
        ("ftp://a.example.com/", "give a URL"),
        ("http://a.example.com/", "must be https://"),
        ("https://a.example.com:x/", "cannot be read"),
        (f"https://a.example.com/{2000 * 'x'}", "at most 2000"),
        ("https://a..example.com/", "cannot be read"),
        ("https://.example.com/", "cannot be read"),
        ("https://a.example.com./", "cannot be read"),
        (f"https://{64 * 'a'}.example.com/", "cannot be read"),
        (f"https://{'a.' * 125}example.com/", "cannot be read"),
        ("https://-a.example.com/", "cannot be read"),
        ("https://a-.example.com/", "cannot be read"),
        ("https://%61.example.com/", "cannot be read"),
        ("https://a!.example.com/", "cannot be read"),
        ("https://ä.example.com/", "give a URL"),
        ("https://xn--9999999999999.example.com/", "cannot be read"),
        ("https://[::1/", "cannot be read"),
        ("https://[::1%25lo]/", "cannot be read"),
        ("https://[a.example.com]/", "cannot be read"),
        ("https://a.example.com:0/", "cannot be read"),
        ("https://a.example.com:99999/", "cannot be read"),
        ("https://:443/", "cannot be read"),
    ],
)
def test_urls_that_are_refused(url: str, message: str, webhooks: Callable[..., WebhookSettings]) -> None:
    settings = webhooks(webhook_hosts="*.example.com", webhook_networks="")
    with pytest.raises(InputError, match="callback_url") as caught:
        target_of(url, settings)
    assert message in str(caught.value)
    assert target_of("https://A.example.com/x?y", settings).host == "a.example.com"
    assert target_of("https://xn--mnchen-3ya.example.com:8443/", settings).port == 8443


@pytest.mark.parametrize("host", ["127.0.0.1", "10.1.2.3", "[::1]", "localhost", "a.localhost"])
def test_an_address_that_no_setting_allows_is_refused_with_the_question(
    host: str, webhooks: Callable[..., WebhookSettings]
) -> None:
    hosts = "127.0.0.1,10.1.2.3,::1,localhost,*.localhost"
    allowed = webhooks(webhook_hosts=hosts, webhook_networks="127.0.0.0/8,10.0.0.0/8,::1/128")
    assert target_of(f"http://{host}:9000/", allowed).port == 9000
    with pytest.raises(InputError, match="not in RPR_CUSPS_WEBHOOK_NETWORKS"):
        target_of(f"http://{host}:9000/", webhooks(webhook_hosts=hosts, webhook_networks="192.168.0.0/16"))


def test_http_is_for_private_networks_only(webhooks: Callable[..., WebhookSettings]) -> None:
    settings = webhooks(webhook_hosts="8.8.8.8")
    assert target_of("https://8.8.8.8/", settings).port == 443
    with pytest.raises(InputError, match="for http:// not in RPR_CUSPS_WEBHOOK_NETWORKS"):
        target_of("http://8.8.8.8/", settings)


@pytest.mark.parametrize("url", ["https://evil.example/", 7])
def test_the_service_refuses_them_by_the_name_of_the_field(idle: httpx.Client, url: object) -> None:
    item = {"kind": "poses", "request": {"geometry": GEOMETRY, "l1": 1, "l2": 2, "l3": 3}}
    for path, body in (
        ("/v1/cusp-tables", question(url)),
        ("/v1/batches", {"items": [item], "callback_url": url}),
        ("/v1/batches", {"callback_url": url, "items": [item]}),
    ):
        answer = idle.post(path, json=body)
        assert answer.status_code == 422, answer.text
        assert [error["field"] for error in answer.json()["errors"]] == ["callback_url"]


def test_without_hosts_there_are_no_webhooks(base_url: str) -> None:
    answer = httpx.post(f"{base_url}/v1/cusp-tables", json=question("https://example.com/"), timeout=PATIENCE)
    assert answer.status_code == 422
    assert "RPR_CUSPS_WEBHOOK_HOSTS" in answer.json()["detail"]


def test_a_batch_of_lines_names_it_in_the_query(
    idle: httpx.Client, idle_redis: Redis, webhooks: Callable[..., WebhookSettings]
) -> None:
    line = json.dumps({"kind": "poses", "request": {}})  # fails, so that the batch has ended at once
    with receiving() as receiver, delivering(idle_redis, webhooks()):
        answer = idle.post(
            "/v1/batches",
            params={"callback_url": receiver.url},
            content=line,
            headers={"Content-Type": "application/x-ndjson"},
        )
        assert answer.status_code == 202
        assert over(idle, answer.json()["id"])["state"] == "delivered"
    assert verified(receiver, SECRETS[0])[0]["data"]["failed"] == 1


def test_a_host_that_did_not_answer_in_time_has_a_rest(
    idle: httpx.Client, idle_redis: Redis, webhooks: Callable[..., WebhookSettings]
) -> None:
    settings = webhooks(webhook_timeout_seconds=0.3, webhook_retry_seconds=(60,))
    with silent() as slow, delivering(idle_redis, settings):
        jobs = [canceled(idle, slow) for _ in range(8)]
        until(lambda: idle_redis.zcount("cusps:deliveries-hosts", time.time() + 0.3, "+inf"))
        assert sum(len(log["attempts"]) for job in jobs for log in log_of(idle, job)) <= 4
        until(lambda: all(log_of(idle, job)[0]["attempts"] for job in jobs))  # each in its turn
    assert not idle_redis.keys("cusps:deliveries-to:*")


def test_what_waits_for_its_hosts_turn_is_not_lost(idle: httpx.Client, idle_redis: Redis) -> None:
    jobs = [canceled(idle, f"http://127.0.0.1:1/{number}") for number in range(3)]
    callbacks = Callbacks(idle_redis, WorkerSettings())
    assert callbacks.claim(60, ["127.0.0.1"]) is None
    assert callbacks.claim(60, ["*.0.0.1"]) is None
    idle_redis.delete("cusps:deliveries-to:127.0.0.1", "cusps:deliveries-hosts")
    assert callbacks.claim(60) is None
    for name, _ in idle_redis.zrange("cusps:deliveries", 0, -1, withscores=True):
        idle_redis.zadd("cusps:deliveries", {name: 0})  # a minute later
    claimed = [callbacks.claim(60) for _ in jobs]
    assert {one.job.id for one in claimed if one is not None} == set(jobs)
    assert callbacks.claim(60) is None


def test_all_allowed_addresses_of_a_name_are_tried(
    idle: httpx.Client,
    idle_redis: Redis,
    webhooks: Callable[..., WebhookSettings],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    known = socket.getaddrinfo

    def found(host: str | bytes, *port: Any, **options: Any) -> list[Any]:
        addresses = ["10.0.0.1", "127.0.0.9", "127.0.0.1"] if host == b"127.0.0.1" else [host]
        return [entry for address in addresses for entry in known(address, *port, **options)]

    with receiving() as receiver, delivering(idle_redis, webhooks(webhook_timeout_seconds=20)):
        monkeypatch.setattr(socket, "getaddrinfo", found)  # nobody listens at the second address
        job_id = canceled(idle, receiver.url)
        until(lambda: receiver.received)
        assert over(idle, job_id)["state"] == "delivered"


def test_a_name_that_is_not_found_out_in_time(
    idle: httpx.Client,
    idle_redis: Redis,
    webhooks: Callable[..., WebhookSettings],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    hangs, known = threading.Event(), socket.getaddrinfo

    def hanging(host: str | bytes, *port: Any, **options: Any) -> Any:
        return hangs.wait(PATIENCE) if host == b"127.0.0.1" else known(host, *port, **options)

    settings = webhooks(webhook_timeout_seconds=0.3, webhook_retry_seconds=())
    with receiving() as receiver, delivering(idle_redis, settings):
        job_id = canceled(idle, receiver.url)
        monkeypatch.setattr(socket, "getaddrinfo", hanging)
        delivery = over(idle, job_id)
    hangs.set()
    assert delivery["state"] == "exhausted"
    assert "was not resolved in time" in delivery["attempts"][0]["problem"]


def test_several_callers_are_told_and_each_once(
    idle: httpx.Client, idle_redis: Redis, webhooks: Callable[..., WebhookSettings]
) -> None:
    with receiving() as one, receiving() as other:
        number = next(EVERY)
        asked = [idle.post("/v1/cusp-tables", json=question(r.url, number)) for r in (one, other, one)]
        job_id = asked[0].json()["id"]
        for answer in asked:
            idle.delete(answer.json()["links"]["self"])
        with delivering(idle_redis, webhooks()), delivering(idle_redis, webhooks()):
            until(lambda: [d["state"] for d in log_of(idle, job_id)] == ["delivered"] * 2)
        assert (len(one.received), len(other.received)) == (1, 1)
        Callbacks(idle_redis, WorkerSettings()).add(job_id, one.url)  # asked for again after the end
        assert len(log_of(idle, job_id)) == 2


def test_a_job_has_only_so_many(idle: httpx.Client, idle_redis: Redis) -> None:
    answer = idle.post("/v1/cusp-tables", json=question("http://127.0.0.1/0", 0))
    for n in range(1, MAX_CALLBACKS_PER_JOB):
        Callbacks(idle_redis, WorkerSettings()).add(answer.json()["id"], f"http://127.0.0.1/{n}")
    refused = idle.post("/v1/cusp-tables", json=question("http://127.0.0.1/more", 0))
    assert refused.status_code == 422
    assert str(MAX_CALLBACKS_PER_JOB) in refused.json()["detail"]
    assert idle.get(f"/v1/jobs/{answer.json()['id']}").json()["status"] == "queued"


def test_a_deliverer_that_is_killed_is_replaced(
    valkey: EmbeddedValkey,
    idle: httpx.Client,
    idle_redis: Redis,
    webhooks: Callable[..., WebhookSettings],
) -> None:
    settings = webhooks(webhook_timeout_seconds=1)
    program = f"""
import threading
from service.api.job_views import event_documents
from service.webhooks.deliverer import Deliverer
from service.webhooks import WebhookSettings
from worker.connection import connect
from worker.settings import WorkerSettings
own = WorkerSettings()
redis = connect({f"{valkey.url}?db=2"!r})
Deliverer(redis, WebhookSettings(), own, event_documents(own), 0.5).run(threading.Event())
"""
    names = ("webhook_hosts", "webhook_networks", "webhook_secret_file", "webhook_timeout_seconds")
    environment = {f"RPR_CUSPS_{name.upper()}": written(getattr(settings, name)) for name in names}
    with receiving(slow_seconds=0.9) as receiver:
        job_id = canceled(idle, receiver.url)
        with started([sys.executable, "-c", program], env={**os.environ, **environment}) as process:
            until(lambda: receiver.received)
            process.send_signal(signal.SIGKILL)
            process.wait(PATIENCE)
        assert log_of(idle, job_id)[0]["attempts"][0]["status"] is None
        with delivering(idle_redis, settings):
            delivery = over(idle, job_id)
        first, second = receiver.received
    assert [attempt["status"] for attempt in delivery["attempts"]] == [None, 204]
    assert (first[0]["webhook-id"], first[1]) == (second[0]["webhook-id"], second[1])


def test_who_comes_too_late_changes_nothing(idle: httpx.Client, idle_redis: Redis) -> None:
    job_id = canceled(idle, "http://127.0.0.1:1/")
    callbacks = Callbacks(idle_redis, WorkerSettings())
    early = callbacks.claim(1)
    assert early is not None
    assert callbacks.claim(60) is None  # it is leased
    late = until(lambda: callbacks.claim(60))
    assert not callbacks.settle(early, "delivered", DeliveryAttempt(time.time(), 200))
    assert callbacks.settle(late, "gone", DeliveryAttempt(time.time(), 410))
    assert log_of(idle, job_id)[0]["state"] == "gone"


def test_the_signature_is_that_of_the_specification() -> None:
    key, body = b"k" * 32, '{"é":1}'.encode()
    expected = base64.b64encode(hmac.digest(key, b"msg_1.1700000000." + body, "sha256")).decode()
    assert signature([key], "msg_1", 1_700_000_000, body) == f"v1,{expected}"


@pytest.mark.parametrize(
    ("content", "message"),
    [(None, "is missing"), ("", "is empty"), ("whsec_AAAA", "24 bytes"), ("plain", "24 bytes")],
)
def test_secrets_that_cannot_sign(tmp_path: Path, content: str | None, message: str) -> None:
    path = tmp_path / "secret"
    if content is not None:
        path.write_text(content)
    with pytest.raises(ValidationError, match=message):
        WebhookSettings(
            webhook_hosts="example.com", webhook_secret_file=path if content is not None else None
        )
