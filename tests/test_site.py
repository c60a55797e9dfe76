"""The site of the pages: it builds, and what is wrong in it is seen."""

from __future__ import annotations

import re
from pathlib import Path
from xml.etree import ElementTree

import pytest

from docs import build_site
from tests.support.links import broken

ROOT = Path(__file__).parents[1]
PAGES = {path.stem for path in (ROOT / "docs").glob("*.md")}


def test_broken_links_are_seen(tmp_path: Path) -> None:
    page = tmp_path / "page.md"
    page.write_text(
        "# A `b`, c\n[x](#a-b-c) [y](#b) ![z](z.svg) [w](page.md#a-b-c) [v](https://example.com/v)\n"
    )
    assert list(broken(page)) == ["page.md: #b", "page.md: z.svg"]


PARTS = {"msub": 2, "msup": 2, "mover": 2, "mfrac": 2, "msubsup": 3}
"""Elements of MathML that browsers show only with so many parts."""


def misshapen(page: str) -> list[str]:
    """The formulas of a page that a browser would not show as they are meant."""
    wrong = []
    for formula in re.findall(r"<math.*?</math>", page, re.DOTALL):
        tree = ElementTree.fromstring(formula)
        parts = [(element.tag.rpartition("}")[2], len(element)) for element in tree.iter()]
        if any(PARTS.get(tag, number) != number for tag, number in parts):
            wrong.append("".join(tree.itertext()))
    return wrong


def test_formulas_become_mathml_and_an_unknown_command_is_refused() -> None:
    pytest.importorskip("sphinx", reason="needs the extra `docs`")
    from docs.mathml import mathml

    set_ = mathml(r"J_1'^2 ≠ −\operatorname{Res}_t \sin^k α", "inline")
    assert "".join(ElementTree.fromstring(set_).itertext()) == "J1′2≠−Restsinkα"
    assert misshapen(set_) == []
    assert misshapen("<p><math><msub><mi>a</mi></msub></math></p>") == ["a"]
    with pytest.raises(ValueError, match="nosuch"):
        mathml(r"\nosuch x", "inline")


@pytest.mark.long
def test_the_site_builds_without_a_warning_and_every_link_in_it_leads_somewhere(tmp_path: Path) -> None:
    pytest.importorskip("sphinx", reason="needs the extra `docs`")
    assert build_site.main([str(tmp_path / "site")]) == 0
    built = {path.stem: path.read_text(encoding="utf-8") for path in (tmp_path / "site").glob("*.html")}
    assert built.keys() >= PAGES
    assert {name: wrong for name, page in built.items() if (wrong := misshapen(page))} == {}
    assert "<math" in built["mathematics"]


def test_faults_of_a_site_are_seen(tmp_path: Path) -> None:
    (tmp_path / "index.html").write_text(
        '<h1 id="top"><a href="#top">a</a><a href="#to">b</a><a href="other.html#x">c</a>'
        '<a href="no.html">d</a><img src="https://example.com/x.png">'
        '<script src="//example.com/x.js"></script><img src="no.png">'
    )
    (tmp_path / "other.html").write_text('<p id="x"><a href="https://example.com">e</a>')
    assert list(build_site.faults(tmp_path)) == [
        "index.html: https://example.com/x.png is loaded from outside",
        "index.html: //example.com/x.js is loaded from outside",
        "index.html: #to has no such anchor",
        "index.html: no.html leads nowhere",
        "index.html: no.png leads nowhere",
    ]
