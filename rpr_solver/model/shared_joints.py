"""A joint that two legs share, as seen from the fixed leg (mathematics.md#shared-joints)."""

from __future__ import annotations

from dataclasses import dataclass

from rpr_solver.model.slice_map import Point, SliceMap


@dataclass(frozen=True)
class Joint:
    """A joint that two legs share, in one slice.

    Attributes:
        is_base: whether it is one of the base; otherwise base and platform change places below.
        is_third: whether the fixed leg is the third one, which does not share it.
        own, other, away: m, n and b if it shares it; m, n and a if it does not.
    """

    is_base: bool
    is_third: bool
    own: Point
    other: Point
    away: Point

    @classmethod
    def of(cls, slice_map: SliceMap) -> Joint:
        """That of a machine, the base's if there are two."""
        f, g = slice_map.f, slice_map.g
        is_base = f.base == g.base or _is_zero(f.base) or _is_zero(g.base)
        (a, m), (b, n) = ((x.base, x.platform) if is_base else (x.platform, x.base) for x in (f, g))
        if _is_zero(b):
            return cls(is_base, False, n, m, a)
        return cls(is_base, a == b, m, n, b)

    @property
    def radius(self) -> Point:
        """The point p of a line of poses with one joint vector, on which L e = p, or L e = −p z if it is one
        of the platform."""
        return self.away if self.is_third else self.other

    @property
    def is_on_platform(self) -> bool:
        """Whether that point is one of the platform."""
        return self.is_base != self.is_third


def shares_joints(slice_map: SliceMap) -> bool:
    """Whether legs share joints."""
    f, g = slice_map.f, slice_map.g
    points = (f.base, g.base), (f.platform, g.platform)
    return any(x == y or _is_zero(x) or _is_zero(y) for x, y in points)


def _is_zero(point: Point) -> bool:
    return not any(x for z in point for x in (z.a, z.b))
