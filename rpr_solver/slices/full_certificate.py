"""The full certificate of a slice: what somebody else needs to check its table without solving it.

    {"polynomial": {"variable": "u = tan(theta1/2)", "degree": 24, "coefficients": ["…", …],
                    "omega": "sqrt(…)", "omega_coefficients": ["…", …]},
     "squarefree": {"prime": "…", "omega": "…"},
     "real_roots": [{"lower": "p/q", "upper": "p/q", "multiplicity": 1}, …],
     "boxes": [{"alpha_deg": {"centre": "…", "radius": "…"}, …}, …]}

The polynomial is Q of the slice, exact. ``squarefree`` has a prime and a square root of ω² modulo it: the
image of Q there has degree 24 and no multiple root. It is null where Q has multiple roots, one at infinity,
or is 0. ``real_roots`` has an isolating interval for each finite real root, ascending, and there are no
others, as any count by signs shows.
``boxes`` has for each cusp a box of angles and lengths that holds this one solution of J = E = 0.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from fractions import Fraction
from itertools import islice
from typing import Any

from flint import arb, ctx

from rpr_solver.exact.factors import exact_roots, norm_factors
from rpr_solver.exact.modular import primes
from rpr_solver.exact.quadratic import QuadraticPoly
from rpr_solver.exact.rationals import exact_str
from rpr_solver.exact.real_roots import RealRoot, fraction_of, real_roots
from rpr_solver.slices.eliminant import DEGREE_U, Eliminant
from rpr_solver.slices.joint_points import coordinate_names

_PRIMES = 4
_BITS = 96


def full_certificate(
    eliminant: Eliminant, length: Fraction, cusps: Iterable[Mapping[str, str]]
) -> dict[str, Any]:
    """The member ``full`` of a solved slice, from its printed cusps; ``length`` is in the user's unit."""
    leg = eliminant.slice_map.fixed_leg
    q = eliminant.at(length * eliminant.slice_map.scale)
    place = None if q.is_zero else _squarefree_place(q)
    roots: list[tuple[RealRoot, int]] = []
    if place is not None:
        roots = [(root, 1) for root in real_roots(q)]
    elif not q.is_zero:
        roots = [(root.root, root.multiplicity) for root in exact_roots(norm_factors(q))]
    intervals = sorted((*_ends(root), multiplicity) for root, multiplicity in roots)
    return {
        "polynomial": _polynomial(q, leg),
        "squarefree": None if place is None else {"prime": str(place[0]), "omega": str(place[1])},
        "real_roots": [
            {"lower": exact_str(low), "upper": exact_str(high), "multiplicity": multiplicity}
            for low, high, multiplicity in intervals
        ],
        "boxes": [{name: _box(cusp[name]) for name in coordinate_names(leg)} for cusp in cusps],
    }


def _polynomial(q: QuadraticPoly, leg: int) -> dict[str, Any]:
    result: dict[str, Any] = {
        "variable": f"u = tan(theta{leg}/2)",
        "degree": DEGREE_U,
        "coefficients": [str(q.a[k]) for k in range(DEGREE_U + 1)],
    }
    if q.b:
        result["omega"] = f"sqrt({q.radicand})"
        result["omega_coefficients"] = [str(q.b[k]) for k in range(DEGREE_U + 1)]
    return result


def _squarefree_place(q: QuadraticPoly) -> tuple[int, int] | None:
    """A prime, and ω modulo it, that prove Q of degree 24 and without a multiple root."""
    for p, omega in islice(primes(q.radicand), _PRIMES):
        image = q.residue(p, omega)
        if image.degree() == DEGREE_U and image.gcd(image.derivative()).degree() == 0:
            return p, omega
    return None


def _ends(root: RealRoot) -> tuple[Fraction, Fraction]:
    ball = root.refined(_BITS)
    with ctx.workprec(2 * _BITS):
        return fraction_of(arb(ball.lower())), fraction_of(arb(ball.upper()))


def _box(text: str) -> dict[str, str]:
    """A printed number as a centre, with half a unit of its last digit as the radius."""
    mantissa, _, exponent = text.partition("e")
    places = int(exponent or 0) - len(mantissa.partition(".")[2])
    radius = "0" if text == "0" else f"5e{places - 1}"
    return {"centre": text, "radius": radius}
