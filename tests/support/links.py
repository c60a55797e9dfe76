"""Links and anchors of Markdown files, as GitHub and the site read them."""

from __future__ import annotations

import re
from collections.abc import Iterator
from functools import cache
from itertools import pairwise
from pathlib import Path
from urllib.parse import unquote, urlsplit

from markdown_it import MarkdownIt
from markdown_it.token import Token


def tokens(path: Path) -> Iterator[Token]:
    """The tokens of a file, those within lines too."""
    for token in MarkdownIt("commonmark").enable("table").parse(path.read_text(encoding="utf-8")):
        yield token
        yield from token.children or ()


@cache
def anchors(path: Path) -> frozenset[str]:
    """The anchors that GitHub gives the headings of a file."""
    found: dict[str, int] = {}
    names = set()
    lines = list(tokens(path))
    for token, content in pairwise(lines):
        if token.type == "heading_open":
            text = "".join(part.content for part in content.children or ())
            name = re.sub(r"[^\w\- ]", "", text.lower()).replace(" ", "-")
            number = found[name] = found.get(name, -1) + 1
            names.add(f"{name}-{number}" if number else name)
    return frozenset(names)


def broken(path: Path) -> Iterator[str]:
    """The links and pictures of a file that lead nowhere in this checkout."""
    for token in tokens(path):
        address = token.attrs.get("href") or token.attrs.get("src")
        parts = urlsplit(str(address or ""))
        if not address or parts.scheme:
            continue
        target = (path.parent / unquote(parts.path)).resolve() if parts.path else path
        if not target.exists() or (parts.fragment and parts.fragment not in anchors(target)):
            yield f"{path.name}: {address}"
