"""`python -m worker.process.health`: exit status 0 if the worker of this host name is on the roster.

For containers, each of which has one worker and a host name of its own. While Redis is away the worker waits
for it, and is healthy.
"""

from __future__ import annotations

import os
import socket
import sys

from redis.exceptions import RedisError

from worker.connection import connect
from worker.jobs.installation import Roster
from worker.settings import WorkerSettings


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
