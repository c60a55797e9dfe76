"""gzip for larger responses, with validators that distinguish the encodings."""

from __future__ import annotations

from starlette.datastructures import Headers, MutableHeaders
from starlette.middleware.gzip import GZipMiddleware
from starlette.types import Message, Receive, Scope, Send

from service.api.negotiation import media_range

_SUFFIX = '-gzip"'


class Compression(GZipMiddleware):
    """Starlette's compression with correct ETags.

    Another encoding is another representation, so its strong validator must differ (RFC 9110, 8.8.1):
    compressed responses have an ETag with a suffix, which is removed again from `If-None-Match`.
    """

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer one request."""
        if scope["type"] != "http":
            await self.app(scope, receive, send)
            return
        headers = MutableHeaders(scope=scope)
        is_accepted = accepts_gzip(headers)
        headers["Accept-Encoding"] = "gzip" if is_accepted else "identity"
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
                    is_packed = packed in known and (is_accepted or tag not in known)
                else:
                    is_packed = answer.get("Content-Encoding") == "gzip"
                if tag and is_packed:
                    answer["ETag"] = packed
            await send(message)

        await super().__call__(scope, receive, send_on)


def accepts_gzip(headers: Headers) -> bool:
    """Whether the client accepts gzip."""
    ranges = map(media_range, ",".join(headers.getlist("Accept-Encoding")).split(","))
    qualities = dict(ranges)
    return qualities.get("gzip", qualities.get("*", 0.0)) > 0
