"""`rpr-cusps keys`, on a service that runs and on one that does not."""

from __future__ import annotations

import json
from pathlib import Path

import httpx
import pytest

from service.api.settings import Settings
from service.stack.embedded_valkey import EmbeddedValkey
from tests.support.cli_process import Run
from tests.support.processes import until
from tests.support.service_server import serving
from worker.process.pool import WorkerPool


def test_a_key_from_its_making_to_its_end(run_here: Run, tmp_path: Path) -> None:
    """The server of the data directory runs all the time; the service begins later."""
    here = ("--data-dir", str(tmp_path))
    with EmbeddedValkey(tmp_path) as valkey:
        made = run_here("keys", "create", "rig", *here)
        assert (made.returncode, made.stderr) == (
            0,
            "key rig (scope submit, does not expire); this is shown only once:\n",
        )
        key = made.stdout.strip()
        header = {"Authorization": f"Bearer {key}"}
        with serving(Settings(redis_url=valkey.url)) as url:
            assert httpx.get(f"{url}/v1/limits").status_code == 401
            assert httpx.get(f"{url}/v1/limits", headers=header).status_code == 200
            [listed] = json.loads(run_here("keys", "list", "--format", "json", *here).stdout)
            assert (listed["name"], listed["id"], listed["state"]) == ("rig", key.split("_")[1], "valid")
            assert listed["last_used"] is not None
            assert run_here("keys", "revoke", listed["id"], *here).returncode == 0
            until(lambda: httpx.get(f"{url}/v1/limits", headers=header).status_code == 401)
        assert run_here("keys", "list", *here).stdout.splitlines()[1].split()[:4] == [
            *(listed["id"], "rig", "submit", "revoked"),
        ]
        assert run_here("keys", "create", "rig", *here).returncode == 0  # the name is free again


def test_keys_of_a_service_that_does_not_run(run_here: Run, tmp_path: Path) -> None:
    here = ("--data-dir", str(tmp_path))
    made = run_here("keys", "create", "--scope", "read", "--days", "3", *here, "night.shift")
    assert "scope read, expires at 2" in made.stderr
    [listed] = json.loads(run_here("keys", "list", "--format", "json", *here).stdout)
    assert (listed["name"], listed["scope"], listed["last_used"]) == ("night.shift", "read", None)
    assert made.stdout.strip() not in json.dumps(listed)


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("create", "two words"), "NAME: 'two words' cannot be the name of a key; give 1 to 64 letters"),
        (("create", "x", "--days", "0"), "argument --days: '0' is not a number of days from 1 to 36500"),
        (("create", "x", "--scope", "root"), "argument --scope: invalid choice: 'root'"),
        (("revoke", "nobody"), "NAME: 'nobody' is the name or id of no valid key; keys list shows all"),
        ((), "the following arguments are required: ACTION"),
    ],
)
def test_what_cannot_be_done_is_said(
    run_here: Run, tmp_path: Path, arguments: tuple[str, ...], said: str
) -> None:
    where = ("--data-dir", str(tmp_path)) if arguments else ()
    done = run_here("keys", *arguments, *where)
    assert (done.returncode, done.stdout, done.stderr.count("\n")) == (2, "", 1)
    assert said in done.stderr


def test_a_name_is_given_once(run_here: Run, valkey: EmbeddedValkey) -> None:
    here = ("--redis-url", f"{valkey.url}?db=3")
    run_here("keys", "create", "once", *here)
    again = run_here("keys", "create", "once", *here)
    assert (again.returncode, again.stdout) == (2, "")
    assert "'once' is the name of a key already" in again.stderr


def test_a_redis_that_is_not_there(run_here: Run, tmp_path: Path) -> None:
    done = run_here("keys", "list", "--redis-url", f"unix://{tmp_path}/nothing.sock")
    assert (done.returncode, done.stderr.count("\n")) == (3, 1)
    assert "cannot reach Redis" in done.stderr


@pytest.mark.slow
def test_solve_sends_the_key_of_the_environment(run_here: Run, valkey: EmbeddedValkey) -> None:
    redis = f"{valkey.url}?db=7"  # once there has been a key, the services of other tests would ask for one
    pool = WorkerPool(1, redis)
    pool.start()
    try:
        with serving(Settings(redis_url=redis, require_keys="always")) as url:
            question = ("solve", "innocenti", "--l1", "14.98", "--digits", "15", "--url", url)
            refused = run_here(*question)
            assert (refused.returncode, "This service requires a key" in refused.stderr) == (2, True)
            key = run_here("keys", "create", "solver", "--redis-url", redis).stdout.strip()
            assert run_here(*question, RPR_CUSPS_API_KEY=key).returncode == 0
    finally:
        pool.stop()
