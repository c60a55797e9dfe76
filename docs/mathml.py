"""Formulas of the pages as MathML, which browsers show by themselves, without a script."""

from __future__ import annotations

import re
from typing import Any

from docutils import nodes
from latex2mathml.converter import convert
from sphinx.application import Sphinx
from sphinx.util import logging

NAME = "<mi>[A-Za-z][a-z]+</mi>"
ATOM = "m(?:i|n|sub|sup|subsup)>"
CLOSE = r'<mo stretchy="false" lspace="0" rspace="0">\1</mo>'
CLOSE_2 = CLOSE.replace(r"\1", r"\2")
THIN = r'<mspace width="0.17em" />'
FINISH = [
    # signs that the converter takes for letters, and names that it takes for signs
    (r"<mi>([−±∓≠≤≥≡∈∉⊂∩→↦∘·×]|&#x000B1;)</mi>", r"<mo>\1</mo>"),
    (r"<mo[^>]*>([A-Za-z]+)</mo>", r"<mi>\1</mi>"),
    # bars and strokes stand close
    (r"<mo>(&#x0007C;|&#x02016;|&#x0002F;)</mo>", CLOSE),
    # a sign at the start, or after a relation, a comma or an opening bracket, belongs to what follows
    (
        r"(<mrow>|<mtd[^>]*>|<mo[^>]*>(?:[≠≤≥≡∈→↦·×(\[]|&#x00(?:028|02C|03A|03C|03D|03E);)</mo>)<mo>([−±∓])</mo>",
        r'\1<mo form="prefix">\2</mo>',
    ),
    # primes are raised by themselves
    (r"<msup>(<mi>\w</mi>)<mi>(&#x0203\d;)</mi></msup>", rf"<mrow>\1{CLOSE_2}</mrow>"),
    (r"<msup>(<mi>\w</mi>)<mrow><mi>(&#x0203\d;)</mi>", rf"<msup><mrow>\1{CLOSE_2}</mrow><mrow>"),
    (
        r"<msubsup>(<mi>\w</mi><m[in]>\w</m[in]>)<mi>(&#x0203\d;)</mi></msubsup>",
        rf"<mrow><msub>\1</msub>{CLOSE_2}</mrow>",
    ),
    # names of functions stand apart from letters and numbers
    (rf"((?<!<msub>)(?<!<msup>){NAME}|<msu[bp]>{NAME}<m[in]>\w</m[in]></msu[bp]>)(?=<{ATOM})", rf"\1{THIN}"),
    (rf"(</{ATOM})(?={NAME}|<msu[bp]>{NAME})", rf"\1{THIN}"),
]
"""What is replaced in the converter's answers, in this order: a pattern, and what stands in its place."""

JOINER = "&#8288;"
"""What keeps a comma on the line of the formula before it."""


def mathml(formula: str, display: str) -> str:
    """The formula, in LaTeX, as MathML; ValueError for a command that is not known."""
    text = convert(formula, display=display)
    if "\\" in text or "<mi>&</mi>" in text:
        raise ValueError(f"not known in {formula}")
    for pattern, replacement in FINISH:
        text = re.sub(pattern, replacement, text)
    return text


def inline(writer: Any, node: nodes.math) -> None:
    """Write a formula within a line."""
    after = node.next_node(nodes.Text, descend=False, siblings=True)
    joined = after is not None and after.astext()[:1] in set(",.;:)-'’")
    writer.body.append(written(node, "inline") + JOINER * joined)
    raise nodes.SkipNode


def block(writer: Any, node: nodes.math_block) -> None:
    """Write a formula of its own, which scrolls within its box."""
    writer.body.append(f'<div class="math" tabindex="0">{written(node, "block")}</div>')
    raise nodes.SkipNode


def written(node: nodes.math | nodes.math_block, display: str) -> str:
    """The MathML of a node; what is not known is a warning, and so an error of the build."""
    try:
        return mathml(node.astext(), display)
    except Exception as error:
        logging.getLogger(__name__).warning("formula: %s", error, location=node)
        return ""


def setup(app: Sphinx) -> dict[str, Any]:
    """Register the renderer, which conf.py names."""
    app.add_html_math_renderer("mathml", (inline, None), (block, None))
    return {"parallel_read_safe": True, "parallel_write_safe": True}
