"""What number may stand behind a printed decimal."""

from fractions import Fraction

import pytest

from rpr_solver.errors import InputError
from rpr_solver.verify.intervals import Interval
from rpr_solver.verify.printed import Printed

BITS = 60


def test_reading() -> None:
    x = Printed.of("-0.0123", "l2")
    assert (x.value, x.half, x.digits) == (Fraction(-123, 10000), Fraction(1, 20000), 3)
    assert Printed.of("1.50e+20", "l2").half == Fraction(10**18, 2)
    assert Printed.of("0", "l2").is_zero
    for text in ("x", "1.", "1e99999", None, 1.5, ""):
        with pytest.raises(InputError, match="l2"):
            Printed.of(text, "l2")


def test_rounding() -> None:
    x = Printed.of("14.98", "l2")
    assert x.rounds(Interval.of(Fraction("14.984"), BITS)) is True
    assert x.rounds(Interval.of(Fraction("14.986"), BITS)) is False
    assert x.rounds(Interval.of(Fraction("14.985"), BITS)) is None
    assert Printed.of("179.9", "alpha").rounds(Interval.of(Fraction("-180.1"), BITS), 360) is True


def test_a_text_stands_for_all_numbers_that_round_to_it() -> None:
    x = Printed.of("14.98", "l2")
    assert (x.lower, x.upper) == (Fraction("14.975"), Fraction("14.985"))
    for text, below, above in (
        ("14.974", False, True),
        ("14.975", None, None),
        ("14.985", None, None),
        ("14.986", True, False),
    ):
        assert (x.below(Fraction(text)), x.above(Fraction(text))) == (below, above), text
    zero = Printed.of("0", "l2")
    assert (zero.below(Fraction(0)), zero.above(Fraction(0)), zero.below(Fraction(1, 10**9))) == (
        False,
        False,
        True,
    )
