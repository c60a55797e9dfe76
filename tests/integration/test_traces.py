"""Traces from the HTTP request through the queue to the slices, as a collector receives them."""

from __future__ import annotations

import gzip
import re
import subprocess
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import Any

import httpx
import pytest

from tests.support.processes import PATIENCE, completed, environment, started, until
from tests.support.service_server import GEOMETRY, ended
from worker import tracing

SENT_TRACE, SENT_SPAN = "0af7651916cd43dd8448eb211c80319c", "b7ad6b7169203331"


@dataclass
class Collector:
    """Receives spans over OTLP/HTTP, as protobuf."""

    url: str = ""
    spans: list[tuple[str, Any]] = field(default_factory=list)

    def named(self, name: str) -> list[Any]:
        """Returns the spans of this name in the trace that the test began."""
        trace = bytes.fromhex(SENT_TRACE)
        return [span for _, span in self.spans if span.name == name and span.trace_id == trace]

    def services(self) -> set[str]:
        return {service for service, _ in self.spans}


@contextmanager
def collecting() -> Iterator[Collector]:
    wire = pytest.importorskip(
        "opentelemetry.proto.collector.trace.v1.trace_service_pb2", reason="needs rpr-cusps[otel]"
    )
    collector = Collector()

    class Handler(BaseHTTPRequestHandler):
        def do_POST(self) -> None:
            body = self.rfile.read(int(self.headers["content-length"]))
            if self.headers.get("content-encoding") == "gzip":
                body = gzip.decompress(body)
            for part in wire.ExportTraceServiceRequest.FromString(body).resource_spans:
                [name] = [a.value.string_value for a in part.resource.attributes if a.key == "service.name"]
                collector.spans += [(name, span) for scope in part.scope_spans for span in scope.spans]
            self.send_response(200)
            self.send_header("content-type", "application/x-protobuf")
            self.send_header("content-length", "0")
            self.end_headers()

        def log_message(self, *_: object) -> None:
            pass

    with ThreadingHTTPServer(("127.0.0.1", 0), Handler) as server:
        server.daemon_threads = True
        threading.Thread(target=server.serve_forever, args=(0.05,), daemon=True).start()
        collector.url = f"http://127.0.0.1:{server.server_address[1]}"
        yield collector
        server.shutdown()


@contextmanager
def served(data_dir: Path, **variables: str) -> Iterator[tuple[httpx.Client, Path]]:
    """A service with these variables; gives a client and its log."""
    log = data_dir / "serve.log"
    command = [sys.executable, "-m", "service", "serve", "--port", "0", "--workers", "1"]
    command += ["--data-dir", str(data_dir / "data")]
    options = {"env": {**environment(), **variables}, "stdout": subprocess.PIPE, "text": True}
    with log.open("wb") as stderr, started(command, stderr=stderr, **options) as stack:
        assert stack.stdout is not None
        url = re.search(r"http://\S+", stack.stdout.readline())
        assert url is not None
        with httpx.Client(base_url=url[0], timeout=PATIENCE) as client:
            yield client, log
        stack.terminate()
        stack.wait(PATIENCE)


def ask(client: httpx.Client, **headers: str) -> str:
    body = {"geometry": GEOMETRY, "l1": ["27", "14.98"], "digits": 20}
    headers = {"Prefer": "respond-async", **headers}
    job_id: str = client.post("/v1/cusp-tables", json=body, headers=headers).json()["id"]
    assert ended(client, job_id)["status"] == "succeeded"
    return job_id


def test_one_trace_from_the_request_to_the_slices(tmp_path: Path) -> None:
    with collecting() as collector:
        with served(tmp_path, OTEL_EXPORTER_OTLP_ENDPOINT=collector.url, OTEL_BSP_SCHEDULE_DELAY="100") as (
            client,
            _,
        ):
            job_id = ask(client, traceparent=f"00-{SENT_TRACE}-{SENT_SPAN}-01", **{"X-Request-ID": "asked"})
            until(lambda: collector.named("POST /v1/cusp-tables") and collector.named("chunk"))
        [request] = collector.named("POST /v1/cusp-tables")
        assert request.parent_span_id.hex() == SENT_SPAN
        told = {a.key: a.value.string_value or a.value.int_value for a in request.attributes}
        assert told["rpr_cusps.request_id"] == "asked"
        assert told["http.response.status_code"] == 202
        [wait], [chunk] = collector.named("queue wait"), collector.named("chunk")
        assert wait.parent_span_id == chunk.parent_span_id == request.span_id
        assert request.start_time_unix_nano <= wait.start_time_unix_nano <= wait.end_time_unix_nano
        assert wait.end_time_unix_nano <= chunk.start_time_unix_nano
        assert {a.key: a.value.string_value for a in chunk.attributes}["job"] == job_id
        [elimination], slices = collector.named("elimination"), collector.named("slice")
        assert {span.parent_span_id for span in (elimination, *slices)} == {chunk.span_id}
        assert [span.attributes[0].value.string_value for span in slices] == ["27", "14.98"]
        assert collector.services() == {"rpr-cusps-api", "rpr-cusps-worker"}


@pytest.mark.long
def test_a_collector_that_is_gone_costs_no_answer(tmp_path: Path) -> None:
    pytest.importorskip("opentelemetry.sdk", reason="needs rpr-cusps[otel]")
    with served(tmp_path, OTEL_EXPORTER_OTLP_ENDPOINT="http://127.0.0.1:1") as (client, _):
        ask(client)


WITHOUT_SDK = """
import logging, sys
sys.modules["opentelemetry.sdk"] = None
from worker import tracing
logging.basicConfig(format="%(message)s")
print(tracing.prepare("api"))
tracing.start()
with tracing.span("a"):
    print(tracing.carrier())
"""


def test_without_the_sdk_there_is_a_warning_and_no_trace() -> None:
    variables = {**environment(), "OTEL_EXPORTER_OTLP_ENDPOINT": "http://127.0.0.1:1"}
    done = completed([sys.executable, "-c", WITHOUT_SDK], variables, in_full=True)
    assert done.stdout == "False\n{}\n"
    assert done.stderr == (
        "OTEL_EXPORTER_OTLP_ENDPOINT is set, but traces need the SDK; in your copy of "
        "the repository: pip install -c constraints.txt '.[otel]'\n"
    )


def test_without_an_endpoint_nothing_of_the_sdk_is_imported() -> None:
    program = "import sys; from worker import tracing; print(tracing.prepare('api')); tracing.start();"
    program += "print([name for name in sys.modules if name.startswith('opentelemetry')])"
    assert completed([sys.executable, "-c", program], environment(), in_full=True).stdout == "False\n[]\n"
    assert not tracing.is_on()
