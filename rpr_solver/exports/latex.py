"""Answers for papers: a table in LaTeX, and a reference in BibTeX by which a number can be asked again."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from decimal import Decimal, localcontext
from typing import Any

from rpr_solver.contract import LENGTHS, letter
from rpr_solver.errors import InputError
from rpr_solver.notebook import near_words
from rpr_solver.triangles import article_lengths

_SYMBOLS = {"alpha_deg": r"$\alpha$ [deg]"}
_KINDS = {
    "poses": "solutions of the direct kinematics",
    "slices": "cusps of slices",
    "transitions": "census of cusps",
    "curves": "curves of cusps",
    "components": "singular curves of a slice",
    "proved": "margin of the number of cusps",
    "best": "design by cusps",
    "requirement": "check of a requirement on cusps",
    "samples": "path without a singularity",
}
"""The first of these members that a document has, and what it is about."""


def latex_table(document: Mapping[str, Any], digits: int | None = None) -> str:
    r"""A cusp table as a ``table`` of LaTeX, for the package ``booktabs``.

    Args:
        document: a cusp table, as JSON.
        digits: the significant digits that are printed; None: all of the document. They are rounded
            correctly, too.

    Raises:
        InputError: naming ``document``: it is no cusp table; naming ``digits``: there are fewer, or they do
            not decide how a number is rounded.

    >>> from rpr_solver import EXAMPLES, table_document
    >>> table = latex_table(table_document(EXAMPLES["zein-flat"], 10, digits=15), digits=6)
    >>> print(table.splitlines()[10].strip())
    10 & A & $31.4509$ & $-129.007$ & $25.2234$ & $35.5095$ \\
    """
    slices, leg = document.get("slices"), document.get("fixed_leg")
    if not isinstance(slices, list) or leg not in (1, 2, 3):
        raise InputError.of("document", "is no cusp table; give what solve --format json writes")
    if digits is not None and not 1 <= digits <= document["digits"]:
        raise InputError.of("digits", f"is {digits}; give 1 to {document['digits']}")
    names = ["alpha_deg", f"theta{leg}_deg", *(f"l{k}" for k in (1, 2, 3) if k != leg)]
    heads = [f"$L_{leg}$", "cusp", *map(_symbol, names)]
    near = near_words(document)
    lines = [
        *([f"% {near}"] if near else ()),
        f"% {_source(document)}",
        r"\begin{table}  % needs \usepackage{booktabs}",
        r"  \centering",
        rf"  \caption{{Cusps of the 3-RPR manipulator {_geometry(document['geometry'])}.}}",
        rf"  \label{{tab:cusps-{_short_hash(document)}}}",
        r"  \medskip",
        rf"  \begin{{tabular}}{{ll{'r' * len(names)}}}",
        r"    \toprule",
        rf"    {' & '.join(heads)} \\",
        r"    \midrule",
        *(f"    {row}" for part in slices for row in _rows(part, f"l{leg}", names, digits)),
        r"    \bottomrule",
        r"  \end{tabular}",
        r"\end{table}",
    ]
    return "".join(f"{line}\n" for line in lines)


def bibtex(document: Mapping[str, Any], version: str, year: int) -> str:
    """A document as an entry of BibTeX: what was asked of which geometry, and which software answered.

    Args:
        document: any answer with a geometry, as JSON.
        version: that of rpr-cusps.
        year: that in which it is cited.

    Raises:
        InputError: naming ``document``: it says nothing about a geometry.

    >>> from rpr_solver import EXAMPLES, table_document
    >>> print(bibtex(table_document(EXAMPLES["zein-flat"], 10, digits=15), "0.1.0", 2026).splitlines()[0])
    @software{rpr-cusps-3af2cfa0,
    """
    if not isinstance(document.get("geometry"), dict) or "geometry_hash" not in document:
        raise InputError.of("document", "has no geometry; give an answer of rpr-cusps as JSON")
    about = next((words for member, words in _KINDS.items() if member in document), "document")
    subject = f"Planar 3-RPR parallel manipulator {_geometry(document['geometry'])}"
    fields = {
        # in braces, since styles make A_2 of others a_2
        "title": f"{{{subject}: {about}{_lengths_text(document)}}}",
        "author": "{rpr-cusps}",
        "year": str(year),
        "version": f"{version}, solver version {document['solver_version']}",
        "note": f"Computed with proof to {document['digits']} digits by solver version "
        f"{document['solver_version']}; geometry {_short_hash(document, 16)}",
        "geometry_hash": document["geometry_hash"],  # styles do not print it: no line could break within
    }
    entries = "".join(f"  {name} = {{{text}}},\n" for name, text in fields.items())
    return f"@software{{rpr-cusps-{_short_hash(document)},\n{entries}}}\n"


def _source(document: Mapping[str, Any]) -> str:
    known = article_lengths(document["geometry"])
    lengths = ", ".join(f"{name}={known[name]}" for name in LENGTHS)
    return (
        f"rpr-cusps, solver version {document['solver_version']}: {lengths}, "
        f"{known['orientation']}; geometry {document['geometry_hash']}"
    )


def _short_hash(document: Mapping[str, Any], digits: int = 8) -> str:
    return str(document["geometry_hash"]).removeprefix("sha256:")[:digits]


def _geometry(geometry: Mapping[str, Any]) -> str:
    known = article_lengths(geometry)
    a2x, a3x, a3y, d1, d2, d3 = (re.sub(r"sqrt\((.*)\)", r"\\sqrt{\1}", known[name]) for name in LENGTHS)
    points = f"$A_2 = ({a2x}, 0)$, $A_3 = ({a3x}, {a3y})$"
    mirrored = ", platform clockwise" if known["orientation"] == "cw" else ""
    return f"{points}, $d_1 = {d1}$, $d_2 = {d2}$, $d_3 = {d3}${mirrored}"


def _lengths_text(document: Mapping[str, Any]) -> str:
    """The lengths of which a document tells."""
    leg = document.get("fixed_leg", 1)
    if "slices" in document:
        lengths = [part[f"l{leg}"] for part in document["slices"]]
        ends = lengths if len(lengths) < 4 else [lengths[0], r"\dots", lengths[-1]]
        return f", $L_{leg} = {', '.join(ends)}$"
    if isinstance(document.get(f"l{leg}"), str):
        known = [
            f"$L_{k} = {document[f'l{k}']}$" for k in (1, 2, 3) if isinstance(document.get(f"l{k}"), str)
        ]
        return f", {', '.join(known)}"
    span = document.get("range")
    if isinstance(span, dict):
        stop = r"$\infty$" if span["to"] is None else span["to"]
        return f", $L_{leg}$ from {span['from']} to {stop}"
    return ""


def _symbol(name: str) -> str:
    if name.startswith("theta"):
        return rf"$\theta_{name[5]}$ [deg]"
    return _SYMBOLS.get(name) or f"$L_{name[1]}$"


def _rows(part: Mapping[str, Any], leg: str, names: Sequence[str], digits: int | None) -> Iterator[str]:
    """Yields the rows of a slice."""
    length, span = part[leg], len(names)
    if "error" in part:
        yield rf"{length} & & \multicolumn{{{span}}}{{l}}{{no answer}} \\"
        return
    if not part["cusps"]:
        yield rf"{length} & & \multicolumn{{{span}}}{{l}}{{no cusp}} \\"
    for k, cusp in enumerate(part["cusps"], 1):
        numbers = [f"${_rounded(cusp[name], digits)}$" for name in names]
        yield rf"{' & '.join([length if k == 1 else '', letter(k), *numbers])} \\".lstrip()


def _rounded(text: str, digits: int | None) -> str:
    """A correctly rounded decimal with fewer digits, correctly rounded; in powers of ten as LaTeX has them.

    Raises:
        InputError: naming ``digits``: the number may lie on either side of a tie.
    """
    value = Decimal(text)
    if digits is not None and len(value.as_tuple().digits) > digits:
        with localcontext(prec=len(text) + 2):
            last = Decimal(1).scaleb(value.adjusted() - digits + 1)
            half_unit = Decimal(1).scaleb(int(value.as_tuple().exponent)) / 2
            below, above = ((value + d).quantize(last) for d in (-half_unit, half_unit))
            if below != above:
                near = f"{text} is too near to a tie; ask for more digits of the document"
                raise InputError.of("digits", f"is {digits}; {near}")
            value = value.quantize(last)
    shown = str(value)
    if "E" in shown:
        mantissa, exponent = shown.split("E")
        return rf"{mantissa} \times 10^{{{int(exponent)}}}"
    return shown
