"""Slices solved together against the reference: the same documents byte for byte, by any guesses."""

from __future__ import annotations

import json
import random
from collections.abc import Callable, Iterable, Sequence
from fractions import Fraction
from itertools import product
from typing import Any

import numpy as np
import pytest

from rpr_solver import EXAMPLES, Eliminant, InputError, Manipulator, SolverError, solve_slice, solve_slices
from rpr_solver.slices.cusp_table import SliceSolver
from rpr_solver.slices.fast import proofs, scan
from rpr_solver.slices.fast.proofs import Guess
from rpr_solver.slices.reference import ReferenceSlice
from tests.rpr_solver.long_run import manipulator as random_manipulator
from tests.support.families import FAMILIES, family
from tests.support.sampling import sample
from tests.support.shared import census_of, eliminant_of

SCAN = [Fraction(k, 3) for k in range(1, 61, 4)]
SWALLOWTAIL = Manipulator(*map(Fraction, (2, -4, 4, 1, 4, 3)), orientation="cw")
"""It has a transition at L1 = 1."""


def text(make: Callable[[], Any]) -> str:
    """The document, or the error in its place."""
    try:
        return json.dumps(make().to_json())
    except SolverError as error:
        return f"refused: {error}"


def alone(eliminant: Eliminant, lengths: Iterable[Fraction], digits: int) -> list[str]:
    return [text(ReferenceSlice(eliminant, x, digits).solve) for x in lengths]


def together(eliminant: Eliminant, lengths: Sequence[Fraction], digits: int) -> list[str]:
    """By numpy, even where the lengths are few."""
    solver = SliceSolver(eliminant, lengths, digits)
    return [text(lambda place=place: solver.table(place)) for place in range(len(lengths))]


@pytest.fixture
def left(monkeypatch: pytest.MonkeyPatch) -> list[Fraction]:
    """The lengths of the slices that were left to the reference."""
    solved: list[Fraction] = []
    solve = ReferenceSlice.solve
    monkeypatch.setattr(ReferenceSlice, "solve", lambda self: (solved.append(self.length), solve(self))[1])
    return solved


@pytest.mark.parametrize(("leg", "digits"), sample(product((1, 2, 3), (15, 90)), 0, 3))
def test_a_chunk_is_its_slices(leg: int, digits: int, left: list[Fraction]) -> None:
    eliminant = eliminant_of(EXAMPLES["innocenti"], leg)
    answers = together(eliminant, SCAN, digits)
    assert len(left) <= 4, "nearly all slices are decided fast"
    assert answers == alone(eliminant, SCAN, digits)


def test_one_slice_is_that_of_a_chunk(left: list[Fraction]) -> None:
    """Blocks begin at different lengths."""
    eliminant = eliminant_of(EXAMPLES["innocenti"])
    expected = [json.dumps(solve_slice(eliminant, x, 30).to_json()) for x in SCAN]
    left.clear()
    assert together(eliminant, SCAN, 30) == expected
    assert len(left) <= 4
    assert together(eliminant, SCAN[5:], 30) == expected[5:]


@pytest.mark.parametrize("name", sample(FAMILIES, 1, 6, 9))
def test_degenerate_families(name: str) -> None:
    leg = list(FAMILIES).index(name) % 3 + 1
    eliminant = eliminant_of(family(name), leg)
    lengths = [Fraction(n, 2) for n in (7, 10, 16, 33)]
    assert together(eliminant, lengths, 20) == alone(eliminant, lengths, 20)


def near(length: Fraction, exponents: Iterable[int]) -> list[Fraction]:
    return [length + sign * Fraction(1, 10**n) for n in exponents for sign in (-1, 1)]


def test_near_a_transition() -> None:
    eliminant = eliminant_of(SWALLOWTAIL)
    lengths = [*near(Fraction(1), (1, 2, 3, 6, 12, 20, 40, 60)), Fraction(1)]
    answers = together(eliminant, lengths, 40)
    assert answers == alone(eliminant, lengths, 40)
    assert {json.loads(x)["count"] for x in answers} == {4, 6}


