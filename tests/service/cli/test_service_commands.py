"""Commands that run or manage a service: its settings, worker, keys and store."""

from __future__ import annotations

import json
import sys
from pathlib import Path

import httpx
import pytest
from pydantic_settings import BaseSettings

from docs import reference
from service.api.settings import Settings
from service.cli.serve import models, unknown_settings
from service.schemas.limits import Limits
from service.stack.embedded_valkey import EmbeddedValkey
from tests.support.cli_process import Run, run
from tests.support.processes import completed, environment, until
from tests.support.service_server import serving
from tests.support.template import starts_forked
from worker.connection import connect
from worker.process.pool import WorkerPool
from worker.settings import EnvironmentSettings, WorkerSettings


def test_a_slip_is_told_with_the_setting_that_was_meant() -> None:
    given = {
        "RPR_CUSPS_MAXSLICES": "1",
        "RPR_CUSPS_MAX_SLICES": "1",
        "rpr_cusps_deadline_seconds": "1",
        "RPR_CUSPS_TASK": "a constant",
        "RPR_CUSPS_COLOUR_OF_THE_SKY": "1",
        "OTHER": "1",
    }
    assert list(unknown_settings(given)) == [
        "RPR_CUSPS_COLOUR_OF_THE_SKY is not a setting and has no effect",
        "RPR_CUSPS_MAXSLICES is not a setting and has no effect; did you mean RPR_CUSPS_MAX_SLICES?",
        "RPR_CUSPS_TASK is not a setting and has no effect",
    ]


def test_every_setting_is_known_and_in_the_reference() -> None:
    models_of = {m for base in (BaseSettings, EnvironmentSettings) for m in base.__subclasses__()}
    written = {m for m in models_of if m.__module__.startswith(("worker.", "service."))}
    assert {*written, Limits} - {EnvironmentSettings} == set(models()) == set(reference.GROUPS.values())


@pytest.mark.parametrize("command", ["serve"])
def test_each_process_of_the_service_tells(command: str) -> None:
    nobody = ["--redis-url", "redis://127.0.0.1:1/none"]
    words = [sys.executable, "-m", "service", command, *nobody]
    done = completed(words, environment(log_levle="INFO"))
    told = [line for line in done.stderr.splitlines() if "LEVLE" in line]
    hint = "did you mean RPR_CUSPS_LOG_LEVEL?"
    slip = "RPR_CUSPS_LOG_LEVLE"
    assert told == [f"rpr-cusps {command}: {slip} is not a setting and has no effect; {hint}"]
    assert done.returncode != 0, "it cannot reach Redis"


def test_a_server_that_cannot_be_used() -> None:
    done = run("worker", "--redis-url", "redis://127.0.0.1:1", RPR_CUSPS_REDIS_PASSWORD_FILE="nothing")
    assert (done.returncode, done.stdout) == (1, "")
    assert done.stderr.startswith("rpr-cusps worker: cannot reach Redis: ")
    assert done.stderr.count("\n") == 1


def test_an_invalid_setting(run_here: Run, tmp_path: Path) -> None:
    worker = ("worker", "--redis-url", f"unix://{tmp_path}/nothing.sock")
    done = run_here(*worker, RPR_CUSPS_DEADLINE_SECONDS="-1")
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr.startswith("rpr-cusps worker: RPR_CUSPS_DEADLINE_SECONDS: ")
    assert "(it is '-1')" in done.stderr
    done = run_here(*worker, RPR_CUSPS_RESULT_TTL_SECONDS="0")
    assert "greater than 0 (it is '0')" in done.stderr


