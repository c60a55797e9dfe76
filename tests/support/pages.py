"""The fenced blocks of the pages: what language each is in, and whether it is run."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from tests.support.processes import ROOT

PAGES = (
    *(ROOT / name for name in ("README.md", "CONTRIBUTING.md", "examples/README.md")),
    *sorted((ROOT / "docs").glob("**/*.md")),
)

RUN = {"sh", "python", "pycon", "javascript"}
"""Languages of blocks that are executed."""

READ = {"json", "yaml"}
"""Languages of blocks that are parsed."""

SHOWN = {"text", "csv", "xml", "html", "toml", "ini"}
"""What is printed, sent or filled in: nothing that runs by itself."""

NEEDS = {"matlab": "MATLAB", "vb": "Excel", "powershell": "PowerShell", "r": "R", "julia": "Julia"}
"""Languages that are not run here, with what they need."""

_BLOCK = re.compile(
    r"^(?:<!-- not run: (?P<reason>.+?) -->\n(?:<!--.*-->\n)?)?"
    r"```(?P<language>[^\s`]*)[^\n]*\n(?P<text>.*?)^```$(?:\n\n```text\n(?P<printed>.*?)^```$)?",
    re.MULTILINE | re.DOTALL,
)


@dataclass(frozen=True)
class Block:
    """A fenced block.

    Attributes:
        page: the path of its page, in the repository.
        line: where it begins.
        printed: the block of text that follows it at once, or nothing.
        reason: why it is not run, or nothing.
    """

    page: str
    line: int
    language: str
    text: str
    printed: str
    reason: str

    @property
    def name(self) -> str:
        return f"{self.page}:{self.line}"


def _blocks(path: Path) -> Iterator[Block]:
    """The blocks of a page, without the directives of the site."""
    text = path.read_text(encoding="utf-8")
    for found in _BLOCK.finditer(text):
        language = found["language"]
        if not language.startswith("{"):
            needed = f"needs {NEEDS[language]}" if language in NEEDS else ""
            yield Block(
                path.relative_to(ROOT).as_posix(),
                text.count("\n", 0, found.start("language")) + 1,
                language,
                found["text"],
                found["printed"] or "",
                found["reason"] or needed,
            )


BLOCKS = tuple(block for path in PAGES for block in _blocks(path))
NOT_RUN = tuple(block for block in BLOCKS if block.reason)


def blocks_of(page: str, *languages: str) -> list[Block]:
    """The blocks of a page that are run, of some languages."""
    return [b for b in BLOCKS if b.page == page and b.language in languages and not b.reason]


def pages(*languages: str) -> list[str]:
    """The pages that have such blocks."""
    return list(dict.fromkeys(b.page for b in BLOCKS if b.language in languages and not b.reason))