CORRUPTIONS: dict[str, Callable[[np.ndarray], np.ndarray]] = {
    "none": lambda u: np.full_like(u, np.nan),
    "infinite": lambda u: np.full_like(u, np.inf),
    "zero": np.zeros_like,
    "all real": lambda u: u.real + 0j,
    "all one root": lambda u: np.broadcast_to(u[:, :1], u.shape).copy(),
    "a double": lambda u: np.concatenate((u[:, :1], u[:, :-1]), axis=1),
    "pairs doubled": lambda u: np.where(u.imag > 0, u[:, u.imag[0].argmax()][:, None], u),
    "conjugates": lambda u: abs(u.imag) * 1j + u.real,
    "moved": lambda u: u * (1 + 1e-5),
    "moved far": lambda u: u * 1.7 + 0.3 * (u.imag == 0),
    "of the next slice": lambda u: np.roll(u, 1, axis=0),
    "shuffled": lambda u: np.random.default_rng(1).permuted(u, axis=1),
}


@pytest.mark.parametrize("name", CORRUPTIONS)
def test_wrong_guesses_change_no_answer(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    eliminant = eliminant_of(EXAMPLES["zein-flat"])
    lengths = SCAN[::2]
    expected = [json.dumps(solve_slice(eliminant, x, 20).to_json()) for x in lengths]
    right = proofs._roots_on_the_line
    monkeypatch.setattr(proofs, "_roots_on_the_line", lambda q: CORRUPTIONS[name](right(q)))
    assert together(eliminant, lengths, 20) == expected


@pytest.mark.parametrize("change", ["fewer", "twice", "nan", "elsewhere", "swapped"])
def test_wrong_places_of_real_roots_change_no_answer(change: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """The number of roots that are not real stays right, so only the proof of the poses can tell."""

    def corrupt(guess: Guess) -> Guess:
        real = list(guess.real)
        if not real:
            return guess
        if change == "fewer":
            real = real[:-1]
        if change == "twice":
            real[-1] = real[0]
        if change == "nan":
            real[0] = (float("nan"), 1.0)
        if change == "elsewhere":
            real = [(n + d / 7, d - n / 7) for n, d in real]
        if change == "swapped":
            real = [(d, n) for n, d in real]
        return Guess(tuple(real), guess.inside)

    eliminant = eliminant_of(EXAMPLES["zein-flat"])
    lengths = SCAN[::2]
    expected = [json.dumps(solve_slice(eliminant, x, 20).to_json()) for x in lengths]
    right = scan.guesses
    monkeypatch.setattr(scan, "guesses", lambda *args: [corrupt(x) for x in right(*args)])
    assert together(eliminant, lengths, 20) == expected


def test_what_is_asked_is_checked_at_once() -> None:
    eliminant = eliminant_of(EXAMPLES["zein-flat"])
    with pytest.raises(InputError, match=r"l1\[1\]"):
        solve_slices(eliminant, [1, 0], 15)
    with pytest.raises(InputError, match="digits"):
        solve_slices(eliminant, [1], 14)


def test_an_undecided_slice_has_its_error_in_its_place(monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(_self: ReferenceSlice) -> None:
        raise SolverError("not decided")

    monkeypatch.setattr(ReferenceSlice, "solve", refuse)
    tables = list(solve_slices(eliminant_of(SWALLOWTAIL), [1, 2, 3, 4], 15))
    assert isinstance(tables[0], SolverError)
    assert not isinstance(tables[1], SolverError)
    assert tables[1].count == 6


@pytest.mark.long
def test_random_manipulators() -> None:
    """Some thousand slices of any family, each at many lengths and with any leg fixed."""
    rng = random.Random(14)
    manipulators = [*map(family, FAMILIES), *(random_manipulator(rng) for _ in range(60))]
    for m in manipulators:
        eliminant = eliminant_of(m, rng.choice([1, 2, 3]))
        digits = rng.choice([15, 20, 40, 90])
        lengths = [Fraction(rng.randint(1, 4000), rng.choice([1, 10, 100, 997])) for _ in range(40)]
        assert together(eliminant, lengths, digits) == alone(eliminant, lengths, digits), m


@pytest.mark.long
@pytest.mark.parametrize("name", EXAMPLES)
def test_near_all_transitions(name: str) -> None:
    m = EXAMPLES[name]
    eliminant = eliminant_of(m)
    for transition in census_of(m, digits=80).transitions:
        lengths = near(Fraction(transition.length), (3, 6, 9, 15, 30, 60))
        assert together(eliminant, lengths, 30) == alone(eliminant, lengths, 30)
