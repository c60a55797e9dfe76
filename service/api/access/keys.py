"""API keys: random, shown once, and kept as a hash.

A key is `rpr_ID_SECRET`: the id is public and finds the record, the secret has 256 random bits. What is kept
is its SHA-256. A slow hash, as passwords need, would protect nothing here, since no one can search 2^256
secrets, and it would cost each request its time.
"""

from __future__ import annotations

import hashlib
import hmac
import re
import secrets
import string
from dataclasses import dataclass
from typing import Literal

Scope = Literal["read", "submit", "admin"]
State = Literal["valid", "expired", "revoked"]

SCOPES: tuple[Scope, ...] = ("read", "submit", "admin")
"""What a key allows; each includes those before it."""

_ALPHABET = string.digits + string.ascii_letters  # a double click selects the whole key
_ID_LENGTH, _SECRET_LENGTH = 8, 43  # 62^43 > 2^256
_TOKEN = re.compile(rf"rpr_([0-9A-Za-z]{{{_ID_LENGTH}}})_([0-9A-Za-z]{{{_SECRET_LENGTH}}})", re.ASCII)
_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9._@+\-]{0,63}", re.ASCII)


@dataclass(frozen=True)
class ApiKey:
    """What is known of a key once it has been shown. Times are seconds since 1970."""

    id: str
    name: str
    scope: Scope
    digest: str
    created: float
    expires: float | None = None
    revoked: float | None = None

    def state(self, now: float) -> State:
        """Returns whether the key opens anything."""
        if self.revoked is not None:
            return "revoked"
        return "valid" if self.expires is None or now < self.expires else "expired"

    def matches(self, token: str) -> bool:
        """Whether this is the record of `token`; takes the same time for every wrong secret."""
        return hmac.compare_digest(self.digest, _digest(token))


def allows(held: Scope, needed: Scope) -> bool:
    """Whether a scope includes another.

    >>> allows("submit", "read"), allows("submit", "admin")
    (True, False)
    """
    return SCOPES.index(held) >= SCOPES.index(needed)


def make_key(name: str, scope: Scope, now: float, expires: float | None = None) -> tuple[ApiKey, str]:
    """Returns the record of a new key and the key itself, which is in no record."""
    token = f"rpr_{_random(_ID_LENGTH)}_{_random(_SECRET_LENGTH)}"
    key_id = id_of(token)
    assert key_id is not None
    return ApiKey(key_id, name, scope, _digest(token), now, expires), token


def id_of(token: str) -> str | None:
    """Returns the public part of a key, or None if the text is no key.

    >>> id_of("rpr_4fQ8aZ0k_" + 43 * "x")
    '4fQ8aZ0k'
    """
    match = _TOKEN.fullmatch(token)
    return None if match is None else match[1]


def is_name(text: str) -> bool:
    """Whether a key can have this name.

    >>> is_name("calibration-rig.2"), is_name("-x"), is_name("two words")
    (True, False, False)
    """
    return _NAME.fullmatch(text) is not None


def _random(length: int) -> str:
    return "".join(secrets.choice(_ALPHABET) for _ in range(length))


def _digest(token: str) -> str:
    return hashlib.sha256(token.encode()).hexdigest()
