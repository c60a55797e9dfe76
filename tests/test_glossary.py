"""docs/glossary.md: the pages lead from the first use of a term of the field to its meaning."""

import re
from collections.abc import Iterator
from pathlib import Path

import pytest

DOCS = Path(__file__).parents[1] / "docs"
GLOSSARY = (DOCS / "glossary.md").read_text(encoding="utf-8")

TERMS = {
    "aspect": "aspects?",
    "assembly-mode": "assembly modes?",
    "beak-to-beak": "beak-to-beak",
    "census": "census(?:es)?",
    "certificate": "certificates?",
    "clearance": "clearance",
    "closed-leg": "closed legs?",
    "cusp": "cusps?",
    "cusp-curve": "cusp curves?",
    "degenerate-pose": "degenerate poses?",
    "direct-kinematics": "direct kinematics",
    "eliminant": "eliminants?",
    "fold": "folds?",
    "joint-limits": "joint limits",
    "joint-space": "joint space",
    "joint-vector": "joint vectors?",
    "lips": "lips",
    "loop": "loops? round",
    "node": "nodes?",
    "pose": "poses?",
    "singular-curve": "singular curves?",
    "singular-pose": "singularit(?:y|ies)|singular poses?",
    "slice": "slices?",
    "swallowtail": "swallowtails?",
    "transition": "transitions?",
    "window": "windows?",
}
"""Entry of the glossary → how pages write the term."""

ABOUT_THE_CODE = {
    "architecture",
    "glossary",
    "index",
    "mathematics",
    "referees",
    "reference",
    "reliability",
    "testing",
    "worker",
}
"""Pages that are lists, are written from the code, or define their terms themselves."""

PAGES = sorted({path.stem for path in DOCS.glob("*.md")} - ABOUT_THE_CODE)

NOT_PROSE = re.compile(
    r"^<!-- \w+ -->$.*?^<!-- end -->$|^```.*?^```$|^\|.*?$|^#.*?$|^ {4,}\S.*?$|<!--.*?-->"
    r"|`[^`]*`|!\[[^\]]*\]\([^)]*\)",
    re.MULTILINE | re.DOTALL,
)
LINK = re.compile(r"\[[^\]]*\]\([^)]*\)")
OTHER_MEANINGS = re.compile(
    r"for Windows|\bNode\b(?:,| has)|in Node\b|node\s+of\s+a\s+Redis|receiver's\s+certificate"
    r"|trusted\s+certificates|\*An\s+Algorithm\s[^*]*\*"
)


def prose(text: str) -> str:
    """A page with blanks in the place of code, tables, headings and pictures."""
    for other in (NOT_PROSE, OTHER_MEANINGS):
        text = other.sub(lambda found: re.sub(r"\S", " ", found[0]), text)
    return text


def first_uses(page: str) -> Iterator[tuple[str, int]]:
    """The terms of a page that its prose has, each with the place of its first use."""
    text = prose((DOCS / f"{page}.md").read_text(encoding="utf-8"))
    longest = sorted(TERMS, key=lambda term: -len(TERMS[term]))
    for term in longest:
        forms = re.sub(" ", r"\\s+", TERMS[term])
        found = re.search(rf"(?<![\w-])(?:{forms})(?![\w-])", text, re.IGNORECASE)
        if found:
            yield term, found.start()


@pytest.mark.parametrize("page", PAGES)
def test_the_first_use_of_a_term_is_a_link(page: str) -> None:
    text = (DOCS / f"{page}.md").read_text(encoding="utf-8")
    linked = [range(*found.span()) for found in LINK.finditer(text)]
    bare = [term for term, place in first_uses(page) if not any(place in link for link in linked)]
    assert not bare, "link them to docs/glossary.md, or to the page about them"


def test_the_glossary_has_these_terms() -> None:
    headings = re.findall(r"^### (.+)$", GLOSSARY, re.MULTILINE)
    entries = {heading.lower().replace(" ", "-") for heading in headings}
    assert entries >= TERMS.keys()
    assert len(entries) == len(headings), "a term is defined twice"
