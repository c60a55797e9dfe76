"""Scripts are texts with places for numbers, and a heading of comments."""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction

from rpr_solver.exports.problem import Problem


def filled(script: str, problem: Problem, parts: Mapping[str, str], comment: str) -> str:
    """A script with its places ``@NAME@`` filled; ``comment`` begins a comment."""
    size = sum(abs(Fraction(x)) for leg in problem.legs for x in (leg.ax, leg.ay, leg.x))
    common = {
        "PRECISION": str(problem.precision),
        "DIGITS": str(problem.digits),
        "SQUARE": problem.square,
        "SIGN": str(problem.sign),
        "SIZE": str(int(size) + 1),
        "LEG": str(problem.fixed_leg),
        "TOTAL": str(len(problem.slices) + len(problem.events)),
    }
    for name, text in {**common, **parts}.items():
        script = script.replace(f"@{name}@", text)
    return heading(problem, comment) + script


def heading(problem: Problem, comment: str) -> str:
    """What the script is about, and the cusps that it is to find, as comments."""
    lines = [
        *problem.about,
        "It computes the cusps anew and compares them; the last line says agrees or differs.",
    ]
    for part in problem.slices:
        if part.cusps is not None:
            lines.append(f"Expected at L{problem.fixed_leg} = {part.length}: {', '.join(problem.names)}")
            lines += [f"  {'  '.join(cusp)}" for cusp in part.cusps] or ["  no cusp"]
    return "".join(f"{comment}{line}".rstrip() + "\n" for line in lines)
