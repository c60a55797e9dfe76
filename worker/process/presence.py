"""What others see of a worker, and can ask of it: the roster, RQ's register, and RQ's commands.

`python -m worker.process.presence` ends with exit status 0 if the worker of this host name is on the roster:
for containers, each of which has one worker and a host name of its own. While Redis is away the worker waits
for it, and is healthy.
"""

from __future__ import annotations

import contextlib
import logging
import os
import signal
import socket
import sys
import time
from collections import deque
from collections.abc import Callable, Sequence
from typing import Any

import rq
from redis import Redis
from redis.client import PubSub, PubSubWorkerThread
from redis.exceptions import RedisError
from rq import worker_registration
from rq.command import parse_payload
from rq.serializers import JSONSerializer
from rq.suspension import is_suspended
from rq.utils import now
from rq.worker import WorkerStatus

from worker.connection import connect
from worker.jobs.installation import Roster
from worker.settings import WorkerSettings

log = logging.getLogger("rpr_cusps.worker")

_REGISTER_TTL = 15
_LISTEN_PAUSE = 1.0
_THREAD_SLEEP = 60


class Presence:
    """The entries of a worker in the roster and, for `rq info`, in the register of RQ.

    Both last for seconds only, and are written again and again, since Redis may be emptied.
    """

    def __init__(
        self, redis: Redis, settings: WorkerSettings, name: str, queues: Sequence[rq.Queue], *, is_light: bool
    ) -> None:
        self.redis = redis
        self.name = name
        self._roster = Roster(redis, settings)
        self._is_light = is_light
        with _own_pool(redis) as connection:  # RQ raises the limit on the time of an answer
            self._entry = rq.Worker(queues, name=name, connection=connection, serializer=JSONSerializer)
        self._entry.birth_date = now()

    @property
    def channel(self) -> str:
        """The channel on which RQ sends commands to the worker."""
        return str(self._entry.pubsub_channel_name)

    def beat(self, state: WorkerStatus) -> None:
        """Say that the worker is alive."""
        self._roster.beat(self.name, is_light=self._is_light)
        entry = self._entry
        with self.redis.pipeline(transaction=False) as pipe:
            entry.heartbeat(_REGISTER_TTL, pipe)
            entry.set_state(state, pipe)
            pipe.hset(entry.key, mapping=entry.serialize())
            worker_registration.register(entry, pipe)
            pipe.execute()

    def tidy(self) -> None:
        """Remove workers that are gone from the register of RQ."""
        for queue in self._entry.queues:
            worker_registration.clean_worker_registry(queue)

    def is_suspended(self) -> bool:
        """Whether all workers are to pause (`rq suspend`)."""
        return bool(is_suspended(self.redis))

    def leave(self) -> None:
        """Say that the worker ends."""
        self._roster.leave(self.name)
        with self.redis.pipeline(transaction=False) as pipe:
            worker_registration.unregister(self._entry, pipe)
            pipe.delete(self._entry.key)
            pipe.execute()


class Commands:
    """Receives the commands that RQ sends to a worker, in a thread.

    `stop-job` names a chunk that is to be stopped; `shutdown` ends the worker as Ctrl-C does.
    """

    def __init__(self, redis: Redis, channel: str, wake: Callable[[], None]) -> None:
        self._redis, self._channel, self._wake = redis, channel, wake
        self._stopped: deque[str] = deque()
        self._pubsub: PubSub | None = None
        self._thread: PubSubWorkerThread | None = None

    def listen(self) -> None:
        """Begin to listen, unless that has begun; afterwards redis-py subscribes again by itself."""
        if self._thread is not None:
            return
        self._pubsub = self._redis.pubsub()  # type: ignore[no-untyped-call]
        self._pubsub.subscribe(**{self._channel: self._receive})
        self._thread = self._pubsub.run_in_thread(_THREAD_SLEEP, True, _listen_again)

    def stopped_chunks(self) -> set[str]:
        """Returns the RQ ids of the chunks that were to be stopped since the last call."""
        return {self._stopped.popleft() for _ in range(len(self._stopped))}

    def end(self) -> None:
        """Stop listening."""
        if self._thread is not None and self._pubsub is not None:
            self._thread.stop()
            self._pubsub.unsubscribe()  # type: ignore[no-untyped-call]  # its answer wakes the thread
            self._thread.join(timeout=1)

    def _receive(self, message: dict[str, Any]) -> None:
        command = parse_payload(message)
        if command["command"] == "stop-job" and command.get("job_id"):
            self._stopped.append(command["job_id"])
            self._wake()
        elif command["command"] == "shutdown":
            os.kill(os.getpid(), signal.SIGINT)


def _listen_again(error: BaseException, _pubsub: PubSub, _thread: PubSubWorkerThread) -> None:
    log.debug("cannot listen for commands: %s", error)
    time.sleep(_LISTEN_PAUSE)


@contextlib.contextmanager
def _own_pool(redis: Redis) -> Any:
    """A client with the options of another one, and connections of its own until the end of the block."""
    pool = redis.connection_pool
    own = type(pool)(connection_class=pool.connection_class, **pool.connection_kwargs)
    try:
        yield Redis(connection_pool=own)
    finally:
        own.disconnect()


def main() -> int:
    """Look at the roster."""
    url = os.environ.get("RPR_CUSPS_REDIS_URL", "")
    with connect(url) as redis:
        try:
            names = Roster(redis, WorkerSettings()).names()
        except RedisError:
            return 0
    return int(not any(name.startswith(f"{socket.gethostname()}-") for name in names))


if __name__ == "__main__":
    sys.exit(main())
