"""Workers on several computers, when the network between them and Redis fails."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path
from subprocess import Popen

import pytest
from redis import Redis

from service.stack.embedded_valkey import EmbeddedValkey
from tests.support.jobs import a_heavy_document, ended
from tests.support.processes import descendants, environment, is_running, started, until
from tests.support.tls import Certificates, tls_front
from worker.connection import connect
from worker.jobs.queue import JobQueue
from worker.settings import WorkerSettings

SECRET = "s3cret/and: more"
PLACES = ("a", "b")
SETTINGS = {"task": "tests.support.hard_tasks.gated"}
REDIS_TIMEOUT = "3"


@dataclass(frozen=True)
class Network:
    """A bridge, and namespaces that are connected by it.

    Attributes:
        tag: the beginning of all names.
        host: the address of this computer on the bridge.
    """

    tag: str
    host: str

    def inside(self, place: str) -> list[str]:
        """Returns the words before a command that runs in a namespace."""
        return ["ip", "netns", "exec", f"{self.tag}-{place}"]

    def cut(self, place: str) -> None:
        """Pull the cable of a namespace: nothing arrives any more, and nobody is told."""
        _ip("link", "set", f"{self.tag}{place}", "down")

    def heal(self, place: str) -> None:
        """Plug it in again."""
        _ip("link", "set", f"{self.tag}{place}", "up")


@contextmanager
def network(*places: str) -> Iterator[Network]:
    """A network with these namespaces, as long as the block; skips the test where there can be none."""
    if shutil.which("ip") is None:
        pytest.skip("`ip` (iproute2) is not installed, so there are no network namespaces")
    if os.geteuid() != 0:
        pytest.skip("network namespaces need root")
    number = os.getpid() % 250
    tag, subnet = f"cu{number}", f"10.117.{number}"
    made = Network(tag, f"{subnet}.1")
    with ExitStack() as undo:
        try:
            _ip("link", "add", tag, "type", "bridge")
        except subprocess.CalledProcessError as error:
            pytest.skip(f"the kernel makes no bridge: {error.stderr.strip()}")
        undo.callback(_ip, "link", "del", tag)
        _ip("addr", "add", f"{subnet}.1/24", "dev", tag)
        _ip("link", "set", tag, "up")
        for i, place in enumerate(places, start=2):
            namespace = f"{tag}-{place}"
            _ip("netns", "add", namespace)
            undo.callback(_ip, "netns", "del", namespace)
            _ip("link", "add", f"{tag}{place}", "type", "veth", "peer", "name", "eth0", "netns", namespace)
            undo.callback(_ip, "link", "del", f"{tag}{place}")  # it would outlive its namespace for a moment
            _ip("link", "set", f"{tag}{place}", "master", tag, "up")
            _ip("-n", namespace, "addr", "add", f"{subnet}.{i}/24", "dev", "eth0")
            _ip("-n", namespace, "link", "set", "eth0", "up")
            _ip("-n", namespace, "link", "set", "lo", "up")
        yield made


def _ip(*words: str) -> None:
    subprocess.run(["ip", *words], check=True, capture_output=True, text=True)


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
        queue = JobQueue(redis, WorkerSettings(**SETTINGS))

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
    takes over within seconds; when the network recovers, the first ends its work horse, and works again.
    """
    first = site.start("a")
    view = site.queue.submit(a_heavy_document())
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
    assert site.begun() == [0, 1]
    until(lambda: site.workers() == 2)
    assert first.poll() is None


@pytest.mark.long
def test_redis_is_cut_from_all_workers(site: Site) -> None:
    """The network between Redis and all workers fails, and recovers. The job continues without help and
    succeeds; no worker ends.
    """
    workers = [site.start(place) for place in PLACES]
    view = site.queue.submit(a_heavy_document())
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
    the first is no longer counted.
    """
    first = site.start("a")
    view = site.queue.submit(a_heavy_document())
    until(lambda: site.begun() == [0])
    site.start("b")
    site.network.cut("a")  # not even the closing of its connections is heard
    first.kill()
    until(lambda: site.begun() == [0, 1])
    site.open_gate()
    assert ended(site.queue, view.id).status == "succeeded"
    until(lambda: site.workers() == 1)
