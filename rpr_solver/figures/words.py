"""Numbers and words of figures: lengths in few digits, the geometry below, what is degenerate."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from decimal import Decimal
from math import isinf
from typing import Any

from matplotlib.axes import Axes

from rpr_solver.contract import LENGTHS
from rpr_solver.errors import InputError
from rpr_solver.notebook import Style, degenerate_words
from rpr_solver.notebook.figure import Figure
from rpr_solver.triangles import article_lengths

_CAPTION_DIGITS, _LONGEST_ROOT = 6, 15
"""Digits of lengths in a caption, and the letters of a root that is not written in digits."""
BARE = (8.0, 8.0)
"""The margins of pictures without axes."""
_LARGEST = Decimal("1e150")
"""Larger lengths are not drawn, nor smaller ones than one by it: the square of neither is a float."""


def short(text: str | float, digits: int = 4) -> str:
    """A number as a reader of a picture wants it, with few significant digits; all of its integer part.

    >>> short("28.012345"), short("-0.00012345"), short("1500"), short(0.5)
    ('28.01', '−0.0001234', '1500', '0.5')
    """
    value = Decimal(text) if isinstance(text, float) else exact(text)
    if value != 0 and not Decimal("1e-5") <= abs(value) < Decimal("1e7"):
        mantissa, exponent = f"{value:.{digits - 1}e}".split("e")
        mantissa = mantissa.rstrip("0").rstrip(".") if "." in mantissa else mantissa
        shown = f"{mantissa}e{int(exponent)}"
    else:
        whole = max(value.adjusted() + 1, 0) if value else 1
        shown = f"{value:.{max(digits - whole, 0) if whole else digits - value.adjusted() - 1}f}"
        shown = shown.rstrip("0").rstrip(".") if "." in shown else shown
    return shown.replace("-", "−")


def number(text: str) -> float:
    """The float nearest to a number of a document: a decimal, a fraction or ``sqrt(…)``.

    Raises:
        InputError: it is too large for a picture.

    >>> number("46/4"), number("sqrt(2.25)")
    (11.5, 1.5)
    """
    value = float(text) if "/" not in text and "(" not in text else float(exact(text))
    if isinf(value) or abs(value) > _LARGEST:
        raise InputError.of(
            "geometry", f"{short(text)} is too large to be drawn; give lengths in a larger unit"
        )
    return value


def exact(text: str) -> Decimal:
    """A number of a document as a decimal, of any size."""
    sign, root, square = text.partition("sqrt(")
    if root:
        return exact(square[:-1]).sqrt().copy_sign(Decimal(f"{sign}1"))
    numerator, _, denominator = text.partition("/")
    return Decimal(numerator) / Decimal(denominator or 1)


def figure_about(
    document: Mapping[str, Any],
    title: str,
    description: str,
    paint: Callable[[Axes, Style], None],
    height: Callable[[float], float],
    remark: str = "",
    **more: Any,
) -> Figure:
    """The figure of a document: below is the geometry that it is about, and what is degenerate throughout.

    Raises:
        InputError: naming ``geometry``: axes cannot show lengths of its size.
    """
    if len(document) > 1:  # with answers in its unit
        known = article_lengths(document["geometry"])
        size = max(abs(exact(known[name])) for name in LENGTHS)
        if not 1 / _LARGEST < size < _LARGEST:
            how = ("large", "larger") if size > 1 else ("small", "smaller")
            said = f"{short(str(size))} is too {how[0]} to be drawn; give lengths in a {how[1]} unit"
            raise InputError.of("geometry", said)
    caption = _caption(document["geometry"])
    said = f"{description}{_degenerate_facts(document)} Geometry: {', '.join(caption)}."
    return Figure(title, said, paint, height, caption, _degenerate_remark(document) or remark, **more)


def caption_of(geometry: Mapping[str, Any]) -> str:
    """The geometry in one line.

    >>> caption_of({"a2x": "15.91", "a3x": "0", "a3y": "10", "d1": "17.04", "d2": "16.54", "d3": "20.84",
    ...             "orientation": "ccw"})
    'A2 = (15.91, 0), A3 = (0, 10), d1 = 17.04, d2 = 16.54, d3 = 20.84, ccw'
    """
    return ", ".join(_caption(geometry))


def _caption(geometry: Mapping[str, Any]) -> list[str]:
    known = article_lengths(geometry)
    a2x, a3x, a3y, d1, d2, d3 = (_length(known[name]) for name in LENGTHS)
    sides = f"d1 = {d1}", f"d2 = {d2}", f"d3 = {d3}"
    return [f"A2 = ({a2x}, 0)", f"A3 = ({a3x}, {a3y})", *sides, known["orientation"]]


def _length(text: str) -> str:
    """A length in few digits, or as a short root.

    >>> _length("-sqrt(75)"), _length("sqrt(1369/101)"), _length("sqrt(1234567.891)")
    ('−√75', '√(1369/101)', '1111.11')
    """
    if "(" not in text or len(text) > _LONGEST_ROOT:
        return short(text, _CAPTION_DIGITS)
    sign, _, square = text[:-1].partition("sqrt(")
    return f"{sign.replace('-', '−')}√{f'({square})' if '/' in square else square}"


def listed(words: Iterable[str]) -> str:
    """Words as an enumeration.

    >>> listed(["A", "B", "C"])
    'A, B and C'
    """
    *first, last = words
    return f"{', '.join(first)} and {last}" if first else last


def _degenerate_remark(document: Mapping[str, Any]) -> str:
    """What is degenerate throughout a census or its curves, in one short line.

    >>> curve = {"kind": "curve", "from": "0", "to": None, "equation": "alpha = 0 deg"}
    >>> _degenerate_remark({"degenerate": [curve, {"kind": "node", "from": "0", "to": "9", "count": 2}]})
    'Degenerate throughout: curve alpha = 0 deg, node'
    """
    names = dict.fromkeys(
        f"{part['kind']} {part.get('equation', '')}".strip() for part in document.get("degenerate", ())
    )
    return f"Degenerate throughout: {', '.join(names)}" if names else ""


def _degenerate_facts(document: Mapping[str, Any]) -> str:
    """The same in full, for the description of a picture."""
    words = [degenerate_words(part, document["fixed_leg"]) for part in document.get("degenerate", ())]
    return f" Degenerate: {'; '.join(words)}." if words else ""
