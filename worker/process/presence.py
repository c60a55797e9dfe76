"""`python -m worker.process.presence` ends with exit status 0 if a worker of this host is in RQ's register.

It is for containers, each of which has one worker and a host name of its own. While Redis is away the worker
waits for it, and is healthy.
"""

from __future__ import annotations

import os
import socket
import sys
from typing import cast

from redis.exceptions import RedisError
from rq.worker_registration import get_keys

from worker.connection import connect
from worker.jobs.chunks import ChunkQueue
from worker.settings import WorkerSettings


def main() -> int:
    """Look for the worker."""
    with connect(os.environ.get("RPR_CUSPS_REDIS_URL", "")) as redis:
        try:
            names = get_keys(ChunkQueue(redis, WorkerSettings()).queues["small"])
            own = [key for key in names if key.startswith(f"rq:worker:{socket.gethostname()}-")]
            return int(not own or not cast(int, redis.exists(*own)))
        except RedisError:
            return 0


if __name__ == "__main__":
    sys.exit(main())
