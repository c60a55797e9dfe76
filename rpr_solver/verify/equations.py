"""The equations of poses, from the closure of the legs: nothing else is assumed of a manipulator.

The fixed leg i leads from A_i to B_i = A_i + L e with e = exp(iθ), in the complex plane, and every other
corner of the platform is B_k = B_i + z m with z = exp(iα), where m is b_k − b_i at α = 0. With a = A_k − A_i
the squared length of leg k is

    f = |L e + z m − a|² = |a|² + |m|² + L² + Re(c₁ z) + L Re(c₂ e + c₃ z ē),
    c₁ = −2 ā m, c₂ = −2 ā, c₃ = 2 m.

So f, J and all of their derivatives are sums of *waves* Re(c exp(i (j α + k θ))). SymPy proves, from the
distance |B_k − A_k| alone, that they are those written here: in the tests, as it takes longer to load than a
table to be verified.

Lengths are measured in a power of 2, the *unit*, and are L = λ/μ: equations that are homogeneous in λ and μ
hold for L → ∞, too. With f = f₀ + L f₁ + …, where f₁ alone depends on θ, all functions are multiplied by
powers of μ:

    p = μ ∂f₀/∂α + λ ∂f₁/∂α,    q = λ ∂f₁/∂θ,    J = μ J₀ + λ J₁,    J₀ + L J₁ = (f_α g_θ − f_θ g_α)/L,
    E = p ∂J/∂θ − q ∂J/∂α,    W = p ∂E/∂θ − q ∂E/∂α.

v = (−q, p) is a multiple of (−f_θ, f_α), which is in the kernel of the derivative of (f, g) where J = 0
(mathematics.md#equations-of-poses).
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from functools import cached_property
from math import comb, factorial
from typing import Any

from flint import acb, acb_poly, arb, arb_mat, ctx

from rpr_solver.boxes import Balls, Combinations, Jet, Undecided, monomials
from rpr_solver.verify.geometry import Geometry
from rpr_solver.verify.numbers import ball

ALPHA, THETA, LENGTH = range(3)
"""The variables of a box: the angles α and θ, and t, where the length varies."""

Exponents = tuple[int, int]
Waves = Mapping[Exponents, acb]
"""Σ Re(c exp(i (j α + k θ))), by the exponents (j, k)."""
Anywhere = Sequence[arb] | Sequence[Balls]
"""A box, or many at once."""
Jets = Jet[Any]


def _like(number: int, ball_: Any) -> Any:
    """A number as a ball of the kind of another."""
    return Balls.of([arb(number)]) if isinstance(ball_, Balls) else arb(number)


def slope(waves: Waves, variable: int) -> Waves:
    """The derivative in α or θ."""
    return {n: c * acb(0, n[variable]) for n, c in waves.items() if n[variable]}


def total(*parts: Waves) -> Waves:
    """The sum; exponents n and −n are one wave, with the conjugate coefficient."""
    result: dict[Exponents, acb] = {}
    for waves in parts:
        for (j, k), c in waves.items():
            if (j, k) < (0, 0):
                j, k, c = -j, -k, c.conjugate()
            result[j, k] = result.get((j, k), acb(0)) + c
    return result


def jacobian(first: Waves, second: Waves) -> Waves:
    """The Jacobian determinant: of Re(c Eₘ) and Re(d Eₙ) it is ½ (m × n) Re(c d̄ Eₘ₋ₙ − c d Eₘ₊ₙ)."""
    parts = []
    for m, c in first.items():
        for n, d in second.items():
            cross = acb(m[0] * n[1] - m[1] * n[0]) / 2
            difference, both = (m[0] - n[0], m[1] - n[1]), (m[0] + n[0], m[1] + n[1])
            parts += [{difference: cross * c * d.conjugate()}, {both: -cross * c * d}] if cross != 0 else []
    return total(*parts)


@dataclass(frozen=True)
class Form:
    """A function μ still + λ moving of the angles."""

    still: Waves
    moving: Waves


def square_of(a: acb, m: acb) -> Form:
    """f₀ and f₁, by the places of the corners of a free leg as seen from those of the fixed one."""
    return Form({(1, 0): a.conjugate() * m * -2}, {(0, 1): a.conjugate() * -2, (1, -1): m * 2})


def singular_of(f: Form, g: Form) -> Form:
    """J₀ and J₁."""
    still = total(jacobian(f.still, g.moving), jacobian(f.moving, g.still))
    return Form(still, jacobian(f.moving, g.moving))


@dataclass(frozen=True)
class Legs:
    """The waves of a manipulator in its unit, to some precision.

    Attributes:
        constants: |a|² + |m|² of each free leg.
        squares: f₀ and f₁ of each free leg.
        singular: J.
    """

    constants: Mapping[int, arb]
    squares: Mapping[int, Form]
    singular: Form

    @classmethod
    def of(cls, mechanism: Mechanism) -> Legs:
        """Those of two free legs, to the precision of the moment."""
        unit, constants, squares = arb(2) ** mechanism.geometry.size, {}, {}
        for leg in mechanism.free:
            a, m = (x / unit for x in mechanism.arms(leg))
            constants[leg] = (a * a.conjugate() + m * m.conjugate()).real
            squares[leg] = square_of(a, m)
        return cls(constants, squares, singular_of(*squares.values()))


class Table:
    """The Taylor coefficients of a sum of waves, as combinations of the cosines and sines of its angles."""

    def __init__(self, waves: Waves, order: int) -> None:
        self._angles = list(waves)
        rows = []
        for a, b in monomials(2, order):
            row = []
            for (j, k), c in waves.items():
                # ∂ᵃ/∂αᵃ ∂ᵇ/∂θᵇ Re(c exp iψ) = jᵃ kᵇ Re(iᵃ⁺ᵇ c exp iψ) for ψ = j α + k θ
                part = c * acb(0, 1) ** (a + b) * (j**a * k**b) / (factorial(a) * factorial(b))
                row += [part.real, -part.imag]
            rows.append(row)
        self._rows, self._matrix = rows, arb_mat(rows)

    @cached_property
    def _combinations(self) -> Combinations:
        return Combinations(self._rows)

    def terms(self, turns: Turns) -> list[Any]:
        """The coefficients on a box."""
        column = [x for n in self._angles for x in turns[n]]
        if isinstance(column[0], Balls):
            found = self._combinations.of(Balls.stacked(column))
            return [found[k] for k in range(len(found.mid))]
        return [x for [x] in (self._matrix * arb_mat([[x] for x in column])).tolist()]


class Turns:
    """The cosines and sines of angles j α + k θ on a box."""

    def __init__(self, box: Anywhere) -> None:
        self._box, self._known = box, dict[Exponents, tuple[Any, Any]]()

    def __getitem__(self, n: Exponents) -> tuple[Any, Any]:
        if n not in self._known:
            box: Sequence[Any] = self._box
            parts = [x * k for x, k in zip(box, n, strict=False) if k] or [box[0] * 0]
            sin, cos = sum(parts[1:], parts[0]).sin_cos()
            self._known[n] = cos, sin
        return self._known[n]


@dataclass(frozen=True)
class Mechanism:
    """A manipulator with one leg fixed."""

    geometry: Geometry
    fixed: int
    _legs: dict[int, Legs] = field(default_factory=dict, init=False, repr=False, compare=False)

    @property
    def free(self) -> tuple[int, int]:
        """The legs whose lengths vary."""
        return self.geometry.free_legs(self.fixed)

    @property
    def closing_legs(self) -> Sequence[int]:
        """The free legs that can vanish together with the fixed one: |a| = |m|."""
        base, platform = self.geometry.squared_sides
        return [leg for leg in self.free if base[self.fixed, leg] == platform[self.fixed, leg]]

    def arms(self, leg: int) -> tuple[acb, acb]:
        """a and m."""
        base, platform = self.geometry.base, self.geometry.platform
        return base[leg - 1] - base[self.fixed - 1], platform[leg - 1] - platform[self.fixed - 1]

    @property
    def legs(self) -> Legs:
        """The waves, to the precision of the moment."""
        if ctx.prec not in self._legs:
            self._legs[ctx.prec] = Legs.of(self)
        return self._legs[ctx.prec]


@dataclass(frozen=True)
class Space(ABC):
    """The poses in which equations are solved: those of one length, or of many."""

    mechanism: Mechanism
    _tables: dict[tuple[str, int, int, int], Any] = field(
        default_factory=dict, init=False, repr=False, compare=False
    )

    @property
    @abstractmethod
    def variables(self) -> int:
        """Of a box: 2, α and θ, or 3, with t."""

    @abstractmethod
    def ratio(self, box: Anywhere, order: int) -> tuple[Jets, Jets]:
        """λ and μ."""

    @abstractmethod
    def _tabled(self, name: str, leg: int, order: int) -> Any:
        """The tables of a function, to the precision of the moment."""

    @abstractmethod
    def _terms(self, tables: Any, turns: Turns, box: Anywhere, order: int) -> list[Any]:
        """The Taylor coefficients of a form on a box."""

    def form(self, name: str, leg: int, box: Anywhere, turns: Turns, order: int) -> Jets:
        """A function of the angles, by its name."""
        key = name, leg, order, ctx.prec
        if key not in self._tables:
            self._tables[key] = self._tabled(name, leg, order)
        return Jet(self.variables, order, self._terms(self._tables[key], turns, box, order))

    def _form(self, name: str, leg: int) -> Form:
        legs = self.mechanism.legs
        if name == "J":
            return legs.singular
        square = legs.squares[leg]
        if name == "p":
            return Form(slope(square.still, ALPHA), slope(square.moving, ALPHA))
        return Form({}, slope(square.moving, THETA)) if name == "q" else square

    def turned(self, jet: Jets, poses: Poses) -> Jets:
        """The derivative in α of a function, while the length is held."""
        del poses
        return jet.d(ALPHA)

    def on(self, box: Anywhere, order: int) -> Poses:
        """The functions on a box, J to some order and derivatives of it along the kernel each to one less."""
        return Poses(self, box, order)


@dataclass(frozen=True)
class Slice(Space):
    """All poses with one length of the fixed leg. λ and μ are 1 or less."""

    length: Fraction = Fraction(1)

    @property
    def variables(self) -> int:
        return 2

    @cached_property
    def _ratio(self) -> tuple[Fraction, Fraction]:
        length, unit = self.length, Fraction(2) ** self.mechanism.geometry.size
        return (length / unit, Fraction(1)) if length <= unit else (Fraction(1), unit / length)

    def ratio(self, box: Anywhere, order: int) -> tuple[Jets, Jets]:
        balls = [ball(x) for x in self._ratio]
        own = [Balls.of([x]) for x in balls] if isinstance(box[0], Balls) else balls
        zeros = [own[0] * 0] * (len(monomials(2, order)) - 1)
        return Jet(2, order, [own[0], *zeros]), Jet(2, order, [own[1], *zeros])

    def _tabled(self, name: str, leg: int, order: int) -> Table:
        lam, mu = map(ball, self._ratio)
        form = self._form(name, leg)
        still, moving = ({n: c * x for n, c in w.items()} for w, x in ((form.still, mu), (form.moving, lam)))
        return Table(total(still, moving), order)

    def _terms(self, tables: Table, turns: Turns, box: Anywhere, order: int) -> list[Any]:
        del box, order
        return tables.terms(turns)


@dataclass(frozen=True)
class Lengths(Space):
    """All poses with a length up to the unit, L = t, or beyond it, L = 1/t, for t from 0 to 1 in units.

    t = 0 are the limits of the equations for L → 0 or L → ∞.
    """

    beyond: bool = False

    @property
    def variables(self) -> int:
        return 3

    def ratio(self, box: Anywhere, order: int) -> tuple[Jets, Jets]:
        zero, one = box[2] * 0, box[2] * 0 + _like(1, box[2])
        places: dict[tuple[int, ...], Any] = {(0, 0, 0): box[2], (0, 0, 1): one}
        varying = Jet(3, order, [places.get(n, zero) for n in monomials(3, order)])
        constant = Jet(3, order, [one if not any(n) else zero for n in monomials(3, order)])
        return (constant, varying) if self.beyond else (varying, constant)

    def _powers(self, name: str, leg: int) -> Sequence[Waves]:
        """The waves that are multiplied by 1, t, t², …: a function by its name."""
        form = self._form(name, leg)
        return (form.moving, form.still) if self.beyond else (form.still, form.moving)

    def _tabled(self, name: str, leg: int, order: int) -> Sequence[tuple[int, Table]]:
        return [(n, Table(waves, order)) for n, waves in enumerate(self._powers(name, leg)) if waves]

    def _terms(
        self, tables: Sequence[tuple[int, Table]], turns: Turns, box: Anywhere, order: int
    ) -> list[Any]:
        rows: dict[tuple[int, ...], Any] = {}
        powers = [box[2] * 0 + _like(1, box[2])]
        for n, table in tables:
            while len(powers) <= n:
                powers.append(powers[-1] * box[2])
            for (a, b), x in zip(monomials(2, order), table.terms(turns), strict=True):
                # (t + h)ⁿ = Σ C(n, c) tⁿ⁻ᶜ hᶜ
                for c in range(min(n, order - a - b) + 1):
                    term = powers[n - c] * comb(n, c) * x if c < n else x
                    rows[a, b, c] = rows[a, b, c] + term if (a, b, c) in rows else term
        zero = box[2] * 0
        return [rows.get(n, zero) for n in monomials(3, order)]


@dataclass(frozen=True)
class Closing(Lengths):
    """All poses beside that at which the fixed leg vanishes, and with it a free one, ``closing``: |a| = |m|.

    It is z = a/m = z₀, L = 0. The variables are ψ, θ and t, with z = z₀ (1 + i y)/(1 − i y), y = t sin ψ, and
    L = t cos ψ in units. J, p and q are divided by the powers of t to which they vanish, and multiplied by
    powers of 1 + y² that make them polynomials in y and L (mathematics.md#legs-that-close).
    """

    closing: int = 0

    def _powers(self, name: str, leg: int) -> Sequence[Waves]:
        if name == "cos":
            return ({(1, 0): acb(1)},)
        if name == "sin":
            return ({}, {(1, 0): acb(0, -1)})
        form, halved = self._form(name, leg), name == "q"
        # ∂/∂α is (1 + y²)/(2 t) times t ∂/∂y: q takes the factor
        degree = 1 if name == "p" else 2
        least = (name != "p") + (name != "J" and leg == self.closing)
        parts: dict[int, Waves] = {}
        for k, waves in enumerate((form.still, form.moving)):
            for (j, turns), c in waves.items():
                # zʲ (1 + y²)ᵈ = z₀ʲ (1 + i y)ᵈ⁺ʲ (1 − i y)ᵈ⁻ʲ
                turned = acb_poly([1, acb(0, 1)]) ** (degree + j) * acb_poly([1, acb(0, -1)]) ** (degree - j)
                for n, x in enumerate((turned * (c * self.start**j / (1 + halved))).coeffs()):
                    own = {(m, turns): x * y for m, y in _sines(n, k).items()}
                    parts[n + k] = total(parts.get(n + k, {}), own)
        return [parts.get(n, {}) for n in range(least, max(parts) + 1)]

    @property
    def start(self) -> acb:
        """z₀."""
        a, m = self.mechanism.arms(self.closing)
        return a / m

    @property
    def gaps(self) -> Mapping[int, acb]:
        """The vectors of the free legs where t = 0."""
        arms = {leg: self.mechanism.arms(leg) for leg in self.mechanism.free}
        return {leg: self.start * m - a for leg, (a, m) in arms.items()}

    def ratio(self, box: Anywhere, order: int) -> tuple[Jets, Jets]:
        """Lengths are not asked for here.

        Raises:
            Undecided: always.
        """
        del box, order
        raise Undecided

    def turned(self, jet: Jets, poses: Poses) -> Jets:
        """t ∂/∂y while L is held: cos ψ ∂/∂ψ + t sin ψ ∂/∂t."""
        return poses.function("cos") * jet.d(ALPHA) + poses.function("sin") * jet.d(LENGTH)


def _sines(n: int, k: int) -> Mapping[int, acb]:
    """sinⁿ ψ cosᵏ ψ = Σ cₘ exp(i m ψ), by m."""
    found = acb_poly([-1, 0, 1]) ** n * acb_poly([1, 0, 1]) ** k
    return {m - n - k: c / (acb(0, 2) ** n * 2**k) for m, c in enumerate(found.coeffs()) if c != 0}


class Poses:
    """The functions of a space on a box, or on many at once, as jets."""

    def __init__(self, space: Space, box: Anywhere, order: int) -> None:
        self.space, self.box, self.order = space, box, order
        self._turns, self._known = Turns(box), dict[tuple[str, int], Jets]()

    def function(self, name: str, leg: int = 0, order: int | None = None) -> Jets:
        """A function of the space by its name: to the order of the poses, if nothing else is said."""
        if (name, leg) not in self._known:
            own = self.order if order is None else order
            self._known[name, leg] = self.space.form(name, leg, self.box, self._turns, own)
        return self._known[name, leg]

    @property
    def singular(self) -> Jets:
        """J, to the order of the poses."""
        return self.function("J")

    def kernel(self, leg: int) -> tuple[Jets, Jets]:
        """q and p of a free leg: the vector (−q, p) is in the kernel of the derivative where J = 0."""
        order = max(self.order - 1, 0)
        return self.function("q", leg, order), self.function("p", leg, order)

    def along(self, jet: Jets, leg: int) -> Jets:
        """The derivative of a function along the kernel vector of a leg: E of J, W of E."""
        q, p = self.kernel(leg)
        return p * jet.d(THETA) - q * self.turned(jet)

    def turned(self, jet: Jets) -> Jets:
        """The derivative in α of a function, while the length is held."""
        return self.space.turned(jet, self)

    def square(self, leg: int) -> Jets:
        """μ² times the squared length of a free leg, in units."""
        lam, mu = self.space.ratio(self.box, self.order)
        constant = self.space.mechanism.legs.constants[leg]
        own = Balls.of([constant]) if isinstance(self.box[0], Balls) else constant
        return mu * self.function("f", leg) + lam * lam + mu * mu * own

    @property
    def lengths(self) -> dict[int, arb]:
        """The lengths of the legs on a box of balls of FLINT, by number."""
        lam, mu = (x.value for x in self.space.ratio(self.box, 0))
        unit, mechanism = arb(2) ** self.space.mechanism.geometry.size / mu, self.space.mechanism
        free = {leg: self.square(leg).value.sqrt() * unit for leg in mechanism.free}
        return {mechanism.fixed: lam * unit, **free}
