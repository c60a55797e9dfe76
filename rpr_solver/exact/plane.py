"""Numbers of the plane, x + i y with x and y in any ring.

FLINT's complex balls, Python's complex numbers and numpy's arrays of them are such numbers, too, and serve
in place of a :class:`PlaneNumber`: they have ``real``, ``imag`` and ``conjugate()``, sums, differences and
products, also with an element of the ring on the right.
"""

from __future__ import annotations

from typing import Any, Generic, TypeVar

R = TypeVar("R")


class PlaneNumber(Generic[R]):
    """x + i y over a ring.

    Attributes:
        real, imag: x and y.
    """

    __slots__ = ("imag", "real")

    def __init__(self, real: R, imag: R) -> None:
        self.real: Any = real
        self.imag: Any = imag

    def conjugate(self) -> PlaneNumber[R]:
        """x − i y."""
        return PlaneNumber(self.real, -self.imag)

    def __add__(self, other: PlaneNumber[R]) -> PlaneNumber[R]:
        return PlaneNumber(self.real + other.real, self.imag + other.imag)

    def __sub__(self, other: PlaneNumber[R]) -> PlaneNumber[R]:
        return PlaneNumber(self.real - other.real, self.imag - other.imag)

    def __mul__(self, other: Any) -> PlaneNumber[R]:
        """The product with a number of the plane or an element of the ring."""
        if not isinstance(other, PlaneNumber):
            return PlaneNumber(self.real * other, self.imag * other)
        x, y, u, v = self.real, self.imag, other.real, other.imag
        return PlaneNumber(x * u - y * v, x * v + y * u)
