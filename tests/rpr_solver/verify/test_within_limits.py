"""Cusps within joint limits, against those of a table."""

from __future__ import annotations

from fractions import Fraction

from rpr_solver import EXAMPLES, cusp_table
from rpr_solver.verify.core.intervals import Interval
from rpr_solver.verify.within_limits import Limits
from tests.support.verified import geometry_of

GEOMETRY = geometry_of(EXAMPLES["zein-flat"])


def test_the_cusps_of_a_table_within_limits() -> None:
    [table] = cusp_table(EXAMPLES["zein-flat"], "34.5", digits=15)
    lengths = sorted(Fraction(cusp.coordinates[2]) for cusp in table.cusps)
    middle = (lengths[2] + lengths[3]) / 2
    below, above = (Limits({2: bounds}) for bounds in ((None, middle), (middle, None)))
    assert below.counted(GEOMETRY, 1, Fraction("34.5")) == (3, True)
    assert above.counted(GEOMETRY, 1, Fraction("34.5")) == (table.count - 3, True)
    assert Limits({}).counted(GEOMETRY, 1, Fraction("34.5")) == (table.count, True)


def test_a_length_at_a_limit_is_open() -> None:
    wide = {2: Interval.of(5, 40, Fraction(1, 10)), 3: Interval.of(7, 40)}
    assert Limits({2: (4, 6)}).admit(wide) is True
    assert Limits({2: (5, 6)}).admit(wide) is None
    assert Limits({2: (5, 6), 3: (None, 6)}).admit(wide) is False
    assert Limits({3: (8, None)}).admit(wide) is False
