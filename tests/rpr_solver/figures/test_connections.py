"""Connections of poses as pictures: every pair in its place, the reasons in words, and two ways to draw."""

from __future__ import annotations

import json
from pathlib import Path
from random import Random
from typing import Any

import pytest

from rpr_solver import EXAMPLES, Obstacle, pose_connections
from rpr_solver.figures.views import figure_of
from service.cli.main import main
from tests.rpr_solver.figures.test_layouts import at_every_width
from tests.support.pictures import GEOMETRY, sheet_of, words
from tests.support.sampling import sample


def document(random: Random, count: int, vectors: int) -> dict[str, Any]:
    """A matrix of random words, symmetric, in which some poses are joined in groups."""
    groups = [random.randrange(4) for _ in range(count)]
    of_paths = Obstacle.TOO_NARROW, Obstacle.ILL_CONDITIONED  # which no matrix has
    apart = [word.value for word in Obstacle if word not in of_paths]
    matrix = [["joined" if a == b else random.choice(apart) for b in groups] for a in groups]
    legs = [{f"l{leg}": f"{random.uniform(1, 1e4):.9g}" for leg in (1, 2, 3)} for _ in range(vectors)]
    angles = "alpha_deg", "theta2_deg"
    poses = [
        {
            **(legs[2 * place // count] if vectors == 2 else {}),
            **{name: f"{random.uniform(-180, 180):.15g}" for name in angles},
            "sign": random.choice((1, -1, 0, None)),
        }
        for place in range(count)
    ]
    return {
        "geometry": GEOMETRY,
        "fixed_leg": 2,
        **(legs[0] if vectors == 1 else {}),
        "between": random.choice([None, {"from": "1234.567", "to": "2345.678"}]),
        "limits": random.choice(
            [None, {"l1": {"min": "3.25", "max": None}, "l3": {"min": "5", "max": "1e4"}}]
        ),
        "poses": poses,
        "groups": [[k for k, g in enumerate(groups, 1) if g == own] for own in dict.fromkeys(groups)],
        "matrix": [[matrix[max(i, k)][min(i, k)] for k in range(count)] for i in range(count)],
    }


@pytest.mark.parametrize("count", sample([0, 1, 2, 5, 6, 12], 0, 4))
def test_no_label_covers_another_at_any_width(count: int) -> None:
    random = Random(count)
    for vectors in (1, 2) if count > 1 else (1,):
        at_every_width(figure_of(document(random, count, vectors)))


def test_each_pair_has_its_cell_and_its_reason() -> None:
    found = document(Random(7), 8, 1)
    [ax] = sheet_of(figure_of(found)).axes
    cells = [patch for patch in ax.patches if patch.get_fill()]
    joined = sum(word == "joined" for row in found["matrix"] for word in row)
    assert len(cells) == 64
    assert sum(line.get_marker() == "o" for line in ax.lines) == joined
    apart = {word: sum(word == own for row in found["matrix"] for own in row) for word in SIGNS}
    signs = [text.get_text() for text in ax.texts]
    assert {word: signs.count(SIGNS[word]) for word in SIGNS} == apart


SIGNS = {"opposite-signs": "±", "other-aspect": "A", "separated-by-limits": "L", "outside-limits": "×"}


def test_joined_poses_are_beside_each_other() -> None:
    answer = pose_connections(EXAMPLES["innocenti"], 27, "25.7", "9.2")
    figure = answer.figure()
    assert figure.title == "4 poses, joined: 1-3, 2 and 4"
    numbers = [word for word in words(figure) if word.isdigit()]
    assert numbers[::2] == numbers[1::2] == ["1", "3", "2", "4"]
    assert "another aspect: 2-4." in figure.description
    assert "A another aspect" in words(figure)
    assert "? undecided" not in words(figure)


def test_the_command_draws_its_answer_and_a_document(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    asked = ["pose-connections", "innocenti", "--l1", "27", "--l2", "20", "--l3", "20"]
    expected = pose_connections(EXAMPLES["innocenti"], 27, 20, 20).figure()
    assert main([*asked, "--format", "svg"]) == 0
    assert capsys.readouterr().out == expected.svg()
    assert main([*asked, "--json"]) == 0
    path, target = tmp_path / "matrix.json", tmp_path / "matrix.svg"
    path.write_text(capsys.readouterr().out)
    drawn = ["plot", str(path), "--kind", "connections"]
    assert main([*drawn, "--width", "86mm", "-o", str(target)]) == 0
    assert target.read_text() == expected.styled(width_mm=86).svg()
    path.write_text(json.dumps({**GEOMETRY}))
    assert main(drawn) == 2
    assert "has no connections; give what connections --format json writes" in capsys.readouterr().err
