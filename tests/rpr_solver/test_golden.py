"""Answers change only together with SOLVER_VERSION, which is part of every cache key."""

import pytest

from rpr_solver import SOLVER_VERSION
from tests.support import golden

KNOWN = golden.known()


@pytest.mark.parametrize(
    "subject",
    [
        pytest.param(s, marks=pytest.mark.long if n % 2 else pytest.mark.slow)
        if s.startswith("family")
        else s
        for n, s in enumerate(golden.SUBJECTS)
    ],
)
def test_an_answer_changes_only_with_a_new_solver_version(subject: str) -> None:
    assert KNOWN["solver_version"] == SOLVER_VERSION, "run `python -m tests.support.golden --write`"
    changed = [name for name, value in golden.hashes(subject).items() if KNOWN["sha256"].get(name) != value]
    assert not changed, f"an answer changed without a new SOLVER_VERSION: {changed}"


def test_every_golden_document_is_compared() -> None:
    subjects = {name.split(":")[0] for name in KNOWN["sha256"]}
    assert subjects == set(golden.SUBJECTS)
