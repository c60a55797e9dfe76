"""gzip for every answer of some size, and validators that tell the encodings apart."""

from __future__ import annotations

from starlette.datastructures import Headers, MutableHeaders
from starlette.middleware.gzip import GZipMiddleware
from starlette.types import Message, Receive, Scope, Send

from service.api.negotiation import media_range

_SUFFIX = '-gzip"'


class Compression(GZipMiddleware):
    """Starlette's compression, which leaves the ETag as it is.

    Another encoding is another representation, so a strong validator must differ (RFC 9110, 8.8.1): what is
    compressed here has an ETag with a suffix, which is taken off again where a client sends it back.
    """

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer one request."""
        if scope["type"] != "http":
            await self.app(scope, receive, send)
            return
        headers = MutableHeaders(scope=scope)
        is_taken = accepts_gzip(headers)
        headers["Accept-Encoding"] = "gzip" if is_taken else "identity"
        known = ",".join(headers.getlist("If-None-Match"))
        if _SUFFIX in known:
            headers["If-None-Match"] = known.replace(_SUFFIX, '"')

        async def send_on(message: Message) -> None:
            if message["type"] == "http.response.start":
                answer = MutableHeaders(scope=message)
                tag = answer.get("ETag", "")
                packed = tag[:-1] + _SUFFIX
                if message["status"] == 304:
                    answer.add_vary_header("Accept-Encoding")
                    is_packed = packed in known and (is_taken or tag not in known)
                else:
                    is_packed = answer.get("Content-Encoding") == "gzip"
                if tag and is_packed:
                    answer["ETag"] = packed
            await send(message)

        await super().__call__(scope, receive, send_on)


def accepts_gzip(headers: Headers) -> bool:
    """Whether the client takes gzip."""
    ranges = map(media_range, ",".join(headers.getlist("Accept-Encoding")).split(","))
    qualities = dict(ranges)
    return qualities.get("gzip", qualities.get("*", 0.0)) > 0
