"""Symmetries of a slice map: maps of the torus that change (f, g) by a linear map and constants only.

With e = exp(iθ) and z = exp(iα), every leg is f = const + 2 Re(L P e z̄ + L Q e + R z), P = m̄, Q = −ā and R =
−m ā. The maps that keep this shape send z to a multiple of z or z̄, and {e, e z̄} to multiples of them or of
their conjugates. A symmetry preserves J up to a constant, so it maps transitions to transitions of the same L
(mathematics.md#equal-lengths). Isosceles manipulators have one, and some mirror-similar ones.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import combinations, product

from flint import acb, arb, ctx

from rpr_solver.exact.number_field import Algebraic, exact_omega
from rpr_solver.model.bridge import Bridge
from rpr_solver.model.slice_map import Leg, SliceMap


@dataclass(frozen=True)
class _Complex:
    """A complex number by its real part, and its imaginary part in √ρ."""

    re: Algebraic
    im: Algebraic
    rho: int

    @property
    def conjugate(self) -> _Complex:
        return _Complex(self.re, -self.im, self.rho)

    @property
    def square(self) -> Algebraic:
        """|x|²."""
        return self.re * self.re + self.im * self.im * self.rho

    def __mul__(self, other: _Complex) -> _Complex:
        real = self.re * other.re - self.im * other.im * self.rho
        return _Complex(real, self.re * other.im + self.im * other.re, self.rho)

    def __neg__(self) -> _Complex:
        return _Complex(-self.re, -self.im, self.rho)

    def __truediv__(self, other: _Complex) -> _Complex:
        inverse = other.square.inverse()
        quotient = self * other.conjugate
        return _Complex(quotient.re * inverse, quotient.im * inverse, self.rho)

    def equals(self, other: _Complex) -> bool:
        return (self.re - other.re).is_zero and (self.im - other.im).is_zero

    def ball(self, bits: int) -> acb:
        return acb(self.re.ball(bits), self.im.ball(bits) * arb(self.rho).sqrt())


_Wave = tuple[_Complex, _Complex, _Complex]
"""P, Q and R of a leg."""


@dataclass(frozen=True)
class Symmetry:
    """(z, e) → (alpha z or alpha z̄, theta times e, ē, ē z or e z̄).

    ``flips`` is whether z becomes z̄, ``swaps`` whether e and e z̄ change places, or their conjugates. The leg
    ``source`` has at the image the length that the leg ``target`` has at a pose, if they are not None.
    """

    flips: bool
    swaps: bool
    alpha: _Complex
    theta: _Complex
    source: Leg | None
    target: Leg | None
    bridge: Bridge

    def image(self, alpha: acb, theta: acb, bits: int) -> tuple[acb, acb]:
        """The image of a pose given by exp(iα) and exp(iθ)."""
        with ctx.workprec(bits):
            if self.bridge.is_along:
                return self._image(alpha, theta, bits)
            axes = self.bridge.turns(bits)
            image = self._image(alpha * axes[0], theta * axes[1], bits)
            first, second = (z * axis.conjugate() for z, axis in zip(image, axes, strict=True))
            return first, second

    def _image(self, alpha: acb, theta: acb, bits: int) -> tuple[acb, acb]:
        """The same in the coordinates of the forms."""
        with ctx.workprec(bits):
            turned = theta.conjugate() if self.flips != self.swaps else theta
            if self.swaps:
                turned *= alpha.conjugate() if self.flips else alpha
            flipped = alpha.conjugate() if self.flips else alpha
            return self.alpha.ball(bits) * flipped, self.theta.ball(bits) * turned

    def of_wave(self, wave: _Wave) -> _Wave:
        """P, Q and R of a leg after the symmetry."""
        p, q, r = wave
        if self.swaps:
            p, q = q, p
        across, turn = self.theta, self.alpha.conjugate
        if self.swaps != self.flips:
            p, q, across, turn = p.conjugate, q.conjugate, across.conjugate, self.alpha
        p, q = p * across, q * across
        # the term e z̄ turns with z as well: it is the first one, or the second one after a swap
        p, q = (p, q * turn) if self.swaps else (p * turn, q)
        return p, q, r.conjugate * self.alpha.conjugate if self.flips else r * self.alpha


@lru_cache(maxsize=16)
def symmetries(slice_map: SliceMap) -> tuple[Symmetry, ...]:
    """All symmetries but the identity under which one leg becomes itself or the other, perhaps reversed."""
    legs, bridge = (slice_map.f, slice_map.g), Bridge.of(slice_map)
    waves = [_wave(leg) for leg in legs]
    symmetries: list[Symmetry] = []
    for flips, swaps, sign in product((False, True), (False, True), (1, -1)):
        for i, j in product((0, 1), repeat=2):
            pair = (legs[i], legs[j]) if sign > 0 else (None, None)
            target = _signed(waves[j], sign)
            symmetry = _candidate(waves[i], target, (*pair, bridge), flips=flips, swaps=swaps)
            if symmetry and _is_symmetry(symmetry, waves, i, j) and not _is_identity(symmetry):
                symmetries.append(symmetry)
    return tuple(symmetries)


def _wave(leg: Leg) -> _Wave:
    omega = exact_omega(leg.radicand)
    number = omega.field
    m, a = (
        _Complex(x.times(number(1), omega), y.times(number(1), omega), leg.rho)
        for x, y in (leg.platform, leg.base)
    )
    return m.conjugate, -a.conjugate, -(m * a.conjugate)


def _signed(wave: _Wave, sign: int) -> _Wave:
    p, q, r = wave
    return wave if sign > 0 else (-p, -q, -r)


def _candidate(
    source: _Wave, target: _Wave, rest: tuple[Leg | None, Leg | None, Bridge], *, flips: bool, swaps: bool
) -> Symmetry | None:
    """The only symmetry of its type that can map one wave to another."""
    _, q, r = source
    p_to, q_to, r_to = target
    e_to = p_to if swaps else q_to
    theta = (e_to.conjugate if flips != swaps else e_to) / q
    alpha = (r_to.conjugate if flips else r_to) / r
    if not all((x.square - 1).is_zero for x in (alpha, theta)):
        return None
    symmetry = Symmetry(flips, swaps, alpha, theta, *rest)
    maps = all(x.equals(y) for x, y in zip(symmetry.of_wave(source), target, strict=True))
    return symmetry if maps else None


def _is_symmetry(symmetry: Symmetry, waves: Sequence[_Wave], source: int, target: int) -> bool:
    """Whether the other leg becomes a real combination of both, the one that is no target included."""
    image, *both = (
        [part for x in wave for part in (x.re, x.im)]
        for wave in (symmetry.of_wave(waves[1 - source]), waves[target], waves[1 - target])
    )
    first, second = both
    for i, k in combinations(range(len(image)), 2):
        minor = first[i] * second[k] - first[k] * second[i]
        if not minor.is_zero:
            inverse = minor.inverse()
            x = (image[i] * second[k] - image[k] * second[i]) * inverse
            y = (first[i] * image[k] - first[k] * image[i]) * inverse
            fits = all((x * a + y * b - c).is_zero for a, b, c in zip(first, second, image, strict=True))
            return fits and not y.is_zero
    return False


def _is_identity(symmetry: Symmetry) -> bool:
    plain = not (symmetry.flips or symmetry.swaps)
    return plain and all(x.im.is_zero and x.re.sign > 0 for x in (symmetry.alpha, symmetry.theta))
