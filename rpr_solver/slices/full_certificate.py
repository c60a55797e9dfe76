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
from typing import Any

from flint import arb, ctx

from rpr_solver.exact.certified import Certified
from rpr_solver.exact.quadratic import Form
from rpr_solver.exact.real_roots import RealRoot, fraction_of
from rpr_solver.model.joint_points import coordinate_names
from rpr_solver.slices.eliminant import DEGREE_U, Eliminant

_BITS = 96


def full_certificate(
    eliminant: Eliminant, length: Fraction, cusps: Iterable[Mapping[str, str]]
) -> dict[str, Any]:
    """The member ``full`` of a solved slice, from its printed cusps; ``length`` is in the user's unit."""
    leg = eliminant.slice_map.fixed_leg
    q = Certified.of(Form(eliminant.at(length * eliminant.slice_map.scale), DEGREE_U))
    intervals = sorted((*_ends(root), multiplicity) for root, multiplicity in q.roots)
    return {
        **q.to_json(f"u = tan(theta{leg}/2)", intervals),
        "boxes": [{name: _box(cusp[name]) for name in coordinate_names(leg)} for cusp in cusps],
    }


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
