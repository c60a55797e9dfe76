"""Workers on several computers, when the network between them and Redis fails."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from subprocess import Popen

import pytest
from redis import Redis

from service.stack.embedded_valkey import EmbeddedValkey
from tests.support.jobs import a_request, ended
from tests.support.networks import Network, network
from tests.support.processes import descendants, environment, is_running, started, until
from tests.support.tls import Certificates, tls_front
from worker.connection import connect
from worker.jobs.queue import JobQueue
from worker.settings import WorkerSettings

SECRET = "s3cret/and: more"
PLACES = ("a", "b")
SETTINGS = {
    "task": "tests.support.hard_tasks.gated",
    "beat_interval": 0.2,
    "beat_ttl": 2,
    "sweep_interval": 0.2,
    "lost_grace": 0.2,
}
REDIS_TIMEOUT = "3"


@dataclass
class Site:
    """One Redis with TLS and a password, and workers elsewhere."""

    network: Network
    redis: Redis
    queue: JobQueue
    start: Callable[[str], Popen[bytes]]

    def workers(self) -> int:
        return self.queue.workers()

    def horse(self, worker: Popen[bytes]) -> int:
        """Returns the work horse of a worker that computes."""
        return until(lambda: descendants(worker.pid))[-1]

    def begun(self) -> list[int]:
        return [int(attempt) for attempt in self.redis.lrange("begun", 0, -1)]

    def open_gate(self) -> None:
        self.redis.set("gate", 1)


@pytest.fixture
def site(tmp_path: Path) -> Iterator[Site]:
    with ExitStack() as stack:
        net = stack.enter_context(network(*PLACES))
        server = stack.enter_context(EmbeddedValkey(tmp_path / "data"))
        certificates = Certificates(tmp_path, net.host)
        with connect(server.url) as client:
            client.config_set("requirepass", SECRET)
        (tmp_path / "password").write_text(SECRET)
        socket = server.url.removeprefix("unix://")
        port = stack.enter_context(tls_front(socket, certificates, net.host))
        redis = stack.enter_context(Redis(unix_socket_path=socket, password=SECRET))
        files = f"ssl_ca_certs={tmp_path}/authority.pem&ssl_certfile={tmp_path}/client.pem"
        url = f"rediss://{net.host}:{port}/0?{files}&ssl_keyfile={tmp_path}/client.key"
        variables = environment(
            **SETTINGS, redis_url=url, redis_password_file=tmp_path / "password", log_level="INFO"
        )
        queue = JobQueue(redis, WorkerSettings.model_validate(SETTINGS))

        def start(place: str) -> Popen[bytes]:
            before = queue.workers()
            module = ("-m", "tests.support.odd_worker", REDIS_TIMEOUT)
            command = [*net.inside(place), sys.executable, *module, "--name", place]
            log = stack.enter_context((tmp_path / f"{place}.log").open("ab"))
            worker = stack.enter_context(started(command, env=variables, stderr=log))
            until(lambda: queue.workers() == before + 1)
            return worker

        yield Site(net, redis, queue, start)


@pytest.mark.long
def test_the_cable_of_a_worker_is_pulled(site: Site) -> None:
    """The network between one worker and Redis fails while the worker computes, and recovers. Another worker
    takes over within seconds; the first ends its work horse, and works again when the network recovers.
    """
    first = site.start("a")
    view = site.queue.submit(a_request("1", "2"))
    until(lambda: site.begun() == [0])
    horse = site.horse(first)
    site.start("b")
    site.network.cut("a")
    until(lambda: site.begun() == [0, 1])
    until(lambda: site.workers() == 1)
    site.network.heal("a")
    until(lambda: not is_running(horse))
    site.open_gate()
    assert ended(site.queue, view.id).status == "succeeded"
    assert site.begun()[2:] in ([], [1]), "no third attempt: only the slices of the second"
    until(lambda: site.workers() == 2)
    assert first.poll() is None


@pytest.mark.long
def test_redis_is_cut_from_all_workers(site: Site) -> None:
    """The network between Redis and all workers fails, and recovers. The job continues without help and
    succeeds; no worker ends.
    """
    workers = [site.start(place) for place in PLACES]
    view = site.queue.submit(a_request("1", "2"))
    until(lambda: site.begun() == [0])
    for place in PLACES:
        site.network.cut(place)
    until(lambda: site.workers() == 0)
    state = site.queue.get(view.id)
    assert state is not None
    assert state.status == "running", "nobody is there to run it again"
    for place in PLACES:
        site.network.heal(place)
    site.open_gate()
    assert ended(site.queue, view.id).status == "succeeded"
    until(lambda: site.workers() == 2)
    assert [worker.poll() for worker in workers] == [None, None]


@pytest.mark.long
def test_a_computer_is_lost(site: Site) -> None:
    """The computer of a worker is switched off while it computes. Another one takes over within seconds, and
    the first disappears from the roster.
    """
    first = site.start("a")
    view = site.queue.submit(a_request("1", "2"))
    until(lambda: site.begun() == [0])
    site.start("b")
    site.network.cut("a")  # not even the closing of its connections is heard
    first.kill()
    until(lambda: site.begun() == [0, 1])
    site.open_gate()
    assert ended(site.queue, view.id).status == "succeeded"
    until(lambda: site.workers() == 1)
