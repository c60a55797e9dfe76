import json
from decimal import Decimal
from fractions import Fraction
from pathlib import Path

import pytest
from flint import arb, ctx

from rpr_solver import EXAMPLES, InputError, Manipulator, census, cusp_table, table_json
from rpr_solver.triangles import Surd

ARTICLE: dict[str, object] = {
    "a2x": "15.91", "a3x": "0", "a3y": "10", "d1": "17.04", "d2": "16.54", "d3": "20.84",
}  # fmt: skip


def problems(**changes: object) -> dict[str, str]:
    obj = {k: v for k, v in {**ARTICLE, **changes}.items() if v != "absent"}
    with pytest.raises(InputError) as caught:
        Manipulator.from_json(obj)
    return {p.field: p.message for p in caught.value.problems}


def test_equal_geometries_have_one_hash() -> None:
    written = {
        "a2x": Decimal("15.910"),
        "a3x": 0,
        "a3y": "1e1",
        "d1": "426/25",
        "d2": "16.54",
        "d3": "020.84",
    }
    assert Manipulator.from_json(written) == EXAMPLES["innocenti"]
    assert Manipulator.from_json(written).geometry_hash == EXAMPLES["innocenti"].geometry_hash


def test_the_hash_is_the_same_on_every_machine_and_in_every_version() -> None:
    assert EXAMPLES["innocenti"].geometry_hash == (
        "sha256:4a1f436b75ff0f42fbdf88a45157367229732340c0a95c36e0768583676bb06b"
    )


def test_orientation_matters_except_for_a_flat_platform() -> None:
    mirrored = Manipulator.from_json({**ARTICLE, "orientation": "cw"})
    assert mirrored.geometry_hash != EXAMPLES["innocenti"].geometry_hash
    flat = EXAMPLES["zein-flat"]
    assert Manipulator.from_json({**flat.to_json(), "orientation": "cw"}) == flat


def test_every_wrong_field_is_named() -> None:
    assert problems(d1="absent", a3x="x", colour="red").keys() == {
        "geometry.d1",
        "geometry.a3x",
        "geometry.colour",
    }
    assert "A1 = A2" in problems(a2x=0)["geometry.a2x"]
    assert "A1, A2 and A3 are one point" in problems(a2x=0, a3x=0, a3y=0)["geometry"]
    assert problems(d1=-1, d2=-1).keys() == {"geometry.d1", "geometry.d2"}
    assert "at most d1 + d2 = 33.58" in problems(d3="33.59")["geometry.d3"]
    assert "neither" in problems(orientation="left")["geometry.orientation"]
    assert "neither" in problems(orientation=None)["geometry.orientation"]


def test_a_file_may_have_a_name_and_a_unit_or_be_an_answer(tmp_path: Path) -> None:
    robot, innocenti = tmp_path / "robot.json", EXAMPLES["innocenti"]
    named = {"name": "Gripper", "unit": "mm", **innocenti.to_json()}
    [table] = cusp_table(innocenti, 3, digits=15)
    answer = table_json(innocenti, 1, 15, [table.to_json()])
    for content in (named, {"geometry": named}, answer, census(innocenti, digits=15, stop=1).to_json()):
        robot.write_text(json.dumps(content))
        assert Manipulator.from_file(robot).geometry_hash == innocenti.geometry_hash
    for wrong in (
        {**named, "unit": ["mm"]},
        {**named, "geometry": named},
        {"geometry": [named]},
        {"geometry": {}},
    ):
        robot.write_text(json.dumps(wrong))
        with pytest.raises(InputError, match="geometry"):
            Manipulator.from_file(robot)


IRRATIONAL = {
    "base": {"equilateral": 10},
    "platform": {"sides": ["3*sqrt(2)", 4, "5/3"]},
    "orientation": "cw",
}


def test_a_manipulator_may_be_two_triangles() -> None:
    by_json = Manipulator.from_json(IRRATIONAL)
    by_name = Manipulator(**IRRATIONAL)  # type: ignore[arg-type]
    by_lengths = Manipulator(10, 5, "5*sqrt(3)", "3*sqrt(2)", 4, "5/3", "cw")
    assert by_json == by_name == by_lengths == Manipulator(**by_json.to_dict())
    assert by_json.geometry_hash == by_lengths.geometry_hash
    assert Manipulator.from_json(by_json.to_json()) == by_json
    assert (by_json.a2x, by_json.a3y, by_json.orientation) == (10, Surd.root(75), "cw")
    assert not by_json.is_rational
    assert EXAMPLES["innocenti"].is_rational


def test_lengths_in_balls_and_doubles_enclose_the_roots() -> None:
    m = Manipulator.from_json(IRRATIONAL)
    squares = [100, 25, 75, 18, 16, Fraction(25, 9)]
    with ctx.workprec(200):
        balls = m.balls()
        for x, q in zip(balls, squares, strict=True):
            assert (x * x - arb(q.numerator) / q.denominator).contains(0)
        assert all(x.rel_accuracy_bits() > 150 for x in balls)
    for x, (low, high), square in zip(m.doubles(), m.intervals(), squares, strict=True):
        assert low <= x <= high <= low * (1 + 1e-15)
        assert Fraction(low) ** 2 <= square <= Fraction(high) ** 2
    exact = Manipulator(4, 1, "-0.5", 1, "0.1", 1)
    assert exact.intervals()[:4] == [(4, 4), (1, 1), (-0.5, -0.5), (1, 1)]
    low, high = exact.intervals()[4]
    assert Fraction(low) < exact.d2 < Fraction(high)
