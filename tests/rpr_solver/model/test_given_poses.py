"""Poses in the frame of the points: they put the given platform on legs of the given lengths."""

from __future__ import annotations

from decimal import Decimal
from typing import Any

import pytest
from mpmath import mp, mpf

from rpr_solver import Manipulator, poses

Points = list[list[Any]]
CASES: list[tuple[Points, Points]] = [
    ([[1, 2], [4, 6], [1, 10]], [[7, 1], [7, 4], [3, 4]]),
    ([[0, 0], [10, 0], [5, "5*sqrt(3)"]], [[-3, 0], [3, 0], [0, "3*sqrt(3)"]]),
    ([[0, 2], [0, 12], ["-5*sqrt(3)", 7]], [[0, 1], [0, 7], ["-2*sqrt(6)", 2]]),
    ([[0, 0], [0, 10], [5, 5]], [[3, 0], [0, 3], [3, 3]]),
]


def number(x: Any) -> mpf:
    times, root, square = str(x).partition("sqrt(")
    if not root:
        return mpf(times)
    return mpf(times.rstrip("*").replace("-", "-1") if times in ("", "-") else times.rstrip("*")) * mp.sqrt(
        mpf(square.rstrip(")"))
    )


@pytest.mark.parametrize(("base", "platform"), CASES)
@pytest.mark.parametrize("digits", [15, 60])
def test_the_given_platform_stands_on_its_legs(base: Points, platform: Points, digits: int) -> None:
    legs = ("6", "8", "7")
    table = poses(Manipulator(base={"points": base}, platform={"points": platform}), *legs, digits=digits)
    assert table.count > 0
    with mp.workdps(2 * digits):
        for pose in table.poses:
            x, y, phi = (mpf(text) for text in (pose.x, pose.y, pose.phi_deg))
            turn = mp.expjpi(phi / 180)
            for (u, v), (a, b), length in zip(platform, base, legs, strict=True):
                joint = x + 1j * y + turn * (number(u) + 1j * number(v))
                assert abs(abs(joint - number(a) - 1j * number(b)) - mpf(length)) < mpf(10) ** (3 - digits)


def test_what_is_0_or_180_is_printed_so() -> None:
    platform = {"points": [[0, 0], [4, 0], [0, 5]]}
    base = {"points": [[0, 0], [4, 0], [0, 3]]}
    texts = [(p.x, p.y, p.phi_deg) for p in poses(Manipulator(base=base, platform=platform), 2, 2, 4).poses]
    assert ("0", "2." + "0" * 89, "0") in texts
    turned = {"points": [[0, 0], [-4, 0], [0, -5]]}
    texts = [(p.x, p.y, p.phi_deg) for p in poses(Manipulator(base=base, platform=turned), 2, 2, 4).poses]
    assert ("0", "2." + "0" * 89, "180." + "0" * 87) in texts


def test_digits_are_those_of_more_digits_rounded() -> None:
    base, platform = CASES[2]
    manipulator = Manipulator(base={"points": base}, platform={"points": platform})
    few, many = (poses(manipulator, 6, 8, 7, digits=digits).poses for digits in (20, 50))
    for short, long in zip(few, many, strict=True):
        for text, exact in zip(
            (short.x, short.y, short.phi_deg), (long.x, long.y, long.phi_deg), strict=True
        ):
            assert text is not None
            assert exact is not None
            unit = Decimal(1).scaleb(Decimal(text).adjusted() - 19)
            assert abs(Decimal(text) - Decimal(exact)) <= unit / 2


def test_without_points_there_is_no_frame() -> None:
    pose = poses(Manipulator(10, 5, "5*sqrt(3)", 6, 7, 5), 6, 8, 7, digits=15).poses[0]
    assert (pose.x, pose.y, pose.phi_deg) == (None, None, None)
    assert not {"x", "y", "phi_deg"} & pose.to_json().keys()
