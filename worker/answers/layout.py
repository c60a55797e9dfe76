"""How results stand in Redis: the names of their keys, and slices as compressed JSON behind a head.

The head identifies the JSON of a slice, so that a table is looked up by the heads of its slices alone. In the
place of a result that is in the archive stands its address, which has the same head.
"""

from __future__ import annotations

import hashlib
import json
import zlib
from dataclasses import dataclass
from struct import Struct
from typing import TYPE_CHECKING

from rpr_solver import SOLVER_VERSION

if TYPE_CHECKING:
    from worker.settings import WorkerSettings

HEAD_BYTES = 21

_HEAD = Struct(">BI16s")
_PLACE = Struct(">32sQI")
_ERROR_FLAG, _AWAY_FLAG = 1, 2
ADDRESS_BYTES = HEAD_BYTES + _PLACE.size
AWAY = b"\2"
"""What an address begins with; a slice begins with another byte, and the JSON of a document with a brace."""

_ERROR = b'"error":{'
_encode = json.JSONEncoder(separators=(",", ":"), ensure_ascii=False).encode
_LEVEL = 1  # half the bytes in a twentieth of the time of a slice; a higher level saves two per cent more


ERROR_TTL = 600
"""Seconds that a slice's error is kept and other jobs reuse it: its cause may be gone afterwards."""

ARCHIVE_TTL = 365 * 86400
"""Seconds that an answer stays in the archive, since it was moved or asked for last: objects cost little."""


def eliminant_ttl(settings: WorkerSettings) -> int:
    """Returns the seconds that an eliminant is kept: it serves all slices of its geometry."""
    return 4 * settings.result_ttl_seconds


def lifetimes(settings: WorkerSettings) -> list[int]:
    """Returns the lifetimes that a result may have, in seconds, ascending."""
    return sorted({settings.result_ttl_seconds, *([ARCHIVE_TTL] if settings.archive_url else [])})


@dataclass(frozen=True)
class ResultKeys:
    """Key names with one prefix. The keys of results contain the solver's version."""

    prefix: str
    version: str = SOLVER_VERSION

    @classmethod
    def of(cls, settings: WorkerSettings) -> ResultKeys:
        """Returns those of an installation."""
        return cls(settings.key_prefix)

    def slice(self, geometry_hash: str, fixed_leg: int, digits: int, l1: str) -> str:
        """A slice's result; its content never changes. `z`: it is compressed, see `pack`."""
        return f"{self._content('slice', geometry_hash, fixed_leg)}:{digits}:z:{l1}"

    def digits(self, geometry_hash: str, fixed_leg: int) -> str:
        """The set of the digits of a geometry's slice results."""
        return self._content("digits", geometry_hash, fixed_leg)

    def eliminant(self, geometry_hash: str, fixed_leg: int) -> str:
        """The cached eliminant of a geometry."""
        return self._content("eliminant", geometry_hash, fixed_leg)

    def eliminant_use(self, geometry_hash: str, fixed_leg: int) -> str:
        """There once slices of a geometry were asked for."""
        return self._content("eliminant-use", geometry_hash, fixed_leg)

    def eliminant_lock(self, geometry_hash: str, fixed_leg: int) -> str:
        """Held while one worker computes the eliminant."""
        return self._content("eliminant-lock", geometry_hash, fixed_leg)

    def document(self, content_hash: str) -> str:
        """A document that was computed in one piece; the hash depends on the solver's version."""
        return self._by_hash("document", content_hash)

    def document_lock(self, content_hash: str) -> str:
        """Held while one worker computes a document that several jobs need."""
        return self._by_hash("document-lock", content_hash)

    def answer_lock(self, content_hash: str) -> str:
        """Held while one worker answers a question of several batches; documents have another lock."""
        return self._by_hash("answer-lock", content_hash)

    def locks(self, holder: str) -> str:
        """The locks of one holder."""
        return f"{self.prefix}:locks:{holder}"

    def census_digits(self, content_hash: str) -> str:
        """The set of the digits of known whole censuses."""
        return self._by_hash("census-digits", content_hash)

    def question(self, job_id: str) -> str:
        """A question that was answered without a job; its id is that of the job that would answer it."""
        return self._by_hash("question", job_id)

    @property
    def archive(self) -> str:
        """What was moved to the archive, found lost there, and how far the search for the next ones is."""
        return f"{self.prefix}:archive"

    def _content(self, kind: str, geometry_hash: str, fixed_leg: int) -> str:
        return f"{self.prefix}:{kind}:{self.version}:{geometry_hash.removeprefix('sha256:')}:{fixed_leg}"

    def _by_hash(self, kind: str, name: str) -> str:
        return f"{self.prefix}:{kind}-{self.version}:{name}"


@dataclass(frozen=True)
class Measured:
    """What identifies the JSON of a slice without reading it."""

    size: int
    digest: str
    is_error: bool


def dump(value: object) -> str:
    """Returns compact JSON, as it is stored."""
    return _encode(value)


def measured(text: bytes) -> Measured:
    """Returns what identifies JSON at hand."""
    return Measured(len(text), _digest(text).hex(), _ERROR in text)


def pack(text: bytes) -> bytes:
    """Returns the JSON of a slice, or of the error in its place, as it is stored."""
    return _HEAD.pack(_ERROR in text, len(text), _digest(text)) + zlib.compress(text, _LEVEL)


def measured_by(head: bytes) -> Measured:
    """Returns what the head of a stored slice says."""
    flags, size, digest = _HEAD.unpack(head)
    return Measured(size, digest.hex(), bool(flags & _ERROR_FLAG))


def unpack(stored: bytes) -> bytes:
    """Returns the JSON of a stored slice."""
    return zlib.decompress(stored[HEAD_BYTES:])


@dataclass(frozen=True)
class Address:
    """Where a packed result is in the archive: in which object, by its SHA-256, and from which byte on."""

    measured: Measured
    object: bytes
    offset: int
    size: int

    @classmethod
    def of(cls, packed: bytes, name: bytes, offset: int) -> Address:
        """Returns the address of a packed result."""
        return cls(measured_by(packed[:HEAD_BYTES]), name, offset, len(packed))

    @property
    def end(self) -> int:
        """The first byte behind it."""
        return self.offset + self.size

    def to_bytes(self) -> bytes:
        """Returns it as it stands in Redis."""
        head = _HEAD.pack(_AWAY_FLAG, self.measured.size, bytes.fromhex(self.measured.digest))
        return head + _PLACE.pack(self.object, self.offset, self.size)

    def is_of(self, packed: bytes) -> bool:
        """Whether these bytes are what was put there."""
        if packed[:HEAD_BYTES] != _HEAD.pack(0, self.measured.size, bytes.fromhex(self.measured.digest)):
            return False
        try:
            return measured(unpack(packed)) == self.measured
        except zlib.error:
            return False


def address_in(stored: bytes) -> Address:
    """The inverse of :meth:`Address.to_bytes`."""
    return Address(measured_by(stored[:HEAD_BYTES]), *_PLACE.unpack(stored[HEAD_BYTES:]))


def _digest(text: bytes) -> bytes:
    return hashlib.blake2b(text, digest_size=16).digest()
