"""docker/monitoring and the runbook: in step with each other, and with the metrics of a running service."""

from __future__ import annotations

import json
import re
import shutil
import socket
import subprocess
import time
from itertools import count
from pathlib import Path
from typing import Any

import httpx
import pytest
import yaml

from docs.reference import families
from tests.support.processes import PATIENCE, started
from tests.support.service_server import GEOMETRY
from tests.support.stack import running

ROOT = Path(__file__).parents[1]
FOLDER = ROOT / "docker" / "monitoring"
RULES: list[dict[str, Any]] = yaml.safe_load((FOLDER / "rules.yaml").read_text())["groups"][0]["rules"]
ALERTS: dict[str, str] = {rule["alert"]: rule["expr"] for rule in RULES}
PANELS: list[dict[str, Any]] = json.loads((FOLDER / "dashboard.json").read_text())["panels"]
QUERIES = [
    target["expr"].replace("$job", ".+").replace("$__rate_interval", "1m")
    for panel in PANELS
    for target in panel["targets"]
]
NEEDS_PROMETHEUS = pytest.mark.skipif(
    not (shutil.which("promtool") and shutil.which("prometheus")), reason="needs prometheus and promtool"
)
METRICS = {
    family.name + ending: {*family.labels, *(("le",) if ending == "_bucket" else ()), "instance", "job"}
    for group in families().values()
    for family in group
    for ending in (("_bucket", "_sum", "_count") if family.kind == "histogram" else ("",))
}
RESULT = re.compile(r"(?:by|without) \(([\w, ]+)\)")


def named(query: str) -> dict[str, set[str]]:
    """The metrics of a query, each with the labels that it selects by."""
    found: dict[str, set[str]] = {}
    for name, selector in re.findall(r"\b(rpr_cusps_\w+)(?:\{([^}]*)\})?", query):
        found.setdefault(name, set()).update(re.findall(r"(\w+)(?==~|!~|!=|=)", selector or ""))
    return found


@pytest.mark.parametrize("query", [*ALERTS.values(), *QUERIES])
def test_every_query_names_metrics_and_labels_that_there_are(query: str) -> None:
    assert named(query)
    known = {"instance", "job"}
    for name, labels in named(query).items():
        assert labels <= METRICS[name]
        known |= METRICS[name]
    for grouped in RESULT.findall(query):
        assert {label.strip() for label in grouped.split(",")} <= known


def test_every_metric_of_the_installation_is_on_the_dashboard() -> None:
    shown = {name for query in QUERIES for name in named(query)}
    assert {re.sub("_(bucket|sum|count)$", "", name) for name in METRICS} - {
        re.sub("_(bucket|sum|count)$", "", name) for name in shown
    } == set()


def test_every_alert_is_tested_and_in_the_runbook() -> None:
    tests = yaml.safe_load((FOLDER / "rules_test.yaml").read_text())["tests"]
    expected = [check for test in tests for check in test["alert_rule_test"]]
    for wanted in (True, False):
        assert {c["alertname"] for c in expected if bool(c["exp_alerts"]) is wanted} == set(ALERTS)
    page = (ROOT / "docs" / "runbook.md").read_text()
    assert re.findall(r"^## ([A-Z][a-z]+[A-Z]\w+)$", page, re.MULTILINE) == list(ALERTS)
    for rule in RULES:
        assert rule["annotations"]["runbook"] == f"docs/runbook.md#{rule['alert'].lower()}"
    table = re.findall(r"^\| \[(\w+)\]\(runbook.md#(\w+)\) \| `(.*?)` \|", operating(), re.MULTILINE)
    assert [name for name, _, _ in table] == list(ALERTS)
    for name, anchor, expression in table:
        assert anchor == name.lower()
        first = " ".join(ALERTS[name].split()).partition(" or (")[0]
        assert expression.replace("\\|", "|") == first


def operating() -> str:
    return (ROOT / "docs" / "operating.md").read_text()


@NEEDS_PROMETHEUS
def test_the_rules_fire_when_they_should_and_only_then() -> None:
    for words in ("check rules rules.yaml", "test rules rules_test.yaml", "check config prometheus.yaml"):
        done = subprocess.run(
            ["promtool", *words.split()], cwd=FOLDER, capture_output=True, text=True, check=False
        )
        assert done.returncode == 0, done.stdout + done.stderr


def free_port() -> int:
    with socket.socket() as sock:
        sock.bind(("127.0.0.1", 0))
        return int(sock.getsockname()[1])


@pytest.mark.slow
@NEEDS_PROMETHEUS
def test_a_prometheus_answers_every_query_from_a_running_service(tmp_path: Path) -> None:
    """A service with a worker computes tables; Prometheus scrapes it each second."""
    configuration = yaml.safe_load((FOLDER / "prometheus.yaml").read_text())
    with running(tmp_path / "data", workers=1, require_keys="never") as stack:
        configuration["global"] = {"scrape_interval": "1s", "evaluation_interval": "1s"}
        configuration["rule_files"] = [str(FOLDER / "rules.yaml")]
        [scrape] = configuration["scrape_configs"]
        scrape["static_configs"][0]["targets"] = [stack.base.removeprefix("http://")]
        (tmp_path / "prometheus.yaml").write_text(yaml.safe_dump(configuration))
        url = f"http://127.0.0.1:{free_port()}"
        options = {
            "config.file": tmp_path / "prometheus.yaml",
            "storage.tsdb.path": tmp_path / "tsdb",
            "web.listen-address": url.removeprefix("http://"),
        }
        with (
            started(
                ["prometheus", *(f"--{name}={value}" for name, value in options.items())],
                stdout=subprocess.DEVNULL,
                stderr=subprocess.DEVNULL,
            ),
            httpx.Client(base_url=url) as prometheus,
        ):
            unanswered, end = QUERIES, time.monotonic() + PATIENCE
            for number in count(1):  # counters grow between scrapes
                body = {"geometry": GEOMETRY, "l1": f"{number}.98", "digits": 15}
                wait = {"Prefer": "wait=30"}
                assert httpx.post(f"{stack.base}/v1/cusp-tables", json=body, headers=wait).is_success
                time.sleep(1.1)
                unanswered = [query for query in unanswered if not answer(prometheus, query)]
                if not unanswered or time.monotonic() > end:
                    break
            assert unanswered == []
            rules = prometheus.get("/api/v1/rules").json()["data"]["groups"][0]["rules"]
        assert {rule["name"]: (rule["health"], rule["state"]) for rule in rules} == dict.fromkeys(
            ALERTS, ("ok", "inactive")
        )


def answer(prometheus: httpx.Client, query: str) -> list[float]:
    """The values of a query now; none while one of them is no number, or Prometheus is about to start."""
    try:
        found = prometheus.get("/api/v1/query", params={"query": query}).json()
    except (httpx.HTTPError, ValueError):
        return []
    assert found["status"] == "success", (query, found)
    values = [float(series["value"][1]) for series in found["data"]["result"]]
    return values if any(value == value for value in values) else []
