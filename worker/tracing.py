"""Traces by OpenTelemetry, from the HTTP request through the queue to the slices.

They are on where an endpoint is set (`OTEL_EXPORTER_OTLP_ENDPOINT`) and the SDK is installed; otherwise every
function here does nothing, and nothing of OpenTelemetry is imported. The SDK reads its own variables, such as
`OTEL_TRACES_SAMPLER`, `OTEL_EXPORTER_OTLP_HEADERS` and `OTEL_SERVICE_NAME`.
"""

from __future__ import annotations

import atexit
import logging
import os
import threading
import time
from collections.abc import Mapping
from contextlib import AbstractContextManager, nullcontext
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from opentelemetry.sdk.trace import TracerProvider
    from opentelemetry.trace import Tracer

log = logging.getLogger("rpr_cusps.tracing")

_INSTALL = "in your copy of the repository: pip install -c constraints.txt '.[otel]'"
ENDPOINTS = ("OTEL_EXPORTER_OTLP_TRACES_ENDPOINT", "OTEL_EXPORTER_OTLP_ENDPOINT")

_TIMEOUT = 2.0
_LAST_SPANS_PATIENCE = 0.3  # a collector that hangs costs each chunk no more

_tracer: Tracer | None = None
_provider: TracerProvider | None = None
_role = ""


def is_on() -> bool:
    """Whether spans are recorded in this process."""
    return _tracer is not None


def prepare(role: str) -> bool:
    """Import the SDK if traces are wanted, and say so if it is missing; returns whether there can be traces.

    A worker does this before it forks, and :func:`start` in the fork, since the SDK has a thread.
    """
    global _role
    name = next((name for name in ENDPOINTS if os.environ.get(name)), None)
    if name is None or os.environ.get("OTEL_SDK_DISABLED", "").lower() == "true":
        return False
    try:
        import opentelemetry.exporter.otlp.proto.http.trace_exporter
        import opentelemetry.sdk.trace.export  # noqa: F401
    except ImportError:
        log.warning("%s is set, but traces need the SDK; %s", name, _INSTALL)
        return False
    _role = role
    return True


def start() -> None:
    """Record spans from now on, if :func:`prepare` has found that there can be any."""
    global _tracer, _provider
    if not _role:
        return
    from opentelemetry.exporter.otlp.proto.http.trace_exporter import OTLPSpanExporter
    from opentelemetry.sdk.resources import Resource
    from opentelemetry.sdk.trace import TracerProvider
    from opentelemetry.sdk.trace.export import BatchSpanProcessor

    name = os.environ.get("OTEL_SERVICE_NAME", f"rpr-cusps-{_role}")
    _provider = TracerProvider(resource=Resource.create({"service.name": name}), shutdown_on_exit=False)
    _provider.add_span_processor(BatchSpanProcessor(OTLPSpanExporter(timeout=_TIMEOUT)))
    _tracer = _provider.get_tracer("rpr_cusps")
    atexit.register(flush)


def span(
    name: str,
    parent: Mapping[str, str] | None = None,
    attributes: Mapping[str, Any] | None = None,
    *,
    is_server: bool = False,
) -> AbstractContextManager[Any]:
    """Record the block as a span of the current one, or of `parent` (as :func:`carrier` or HTTP headers)."""
    if _tracer is None:
        return nullcontext()
    from opentelemetry.trace import SpanKind

    kind = SpanKind.SERVER if is_server else SpanKind.INTERNAL
    return _tracer.start_as_current_span(name, _context(parent), kind=kind, attributes=attributes)


def record(name: str, parent: Mapping[str, str], begin: int, attributes: Mapping[str, Any]) -> None:
    """Record a span that ends now; `begin`: nanoseconds since the epoch."""
    if _tracer is not None:
        end = max(begin, time.time_ns())
        made = _tracer.start_span(name, _context(parent), start_time=begin, attributes=attributes)
        made.end(end)


def describe(name: str, attributes: Mapping[str, Any]) -> None:
    """Rename the current span, and add attributes."""
    if _tracer is not None:
        from opentelemetry.trace import get_current_span

        current = get_current_span()
        current.update_name(name)
        current.set_attributes(attributes)


def carrier() -> dict[str, str]:
    """Returns what continues the current trace in another process; empty without one."""
    found: dict[str, str] = {}
    if _tracer is not None:
        from opentelemetry.trace.propagation.tracecontext import TraceContextTextMapPropagator

        TraceContextTextMapPropagator().inject(found)
    return found


def flush() -> None:
    """Send what is recorded, within a short time."""
    if _provider is not None:
        sender = threading.Thread(target=_provider.force_flush, daemon=True)
        sender.start()
        sender.join(_LAST_SPANS_PATIENCE)


def _context(parent: Mapping[str, str] | None) -> Any:
    if parent is None:
        return None
    from opentelemetry.trace.propagation.tracecontext import TraceContextTextMapPropagator

    return TraceContextTextMapPropagator().extract(parent)
