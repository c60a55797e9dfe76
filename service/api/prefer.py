"""The Prefer header (RFC 7240)."""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass

_TOKEN = r"[!#$%&'*+\-.^_`|~0-9A-Za-z]+"
_QUOTED = r'"(?:[^"\\]|\\.)*"'
_PAIR = re.compile(rf"\s*({_TOKEN})\s*(?:=\s*({_TOKEN}|{_QUOTED})?)?\s*", re.ASCII)


@dataclass(frozen=True)
class Preferences:
    """The preferences of a client: a response without waiting, or the number of seconds to wait; and results
    of a batch in the order in which they are done."""

    respond_async: bool = False
    wait: int | None = None
    by_completion: bool = False

    def applied(self, waited: int | None, accepted: bool) -> str | None:
        """Returns the Preference-Applied header of a response after at most `waited` seconds."""
        parts = [f"wait={waited}"] if waited is not None else []
        if self.respond_async and accepted:
            parts.insert(0, "respond-async")
        return ", ".join(parts) or None


def parse_prefer(headers: Iterable[str]) -> Preferences:
    """Read all Prefer headers of a request.

    As the RFC requires, the first of repeated preferences counts, names are case-insensitive, and unknown or
    malformed preferences are ignored.

    >>> parse_prefer(['respond-async; x="1,2", Wait = 10', "wait=3"])
    Preferences(respond_async=True, wait=10, by_completion=False)
    """
    preferences: dict[str, str] = {}
    for header in headers:
        for preference in _split(header, ","):
            first = _split(preference, ";")[0]
            if match := _PAIR.fullmatch(first):
                preferences.setdefault(match[1].lower(), _unquoted(match[2] or ""))
    wait = preferences.get("wait", "")
    seconds = int(wait[:10]) if wait.isascii() and wait.isdigit() else None
    by_completion = preferences.get("order", "").lower() == "completion"
    return Preferences("respond-async" in preferences, seconds, by_completion)


def _split(text: str, separator: str) -> list[str]:
    """Split at separators outside quoted strings."""
    return re.findall(rf'(?:[^{separator}"]|{_QUOTED}|")+', text) or [""]


def _unquoted(value: str) -> str:
    return re.sub(r"\\(.)", r"\1", value[1:-1]) if value.startswith('"') else value
