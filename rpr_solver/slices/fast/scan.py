"""Many slices of one manipulator: what is quickly proved for all at once, and the rest one by one.

It is proved modulo a prime that Q has 24 simple roots and no spurious one; by discs in double precision that
enough of them are not real (mathematics.md#laguerres-discs); and by floats with bounds of their errors, or by
balls, that a pose is above each of the others (mathematics.md#poses-by-floats). A slice not decided so, as
beside a transition, goes to reference.py. In any case what is printed is what the box of the pose on a grid
decides (grid.py), so the document is the same byte for byte.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from fractions import Fraction

from flint import nmod, nmod_mat, nmod_poly

from rpr_solver.exact.modular import primes
from rpr_solver.exact.real_roots import real_roots
from rpr_solver.slices.eliminant import DEGREE_L, DEGREE_U, Eliminant
from rpr_solver.slices.fast.decimals import PoseSharpener
from rpr_solver.slices.fast.discs import Guess, guesses
from rpr_solver.slices.fast.proofs import NearPose, proved_boxes
from rpr_solver.slices.grid import GridSlice, first_bits
from rpr_solver.slices.real_poses import PoseFinder
from rpr_solver.slices.reference import LoneSlice
from rpr_solver.slices.slice_table import RootCertificate, SliceTable, root_certificate

_FEWEST, _FEWEST_TO_IMPORT = 4, 64
"""Fewer slices do not repay the work of numpy, or its import."""
_GUESS_BITS = 64
BLOCK = 128
"""Slices whose roots are guessed at once: progress is told, and memory bounded, in between."""


class SliceChunk:
    """Slices of one manipulator and fixed leg, each solved when it is asked for.

    Args:
        eliminant: of the manipulator and its fixed leg.
        lengths: of the fixed leg, in the user's unit, > 0.
        digits: significant digits of every printed number.
    """

    def __init__(self, eliminant: Eliminant, lengths: Sequence[Fraction], digits: int) -> None:
        self.eliminant, self.lengths, self.digits = eliminant, lengths, digits
        self.bits = first_bits(digits)
        self._scaled = [x * eliminant.slice_map.scale for x in lengths]
        self._guesses: dict[int, Guess] = {}
        self._boxes: dict[int, list[NearPose] | None] = {}
        self._exponent = 0

    def table(self, place: int) -> SliceTable:
        """The table of one of the slices.

        Raises:
            SolverError: the slice could not be decided.
        """
        table = self._quickly(place) if _is_generic(self.eliminant, self._scaled[place]) else None
        return table or LoneSlice(self.eliminant, self.lengths[place], self.digits).solve()

    def _quickly(self, place: int) -> SliceTable | None:
        """The table of a generic slice, if it is decided at the first precision."""
        guess = self._guess(place)
        if len(guess.real) + 2 * guess.inside != DEGREE_U:
            return None
        return self._by_boxes(place) or self._by_balls(place, guess)

    def _by_boxes(self, place: int) -> SliceTable | None:
        """The table, if floats prove the poses."""
        boxes = self._boxes.get(place)
        if boxes is None:
            return None
        found = _sharpener(self.eliminant, self.digits).cusps(self._scaled[place], boxes, self._exponent)
        if found is None:
            return None
        certificate = self._certificate(len(boxes))
        leg, length = self.eliminant.slice_map.fixed_leg, self.lengths[place]
        return SliceTable.of_sorted(leg, length, self.digits, certificate, found, self.bits)

    def _by_balls(self, place: int, guess: Guess) -> SliceTable | None:
        """The table, if balls prove the poses."""
        slice_map, scaled = self.eliminant.slice_map, self._scaled[place]
        poses = _finder(self.eliminant, self.bits).at(scaled).poses(guess.real)
        if poses is None:
            return None
        cusps = GridSlice(slice_map, scaled, self.digits, self.bits).points(poses)
        if cusps is None:
            return None
        certificate, length = self._certificate(len(guess.real)), self.lengths[place]
        return SliceTable.of(slice_map.fixed_leg, length, self.digits, certificate, cusps)

    def _certificate(self, real_roots: int) -> RootCertificate:
        return root_certificate(self.eliminant.slice_map.fixed_leg, [(DEGREE_U, 1)], real_roots, "balls")

    def _guess(self, place: int) -> Guess:
        if len(self.lengths) < (_FEWEST if "numpy" in sys.modules else _FEWEST_TO_IMPORT):
            return _proved_guess(self.eliminant, self._scaled[place])
        if place not in self._guesses:
            self.guess_from(place - place % BLOCK)
        return self._guesses[place]

    def guess_from(self, first: int) -> None:
        """Guess the roots of a block of slices, and prove poses; :meth:`table` does so when it needs them."""
        lengths = self._scaled[first : first + BLOCK]
        block = guesses(self.eliminant, lengths)
        self._guesses = dict(enumerate(block, first))
        self._exponent, boxes = proved_boxes(self.eliminant, lengths, [x.real for x in block])
        self._boxes = dict(enumerate(boxes, first))


def _proved_guess(eliminant: Eliminant, length: Fraction) -> Guess:
    """The number of real roots of one generic slice, and these roots, by FLINT."""
    roots = [float(root.refined(_GUESS_BITS)) for root in real_roots(eliminant.at(length))]
    return Guess(tuple((u, 1.0) for u in roots), (DEGREE_U - len(roots)) // 2)


def _sharpener(eliminant: Eliminant, digits: int) -> PoseSharpener:
    if ("sharpener", digits) not in eliminant.kept:
        eliminant.kept["sharpener", digits] = PoseSharpener(eliminant, digits)
    sharpener: PoseSharpener = eliminant.kept["sharpener", digits]
    return sharpener


def _finder(eliminant: Eliminant, bits: int) -> PoseFinder:
    if ("finder", bits) not in eliminant.kept:
        eliminant.kept["finder", bits] = PoseFinder(eliminant, bits)
    finder: PoseFinder = eliminant.kept["finder", bits]
    return finder


def _is_generic(eliminant: Eliminant, length: Fraction) -> bool:
    """Proof modulo a prime that Q has 24 finite simple roots, none spurious, and w and q no common one."""
    f = eliminant.slice_map.f
    p, matrix = _residues(eliminant)
    if length.denominator % p == 0:
        return False
    x = nmod(length.numerator, p) / nmod(length.denominator, p)
    powers = [nmod(1, p)]
    for _ in range(DEGREE_L):
        powers.append(powers[-1] * x)
    q = nmod_poly((matrix * nmod_mat(DEGREE_L + 1, 1, powers, p)).entries(), p)
    along, closed = nmod_poly(f.collinear(), p), nmod_poly(f.closed(length), p)
    if q.degree() != DEGREE_U or closed.degree() != 2:
        return False
    spurious = along * closed * nmod_poly([1, 0, 1], p)
    pairs = (along, closed), (q, q.derivative()), (q, spurious)
    return all(first.gcd(second).degree() == 0 for first, second in pairs)


def _residues(eliminant: Eliminant) -> tuple[int, nmod_mat]:
    """The coefficients of Q modulo a prime, rows by powers of u."""
    if "residues" not in eliminant.kept:
        p, omega = next(primes(eliminant.slice_map.radicand))
        pairs = zip(eliminant.a.entries(), eliminant.b.entries(), strict=True)
        residues = [int((a + omega * b) % p) for a, b in pairs]
        eliminant.kept["residues"] = p, nmod_mat(DEGREE_U + 1, DEGREE_L + 1, residues, p)
    kept: tuple[int, nmod_mat] = eliminant.kept["residues"]
    return kept
