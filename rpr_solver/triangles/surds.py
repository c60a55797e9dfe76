"""Numbers q·√r with rational q and r: what a side or a coordinate of a triangle may be.

A surd is its sign and its square, a rational number. So two are compared, multiplied and printed exactly, and
nothing is ever factored: 5√3/2 is the positive surd with the square 75/4, and prints as ``sqrt(18.75)``.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property, total_ordering
from typing import TYPE_CHECKING, TypeAlias

from rpr_solver.errors import InputError, shown
from rpr_solver.exact import decided
from rpr_solver.exact.precision import GREATEST_BITS
from rpr_solver.exact.rationals import MAX_DIGITS, Exact, exact_str, parse_exact, rational_sqrt

if TYPE_CHECKING:
    from flint import arb


@total_ordering
@dataclass(frozen=True)
class Surd:
    """``sign`` · √``square``.

    Attributes:
        sign: −1, 0 or 1; 0 for the number 0 alone.
        square: the square of the number, rational, ≥ 0.

    >>> parse_surd("5*sqrt(3)/2", "x"), parse_surd("sqrt(9/4)", "x")
    (Surd('sqrt(18.75)'), Surd('1.5'))
    """

    sign: int
    square: Fraction

    @classmethod
    def of(cls, value: Fraction | int) -> Surd:
        """A rational number."""
        surd = cls((value > 0) - (value < 0), Fraction(value * value))
        # the cached property, which would be found from the square
        surd.__dict__["rational"] = Fraction(value)
        return surd

    @classmethod
    def root(cls, square: Fraction | int, sign: int = 1) -> Surd:
        """√``square``, times a sign."""
        return cls(sign if square else 0, Fraction(square))

    def __repr__(self) -> str:
        return f"Surd({str(self)!r})"

    def __str__(self) -> str:
        """The canonical text, ``q`` or ``sqrt(q)``, which :func:`parse_surd` reads."""
        if (value := self.rational) is not None:
            return exact_str(value)
        return f"{'-' if self.sign < 0 else ''}sqrt({exact_str(self.square)})"

    @cached_property
    def rational(self) -> Fraction | None:
        """The number itself if it is rational, else None."""
        root = rational_sqrt(self.square)
        return None if root is None else self.sign * root

    def __neg__(self) -> Surd:
        return Surd(-self.sign, self.square)

    def __abs__(self) -> Surd:
        return Surd(abs(self.sign), self.square)

    def __mul__(self, other: Surd | Fraction | int) -> Surd:
        other = other if isinstance(other, Surd) else Surd.of(other)
        return Surd(self.sign * other.sign, self.square * other.square)

    def __lt__(self, other: Surd) -> bool:
        # x |x| increases with x
        return self.sign * self.square < other.sign * other.square

    def __bool__(self) -> bool:
        return bool(self.sign)

    def ball(self) -> arb:
        """A ball round the number, at the working precision."""
        from flint import arb  # here, since geometries are also read where nothing is computed

        if (value := self.rational) is not None:
            return arb(value.numerator) / value.denominator
        return self.sign * (arb(self.square.numerator) / self.square.denominator).sqrt()

    def decimal(self, digits: int) -> str:
        """The number, rounded to ``digits`` significant digits.

        >>> Surd.root(3).decimal(5), Surd.of(2).decimal(3)
        ('1.7321', '2.00')
        """
        from flint import ctx

        from rpr_solver.exact.decimals import digit_bits, round_ball, round_fraction

        if (value := self.rational) is not None:
            return round_fraction(value, digits)

        def rounded(bits: int) -> str | None:
            with ctx.workprec(bits):
                return round_ball(self.ball(), digits)

        # an irrational number is no tie, so that some precision decides
        return decided(rounded, digit_bits(digits) + 64, GREATEST_BITS, "the digits of a root are open")


ExactRoot: TypeAlias = Exact | Surd
"""An exact number, which may be a root: as :data:`Exact`, a text such as ``"5*sqrt(3)/2"``, or a surd."""

_ROOT = re.compile(
    r"(?P<sign>[+-]?)(?:(?P<times>[\d.][^*()\s]*)\*)?sqrt\((?P<square>[^()\s]+)\)(?:/(?P<over>[\d.][^*()/\s]*))?",
    re.ASCII,
)
SQUARE = 4
"""How many times the digits of a number the square of a side may have."""
_NOT_RATIONAL = re.compile(r"[^\d\s.,/eE+-]", re.ASCII)
"""What neither a decimal nor a fraction has."""
_EXPECTED = (
    'write a decimal "17.04", a fraction "1/2", or one of these times a root: "sqrt(3)", "5*sqrt(3)/2"'
)


def parse_surd(value: ExactRoot, field: str, *, max_digits: int = MAX_DIGITS) -> Surd:
    """Reads a number that may be a root: as :func:`parse_exact`, or ``"sqrt(q)"``, which a number and ``*``
    may stand before, and ``/`` and a number behind.

    Args:
        value: the number, such as ``"17.04"``, ``"1/2"``, ``"sqrt(3)"``, ``"-5*sqrt(3)/2"`` or
            ``"1/2*sqrt(0.5)"``.
        field: the name of the number in an error message.
        max_digits: limit on the digits of numerator and denominator of each rational number in the text; that
            under a root may have four times as many, as a squared side has.

    Raises:
        InputError: naming ``field``: no such number, or too long.

    >>> parse_surd("3√2", "d3")
    Traceback (most recent call last):
    rpr_solver.errors.InputError: d3: '3√2' is not read as a number; write "3*sqrt(2)"
    """
    if isinstance(value, Surd):
        return value
    if not isinstance(value, str) or not _NOT_RATIONAL.search(value):
        return Surd.of(parse_exact(value, field, max_digits=max_digits))
    text = value.strip()
    if len(text) > 8 * max_digits + 64:
        raise InputError.of(field, f"has {len(text)} characters; its numbers may have {max_digits} digits")
    if root := _ROOT.fullmatch(text):
        return _read(root, field, max_digits)
    raise InputError.of(field, f"{shown(text)} is not read as a number; {_advice(text)}")


def _read(root: re.Match[str], field: str, max_digits: int) -> Surd:
    square = parse_exact(root["square"], field, max_digits=SQUARE * max_digits)
    if square < 0:
        raise InputError.of(field, f"has the root of {exact_str(square)}; give a number ≥ 0 under the root")
    times, over = (parse_exact(root[part] or "1", field, max_digits=max_digits) for part in ("times", "over"))
    if over == 0:
        raise InputError.of(field, f"{shown(root[0])} is divided by 0")
    return Surd.root(square, -1 if root["sign"] == "-" else 1) * (times / over)


_SPELLINGS = (
    (r"\s+|\\cdot|(?:math|np|numpy|sympy)\.", lambda m: "*" if m[0] == r"\cdot" else ""),
    (r"[·×∙]", "*"),
    (r"(?i:\\?sqrt|√)[({\[]([^][(){}]+)[])}]", r"sqrt(\1)"),
    (r"(?i:sqrt|√)(\d+(?:\.\d+)?)", r"sqrt(\1)"),
    (r"\(?([\d./]+)\)?(?:\*\*|\^)(?:0?\.5|\(1/2\)|\(0?\.5\)|\{1/2\})", r"sqrt(\1)"),
    (r"^([+-]?)\(([\d./]+)\)", r"\1\2"),
    (r"([\d.)])sqrt", r"\1*sqrt"),
    (r"^([+-]?)(sqrt\([^()]+\))\*([\d./]+)$", r"\1\3*\2"),
)
"""Other ways to write a root, and ours; one after the other."""


def _advice(text: str) -> str:
    """How a number is to be written: ours, if it is clear what is meant."""
    ours = text[:400]
    for pattern, replacement in _SPELLINGS:
        ours = re.sub(pattern, replacement, ours)
    if ours != text and (root := _ROOT.fullmatch(ours)):
        try:
            _read(root, "", MAX_DIGITS)
        except InputError:
            pass
        else:
            return f'write "{ours}"'
    if "sqrt" in ours and re.search(r"\)[+-]|\d[+-]|\*sqrt.*sqrt", ours):
        return "no sum or product of roots is read: " + _EXPECTED.removeprefix("write ")
    return _EXPECTED
