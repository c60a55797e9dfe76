"""Many slices of one manipulator: what is quickly proved for all at once.

It is proved modulo a prime that Q has 24 simple roots and no spurious one; by discs in double precision that
enough of them are not real (mathematics.md#laguerres-discs); and by floats with bounds of their errors that a
pose is above each of the others (mathematics.md#poses-by-floats). A slice not decided so, as near a
transition, is left to the reference. In any case what is printed is what the box of the pose on a grid
decides (grid.py), so the document is the same byte for byte.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Sequence
from fractions import Fraction

from flint import nmod, nmod_mat, nmod_poly

from rpr_solver.exact.modular import primes
from rpr_solver.slices.eliminant import DEGREE_L, DEGREE_U, Eliminant
from rpr_solver.slices.fast.decimals import PoseSharpener
from rpr_solver.slices.fast.discs import guesses
from rpr_solver.slices.fast.proofs import NearPose, proved_boxes
from rpr_solver.slices.grid import first_bits
from rpr_solver.slices.slice_table import SliceTable, root_certificate

_FEWEST, _FEWEST_TO_IMPORT = 4, 64
"""Fewer slices do not repay the work of numpy, or its import."""
BLOCK = 128
"""Slices whose poses are proved at once: progress is reported, and memory bounded, in between."""


def fast_tables(
    eliminant: Eliminant, lengths: Sequence[Fraction], digits: int
) -> Callable[[int], SliceTable | None]:
    """From the place of a length the table of its slice; None where that is left to the reference.

    Args:
        eliminant: of the manipulator and its fixed leg.
        lengths: of the fixed leg, in the user's unit, > 0.
        digits: significant digits of every printed number.
    """
    if len(lengths) < (_FEWEST if "numpy" in sys.modules else _FEWEST_TO_IMPORT):
        return lambda _place: None
    return _Scan(eliminant, lengths, digits).table


class _Scan:
    """Slices of which a block is proved when the first of it is asked for, and each printed by itself."""

    def __init__(self, eliminant: Eliminant, lengths: Sequence[Fraction], digits: int) -> None:
        self.eliminant, self.lengths, self.digits = eliminant, lengths, digits
        self._scaled = [x * eliminant.slice_map.scale for x in lengths]
        self._boxes: dict[int, list[NearPose] | None] = {}
        self._exponent = 0

    def table(self, place: int) -> SliceTable | None:
        if not _is_generic(self.eliminant, self._scaled[place]):
            return None
        if place not in self._boxes:
            self._prove_block(place - place % BLOCK)
        boxes = self._boxes[place]
        if boxes is None:
            return None
        cusps = _sharpener(self.eliminant, self.digits).cusps(self._scaled[place], boxes, self._exponent)
        if cusps is None:
            return None
        leg, length = self.eliminant.slice_map.fixed_leg, self.lengths[place]
        certificate = root_certificate(leg, [(DEGREE_U, 1)], len(boxes), "balls")
        return SliceTable.of_sorted(leg, length, self.digits, certificate, cusps, first_bits(self.digits))

    def _prove_block(self, first: int) -> None:
        """Prove the poses of a block of slices; those of the last block are forgotten."""
        lengths = self._scaled[first : first + BLOCK]
        roots = guesses(self.eliminant, lengths)
        self._exponent, boxes = proved_boxes(self.eliminant, lengths, [x.real for x in roots])
        complete = (len(x.real) + 2 * x.inside == DEGREE_U for x in roots)
        self._boxes = {
            place: found if has_all else None
            for place, (found, has_all) in enumerate(zip(boxes, complete, strict=True), first)
        }


def _sharpener(eliminant: Eliminant, digits: int) -> PoseSharpener:
    if ("sharpener", digits) not in eliminant.kept:
        eliminant.kept["sharpener", digits] = PoseSharpener(eliminant, digits)
    sharpener: PoseSharpener = eliminant.kept["sharpener", digits]
    return sharpener


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
