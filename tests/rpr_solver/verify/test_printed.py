"""What number may stand behind a printed decimal."""

from fractions import Fraction

from rpr_solver.verify.core.intervals import Interval
from rpr_solver.verify.core.printed import Printed
from tests.support.verified import printed

BITS = 60


def test_rounding() -> None:
    x = printed("14.98")
    assert x.rounds(Interval.of(Fraction("14.984"), BITS)) is True
    assert x.rounds(Interval.of(Fraction("14.986"), BITS)) is False
    assert x.rounds(Interval.of(Fraction("14.985"), BITS)) is None
    assert printed("179.9").rounds(Interval.of(Fraction("-180.1"), BITS), 360) is True


def test_a_text_stands_for_all_numbers_that_round_to_it() -> None:
    x = printed("14.98")
    assert (x.lower, x.upper) == (Fraction("14.975"), Fraction("14.985"))
    for text, below, above in (
        ("14.974", False, True),
        ("14.975", None, None),
        ("14.985", None, None),
        ("14.986", True, False),
    ):
        assert (x.below(Fraction(text)), x.above(Fraction(text))) == (below, above), text
    zero = Printed.exact_zero()
    assert (zero.below(Fraction(0)), zero.above(Fraction(0)), zero.below(Fraction(1, 10**9))) == (
        False,
        False,
        True,
    )
