"""Numbers of the plane, x + j y with x and y in any ring and j² = −ρ, mostly j = i.

FLINT's complex balls, Python's complex numbers and numpy's arrays of them are such numbers, too, and serve
in place of a :class:`PlaneNumber`: they have ``real``, ``imag`` and ``conjugate()``, sums, differences and
products, also with an element of the ring on the right.
"""

from __future__ import annotations

from typing import Any, Generic, TypeVar

R = TypeVar("R")


class PlaneNumber(Generic[R]):
    """x + j y over a ring.

    Attributes:
        real, imag: x and y.
        rho: −j².
    """

    __slots__ = ("imag", "real", "rho")

    def __init__(self, real: R, imag: R, rho: int = 1) -> None:
        self.real: Any = real
        self.imag: Any = imag
        self.rho = rho

    def conjugate(self) -> PlaneNumber[R]:
        """x − j y."""
        return PlaneNumber(self.real, -self.imag, self.rho)

    def __add__(self, other: PlaneNumber[R]) -> PlaneNumber[R]:
        return PlaneNumber(self.real + other.real, self.imag + other.imag, self.rho)

    def __sub__(self, other: PlaneNumber[R]) -> PlaneNumber[R]:
        return PlaneNumber(self.real - other.real, self.imag - other.imag, self.rho)

    def __mul__(self, other: Any) -> PlaneNumber[R]:
        """The product with a number of the plane or an element of the ring."""
        if not isinstance(other, PlaneNumber):
            return PlaneNumber(self.real * other, self.imag * other, self.rho)
        x, y, u, v = self.real, self.imag, other.real, other.imag
        product = y * v if self.rho == 1 else y * v * self.rho
        return PlaneNumber(x * u - product, x * v + y * u, self.rho)
