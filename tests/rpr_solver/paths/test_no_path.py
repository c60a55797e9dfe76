"""What the document of two poses without a path says."""

from fractions import Fraction

from rpr_solver import EXAMPLES, NoPath, Obstacle, PathPose, Resolution

ENDS = PathPose(1, "1", "2"), PathPose(2, "3", "4")
JOINT = Fraction(27), Fraction(20), Fraction(20)


def test_only_what_is_proved_is_denied() -> None:
    for obstacle in Obstacle:
        none = NoPath(EXAMPLES["innocenti"], 1, 15, JOINT, *ENDS, obstacle)
        document = none.to_json()
        assert document["obstacle"] == str(obstacle)
        assert document["connected"] is (None if obstacle is Obstacle.UNDECIDED else False)
        assert (document["between"], document["limits"], document["resolution"]) == (None, None, None)


def test_limits_and_resolution_are_in_the_document() -> None:
    none = NoPath(
        EXAMPLES["innocenti"],
        1,
        15,
        JOINT,
        *ENDS,
        Obstacle.UNDECIDED,
        between=(Fraction(25), Fraction(30)),
        limits={2: (Fraction(5), None)},
        resolution=Resolution(Fraction(360, 512), Fraction(5, 8)),
    )
    document = none.to_json()
    assert document["between"] == {"from": "25", "to": "30"}
    assert document["limits"] == {"l2": {"min": "5", "max": None}}
    assert document["resolution"] == {"angle_deg": "0.703125", "length": "0.625"}
