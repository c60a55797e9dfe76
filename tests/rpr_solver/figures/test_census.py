"""The census: every count and every transition, narrow windows widened and marked."""

from typing import Any

import pytest

from rpr_solver import EXAMPLES, Manipulator, leg_poses
from rpr_solver.figures.census import census_figure
from rpr_solver.figures.views import figure_of
from tests.support.pictures import GEOMETRY, check, sheet_of, words
from tests.support.sampling import long, sample

KINDS = ["swallowtail", "beak-to-beak", "lips", "several"]


def document(
    lengths: list[str], counts: list[int], start: str = "0", stop: str | None = None
) -> dict[str, Any]:
    ends = [start, *lengths, stop]
    return {
        "geometry": GEOMETRY,
        "fixed_leg": 1,
        "range": {"from": start, "to": stop},
        "transitions": [{"l1": x, "kind": KINDS[k % 4], "events": []} for k, x in enumerate(lengths)],
        "intervals": [{"from": ends[k], "to": ends[k + 1], "count": n} for k, n in enumerate(counts)],
    }


CASES = {
    "none": document([], [4]),
    "none-in-a-range": document([], [0], "3", "7"),
    "one": document(["2.5"], [0, 2]),
    "narrow": document(["5", "5.00000001", "30"], [0, 2, 4, 6]),
    "closer-than-floats": document(["5." + "0" * 30 + "1", "5." + "0" * 30 + "2"], [2, 4, 2], "5", "6"),
    "many": document([str(k) for k in range(1, 40)], [2 * (k % 7) for k in range(40)]),
    "tiny": document(["1e-30", "3e-30"], [0, 2, 0]),
}


@pytest.mark.parametrize("name", sample(CASES, 0, 3, 4))
def test_pictures(name: str) -> None:
    check(census_figure(CASES[name]))


def test_an_open_axis_without_transitions_has_the_size_of_the_manipulator() -> None:
    sides = max(float(x) for name, x in GEOMETRY.items() if name != "orientation")
    node = {"kind": "node", "from": "0", "to": "75", "count": 2}
    for made, least in (
        (document([], [0]), sides),
        (document([], [0], "50"), 50 + sides),
        ({**document([], [0]), "degenerate": [node]}, 75),
    ):
        [ax] = sheet_of(census_figure(made)).axes
        assert least < ax.get_xlim()[1] < 1.3 * least


def test_bounds_of_transitions_are_shaded() -> None:
    plain = CASES["narrow"]
    bounds = [{"from": "4.9", "to": "5.2"}, {"from": None, "to": None}, {"from": "29", "to": "31"}]
    both = zip(plain["transitions"], bounds, strict=True)
    made = census_figure({**plain, "tolerance": {"d1": "0.1"}, "transitions": [t | more for t, more in both]})
    shades = [sheet_of(one).axes[0].patches for one in (made, census_figure(plain))]
    assert len(shades[0]) == len(shades[1]) + 2
    assert "within the tolerance: 4.9 to 5.2; 29 to 31." in made.description
    check(made)


def test_poses_along_a_leg() -> None:
    found = leg_poses(EXAMPLES["innocenti"], {"l1": 17, "l3": 15}, 0, 40, digits=15)
    figure = found.figure()
    check(figure)
    assert {"poses", "fold", "L2, true to scale", "8.722", "6"} <= set(words(figure))
    assert "0 from 0 to 8.722; 2 from 8.722 to 11.06; " in figure.description
    [ax] = sheet_of(figure).axes
    assert ax.get_xlim() == (0, 40)
    assert figure_of(found.to_json()).svg() == figure.svg()


@pytest.mark.parametrize(
    ("base", "lengths"), [long([4, 5, 6], {"l1": 3, "l2": 3}), ([5, 6, 5], {"l2": 4, "l3": 4})]
)
def test_poses_along_a_leg_of_symmetric_machines(base: list[int], lengths: dict[str, int]) -> None:
    robot = Manipulator.from_json({"base": {"sides": base}, "platform": {"sides": [3, 2, 3]}})
    check(leg_poses(robot, lengths, digits=15).figure())
