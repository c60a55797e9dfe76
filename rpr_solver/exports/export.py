"""The script of a document for another system: a program with places for numbers, filled.

A program in ``programs/`` has places ``@NAME@``. A line that begins with ``@HEADING@``, ``@SLICE@`` or
``@EVENT@`` is repeated for each line of the heading, each slice or each event.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from importlib.resources import files
from typing import Any

from rpr_solver.errors import InputError, shown
from rpr_solver.exports.msolve import equations
from rpr_solver.exports.problem import Problem, problem_of

SYSTEMS = ("maple", "msolve", "pari", "sage", "sympy")

Fields = Mapping[str, str]
"""What is put at the places of a line, by name."""


def export(document: Mapping[str, Any], system: str) -> str:
    """A cusp table or a census as a script that repeats the computation in another system.

    The script derives J and E from the geometry, eliminates, and finds the cusps of each slice by the means
    of that system. It compares them with those of the document; its last line is ``agrees`` or ``differs``.
    msolve gets a system of equations instead, whose real solutions are the cusps.

    Args:
        document: a cusp table or a census, as JSON; for msolve a table of one slice.
        system: ``"maple"``, ``"msolve"``, ``"pari"``, ``"sage"`` or ``"sympy"``.

    Raises:
        InputError: naming ``document`` or ``system``.

    >>> from rpr_solver import EXAMPLES, table_document
    >>> print(export(table_document(EXAMPLES["zein-flat"], 10, digits=15), "pari").splitlines()[3])
    \\\\ Expected at L1 = 10: alpha_deg, theta1_deg, l2, l3
    """
    if system not in SYSTEMS:
        raise InputError.of("system", f"is {shown(system)}; it must be one of {', '.join(SYSTEMS)}")
    problem = problem_of(document)
    if system == "msolve":
        return equations(problem)
    program = (files("rpr_solver.exports") / "programs" / f"{system}.txt").read_text(encoding="utf-8")
    return "".join(f"{line}\n" for line in _filled(program, problem, system))


def _filled(program: str, problem: Problem, system: str) -> Iterator[str]:
    """Yields the lines of a program with its places filled."""
    common = _common(problem, system)
    repeated: Mapping[str, list[Fields]] = {
        "HEADING": [{"TEXT": line} for line in _heading(problem)],
        "SLICE": list(_slices(problem)),
        "EVENT": list(_events(problem)),
    }
    for line in program.splitlines():
        repetition = re.fullmatch(r"@(HEADING|SLICE|EVENT)@(.*)", line)
        if repetition is None:
            yield _put(line, common)
        else:
            for fields in repeated[repetition[1]]:
                yield _put(repetition[2], {**common, **fields}).rstrip()


def _put(line: str, fields: Fields) -> str:
    return re.sub(r"@(\w+)@", lambda place: fields[place[1]], line)


def _heading(problem: Problem) -> Iterator[str]:
    """What the script is about, and the cusps that it is to find."""
    yield from problem.about
    yield "It computes the cusps anew and compares them; the last line says agrees or differs."
    for part in problem.slices:
        if part.cusps is not None:
            yield f"Expected at L{problem.fixed_leg} = {part.length}: {', '.join(problem.names)}"
            yield from [f"  {'  '.join(cusp)}" for cusp in part.cusps] or ["  no cusp"]


def _common(problem: Problem, system: str) -> Fields:
    """The places that are the same throughout; a rational has another one for its two integers."""
    rationals = {"SQUARE": problem.square}
    for k, (leg, (cos, sin)) in enumerate(zip(problem.legs, problem.turns, strict=True), 1):
        rationals |= {f"AX{k}": leg.ax, f"AY{k}": leg.ay, f"X{k}": leg.x, f"COS{k}": cos, f"SIN{k}": sin}
    unknown = {"pari": "Mod('h, 'h^2 - SQUARE)", "sympy": "None"}.get(system, "")
    rational = {"sympy": f"QQ({_pair(problem.height or '')})"}.get(system, problem.height or "")
    return {
        **rationals,
        **{f"{name}_PAIR": _pair(number) for name, number in rationals.items()},
        **{f"Y{k}": str(leg.y) for k, leg in enumerate(problem.legs, 1)},
        "HEIGHT": unknown if problem.height is None else rational,
        "SIGN": str(problem.sign),
        "SIZE": str(problem.size),
        "PRECISION": str(problem.precision),
        "DIGITS": str(problem.digits),
        "LEG": str(problem.fixed_leg),
        "SLICES": str(len(problem.slices)),
        "TOTAL": str(len(problem.slices) + len(problem.events)),
    }


def _slices(problem: Problem) -> Iterator[Fields]:
    for part in problem.slices:
        cusps = part.cusps or ()
        yield {
            "LENGTH": part.length,
            "EXACT": part.exact,
            "COUNT": str(part.count),
            "ROWS": f"[{', '.join(map(_row, cusps))}]",
            "TEXTS": str(list(cusps)),
        }


def _events(problem: Problem) -> Iterator[Fields]:
    for event in problem.events:
        numbers = {"ROW": _row(event.numbers), "TEXT": str(event.numbers)}
        yield {"LENGTH": event.length, "SYSTEM": event.system, **numbers}


def _row(numbers: tuple[str, ...]) -> str:
    return f"[{', '.join(numbers)}]"


def _pair(number: str) -> str:
    top, _, bottom = number.partition("/")
    return f"{top}, {bottom or 1}"
