"""Full certificates: each part is verified, and each wrong one refused."""

from __future__ import annotations

from collections.abc import Callable
from copy import deepcopy
from typing import Any

import pytest

from rpr_solver import EXAMPLES, ClaimStatus, table_document, verify_document
from rpr_solver.verify.core.surds import Ring
from rpr_solver.verify.full import proportional
from tests.support.families import family

DOCUMENT = table_document(EXAMPLES["zein-flat"], 10, digits=15, certificate="full")
AT = "/slices/0/certificate/full/"


@pytest.mark.parametrize(
    ("change", "where"),
    [
        (lambda full: full, []),
        (lambda full: full["polynomial"]["coefficients"].__setitem__(3, "7"), ["polynomial"]),
        (lambda full: full["squarefree"].update(prime="1000005"), ["squarefree"]),
        (lambda full: full["real_roots"].pop(), ["real_roots"]),
        (lambda full: full["real_roots"][0].update(upper="0"), ["real_roots"]),
        (lambda full: full["real_roots"][1].update(multiplicity=2), ["real_roots"]),
        (lambda full: full["boxes"][0]["l2"].update(radius="1e-30"), ["boxes"]),
        (lambda full: full["boxes"].pop(), ["boxes"]),
    ],
)
def test_a_wrong_part_is_named(change: Callable[[dict[str, Any]], object], where: list[str]) -> None:
    document = deepcopy(DOCUMENT)
    change(document["slices"][0]["certificate"]["full"])
    assert [claim.at.removeprefix(AT) for claim in verify_document(document).refused] == where


def test_degenerate_slices_and_an_irrational_height() -> None:
    for manipulator in (family("both flat"), family("isosceles, irrational")):
        document = table_document(manipulator, 3, digits=15, certificate="full")
        verification = verify_document(document)
        assert verification.accepted
        full = [claim for claim in verification.claims if claim.at.startswith(AT)]
        assert len(full) >= 3
        assert {claim.status for claim in full} == {ClaimStatus.PROVED}


def test_multiples() -> None:
    ring = Ring(3)
    form = [(1, 1), (0, 0), (2, -1)]
    turned = [ring.times(x, (2, 5)) for x in form]
    assert proportional(ring, turned, form)
    assert not proportional(ring, [*turned[:2], (1, 0)], form)
    assert not proportional(ring, [(0, 0)] * 3, form)
    assert proportional(ring, [], [])
