"""A server that speaks as much of S3 as an archive needs: objects whole and in parts, and lists of them.

Objects are written and read in the same way with Google and Azure. Signatures are not looked at.
(moto, which has all of S3, asks for other versions than matplotlib does.)
"""

from __future__ import annotations

import re
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from datetime import UTC, datetime
from hashlib import md5
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from urllib.parse import parse_qs, unquote, urlsplit
from xml.sax.saxutils import escape, unescape


class Bucket(ThreadingHTTPServer):
    """Its objects by the paths of their addresses; whatever the bucket."""

    daemon_threads = True

    def __init__(self) -> None:
        super().__init__(("127.0.0.1", 0), _Handler)
        self.objects: dict[str, tuple[bytes, datetime]] = {}
        self.is_out_of_order = False

    @property
    def url(self) -> str:
        return f"http://127.0.0.1:{self.server_address[1]}"

    def listing(self, bucket: str, prefix: str) -> str:
        entries = []
        for path, (content, written) in sorted(self.objects.items()):
            key = path.removeprefix(f"{bucket}/")
            if path != key and key.startswith(prefix):
                values = {
                    "Key": key,
                    "LastModified": f"{written:%Y-%m-%dT%H:%M:%S.000Z}",
                    "Size": str(len(content)),
                    "ETag": _tag(content),
                }
                members = "".join(f"<{name}>{escape(value)}</{name}>" for name, value in values.items())
                entries.append(f"<Contents>{members}</Contents>")
        head = f"<Name>{bucket}</Name><KeyCount>{len(entries)}</KeyCount><IsTruncated>false</IsTruncated>"
        return f"<ListBucketResult>{head}{''.join(entries)}</ListBucketResult>"


class _Handler(BaseHTTPRequestHandler):
    protocol_version = "HTTP/1.1"
    server: Bucket

    def log_message(self, *_: object) -> None:
        pass

    @property
    def key(self) -> str:
        return unquote(urlsplit(self.path).path).strip("/")

    def send(self, status: int, content: bytes = b"", **headers: str) -> None:
        self.send_response(status)
        for name, value in {"Content-Length": str(len(content)), **headers}.items():
            self.send_header(name.replace("_", "-"), value)
        self.end_headers()
        if self.command != "HEAD":
            self.wfile.write(content)

    def do_PUT(self) -> None:
        content = self.rfile.read(int(self.headers["Content-Length"] or 0))
        self.server.objects[self.key] = content, datetime.now(UTC)
        self.send(200, ETag=_tag(content))

    def do_POST(self) -> None:
        """Of `?delete`, with the keys in the body."""
        body = self.rfile.read(int(self.headers["Content-Length"])).decode()
        keys = re.findall("<Key>(.*?)</Key>", body)
        for key in keys:
            self.server.objects.pop(f"{self.key}/{unescape(key)}", None)
        done = "".join(f"<Deleted><Key>{key}</Key></Deleted>" for key in keys)
        self.send(200, f"<DeleteResult>{done}</DeleteResult>".encode())

    def do_DELETE(self) -> None:
        """Of Google."""
        self.send(204 if self.server.objects.pop(self.key, None) else 404)

    def do_GET(self) -> None:
        query = parse_qs(urlsplit(self.path).query)
        if "list-type" in query:
            self.send(200, self.server.listing(self.key, query.get("prefix", [""])[0]).encode())
        elif self.server.is_out_of_order:
            self.send(503)
        elif self.key not in self.server.objects:
            self.send(404, b"<Error><Code>NoSuchKey</Code></Error>")
        else:
            self.send_object(*self.server.objects[self.key])

    do_HEAD = do_GET  # noqa: N815

    def send_object(self, content: bytes, written: datetime) -> None:
        headers = {"ETag": _tag(content), "Last_Modified": f"{written:%a, %d %b %Y %H:%M:%S GMT}"}
        asked = self.headers.get("Range")
        if asked is None:
            self.send(200, content, **headers)
            return
        first, last = (int(part) for part in asked.removeprefix("bytes=").split("-"))
        if first >= len(content):
            self.send(416)
            return
        part, end = content[first : last + 1], min(last, len(content) - 1)
        self.send(206, part, Content_Range=f"bytes {first}-{end}/{len(content)}", **headers)


def _tag(content: bytes) -> str:
    return f'"{md5(content, usedforsecurity=False).hexdigest()}"'


@contextmanager
def serving_s3() -> Iterator[Bucket]:
    """The server, until it is shut down or the block ends."""
    server = Bucket()
    thread = threading.Thread(target=server.serve_forever, args=(0.01,), daemon=True)
    thread.start()
    try:
        yield server
    finally:
        server.shutdown()
        server.server_close()
        thread.join()
