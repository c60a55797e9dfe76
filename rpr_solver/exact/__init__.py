"""Exact arithmetic that knows no manipulator: rationals, decimals, real roots, number fields."""
