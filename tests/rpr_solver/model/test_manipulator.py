import json
from decimal import Decimal
from pathlib import Path

import pytest

from rpr_solver import EXAMPLES, InputError, Manipulator, census, cusp_table, table_json

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


def test_canonical_json_reads_back() -> None:
    for manipulator in EXAMPLES.values():
        assert Manipulator.from_json(manipulator.to_json()) == manipulator


def test_every_wrong_field_is_named() -> None:
    assert problems(d1="absent", a3x="x", colour="red").keys() == {
        "geometry.d1",
        "geometry.a3x",
        "geometry.colour",
    }
    assert "A1 and A2 coincide" in problems(a2x=0)["geometry.a2x"]
    assert "A1 and A3 coincide" in problems(a3x=0, a3y=0)["geometry.a3x"]
    assert "A2 and A3 coincide" in problems(a3x="15.91", a3y=0)["geometry.a3x"]
    assert problems(d1=0, d2=-1).keys() == {"geometry.d1", "geometry.d2"}
    assert "at most d1 + d2 = 33.58" in problems(d3="33.59")["geometry.d3"]
    assert "neither" in problems(orientation="left")["geometry.orientation"]
    assert "neither" in problems(orientation=None)["geometry.orientation"]


@pytest.mark.parametrize("obj", [None, [], "innocenti", 3])
def test_what_is_no_object_is_refused(obj: object) -> None:
    with pytest.raises(InputError, match="geometry"):
        Manipulator.from_json(obj)  # type: ignore[arg-type]


def test_a_geometry_may_name_its_schema(tmp_path: Path) -> None:
    robot = tmp_path / "robot.json"
    robot.write_text(json.dumps({"$schema": "schemas/geometry.json", **EXAMPLES["innocenti"].to_json()}))
    assert Manipulator.from_file(robot) == EXAMPLES["innocenti"]


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