def test_constants_do_not_come_from_the_environment(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("RPR_CUSPS_TASK", "tests.support.hard_tasks.endless")
    monkeypatch.setenv("RPR_CUSPS_MAX_DIGITS", "20")
    assert WorkerSettings() == WorkerSettings.model_construct()
    assert Limits.of_environment() == Limits()
    assert WorkerSettings(task="another").task == "another"


def test_a_key_from_its_making_to_its_end(run_here: Run, tmp_path: Path) -> None:
    """The server of the data directory runs all the time; the service begins later."""
    here = ("--data-dir", str(tmp_path))
    with EmbeddedValkey(tmp_path) as valkey:
        made = run_here("keys", "create", "rig", *here)
        assert made.returncode == 0
        first, undo = made.stderr.splitlines()
        assert first == "key rig (scope submit, does not expire); this is shown only once:"
        assert "from now on every client needs one" in undo
        assert "rpr-cusps serve --insecure" in undo
        key = made.stdout.strip()
        header = {"Authorization": f"Bearer {key}"}
        with serving(Settings(redis_url=valkey.url)) as url:
            assert httpx.get(f"{url}/v1/limits").status_code == 401
            assert httpx.get(f"{url}/v1/limits", headers=header).status_code == 200
            [listed] = json.loads(run_here("keys", "list", "--format", "json", *here).stdout)
            assert (listed["name"], listed["id"], listed["state"]) == ("rig", key.split("_")[1], "valid")
            assert listed["last_used"] is not None
            revoked = run_here("keys", "revoke", listed["id"], *here)
            assert revoked.returncode == 0
            assert (
                "no valid key is left, and every client still needs one; `rpr-cusps serve --ins"
                in revoked.stderr
            )
            until(lambda: httpx.get(f"{url}/v1/limits", headers=header).status_code == 401)
        assert run_here("keys", "list", *here).stdout.splitlines()[1].split()[:4] == [
            *(listed["id"], "rig", "submit", "revoked"),
        ]
        with serving(Settings(redis_url=valkey.url, require_keys="never")) as url:  # as with --insecure
            assert httpx.get(f"{url}/v1/limits").status_code == 200
        again = run_here("keys", "create", "rig", *here)
        assert (again.returncode, again.stderr.count("\n")) == (0, 1)  # the name is free again


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
        (("revoke", "nobody"), "NAME: 'nobody' is the name or id of no valid key; keys list shows all"),
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


@pytest.mark.slow
def test_solve_sends_the_key_of_the_environment(run_here: Run, valkey: EmbeddedValkey) -> None:
    redis = f"{valkey.url}?db=7"  # once there has been a key, the services of other tests would ask for one
    pool = WorkerPool(1, redis)
    with starts_forked():
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


@pytest.fixture
def data_dir(tmp_path: Path) -> Path:
    """The data of a service that is not running: a slice with a day left, and an API key."""
    with EmbeddedValkey(tmp_path) as server, connect(server.url) as redis:
        redis.set("cusps:slice:2:ab:1:90:27", "x" * 1000, ex=86400)
        redis.hset("cusps:keys", "a", "b")
    return tmp_path


def test_of_a_data_directory(run_here: Run, data_dir: Path) -> None:
    where = ("--data-dir", str(data_dir))
    table = run_here("store", "status", *where)
    assert [line.split()[:2] for line in table.stdout.splitlines() if "1" in line] == [
        ["slice", "1"],
        ["other", "1"],
        ["all", "2"],
    ]
    status = json.loads(run_here("store", "status", *where, "--format", "json").stdout)
    assert status["slice"]["keys"] == 1
    assert status["slice"]["oldest"] == pytest.approx(6 * 86400, abs=60)
    assert run_here("store", "prune", "--older-than", "7d", *where).stdout == "removed 0 keys, 0 B\n"
    assert run_here("store", "prune", "--max-bytes", "1kB", *where).stdout.startswith("removed 1 keys, 1.")


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["prune"], "--older-than: or --max-bytes is missing; give one of them, or both"),
        (["prune", "--older-than", "3 weeks"], "'3 weeks' is not an age, such as 90s, 30m, 12h or 30d"),
    ],
)
def test_bad_options(run_here: Run, words: list[str], message: str) -> None:
    done = run_here("store", *words)
    assert (done.returncode, done.stdout) == (2, "")
    assert message in done.stderr


def test_redis_is_not_there(run_here: Run) -> None:
    done = run_here("store", "status", "--redis-url", "redis://127.0.0.1:1/0")
    assert done.returncode == 3
    assert done.stderr.startswith("rpr-cusps store: cannot reach Redis: ")
