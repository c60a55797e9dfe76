"""Slow, dead or many receivers of webhooks."""

from __future__ import annotations

import base64
import time
from pathlib import Path
from typing import Any

import httpx

from tests.support.processes import PATIENCE, until
from tests.support.receivers import receiving, silent
from tests.support.service_server import GEOMETRY
from tests.support.stack import running

TIMEOUT = 60  # of one attempt, in seconds; no test waits for it


def test_a_receiver_that_says_nothing(tmp_path: Path) -> None:
    """A receiver of many events accepts connections, but does not answer. Two of eight senders wait for it,
    and other receivers get their events within a few seconds.
    """
    (tmp_path / "secrets").write_text(f"whsec_{base64.b64encode(bytes(32)).decode()}\n")
    settings = {
        "webhook_hosts": "127.0.0.1,localhost",
        "webhook_networks": "127.0.0.0/8",
        "webhook_secret_file": tmp_path / "secrets",
        "webhook_timeout_seconds": TIMEOUT,
    }

    def asked(number: int, url: str) -> str:
        question: dict[str, Any] = {"geometry": GEOMETRY, "l1": 14 + number / 1000, "l2": 15.5, "l3": 13.9}
        headers = {"Prefer": "respond-async"}
        answer = client.post("/v1/poses", json={**question, "callback_url": url}, headers=headers)
        assert answer.status_code == 202
        return str(answer.json()["links"]["self"])

    def states(url: str) -> list[tuple[str, int]]:
        deliveries = client.get(url).json().get("deliveries", [])
        return [(delivery["state"], len(delivery["attempts"])) for delivery in deliveries]

    with (
        running(tmp_path / "data", **settings) as stack,
        httpx.Client(base_url=stack.base, timeout=PATIENCE) as client,
        receiving() as good,
        silent() as slow,
    ):
        jobs = [asked(number, slow) for number in range(25)]
        until(lambda: all(states(job) for job in jobs))  # all have ended
        start = time.monotonic()
        for number in range(25, 30):
            asked(number, good.url.replace("127.0.0.1", "localhost"))
        until(lambda: len(good.received) == 5)
        took = time.monotonic() - start
        print(f"others were told after {took:.1f} s")  # shown by `pytest -rP`
        assert took < TIMEOUT
        assert sorted(states(job)[0] for job in jobs) == [("pending", 0)] * 23 + [("pending", 1)] * 2
