"""Strands are drawn smoothly at every magnification."""

from rpr_solver import EXAMPLES, singular_curves
from rpr_solver.figures.slice_floats import SliceFloats
from rpr_solver.figures.strands import cusps_of, drawn, strands_of
from rpr_solver.notebook.scene import Box, Point, distance

CURVES = singular_curves(EXAMPLES["zein-flat"], 3).to_json()
FLOATS = SliceFloats.of(CURVES["geometry"], 1, "3")
STRANDS = strands_of(CURVES)


def test_every_cusp_is_a_vertex_where_the_document_says() -> None:
    cusps = cusps_of(STRANDS)
    assert [cusp["cusp"] for cusp in cusps] == [1, 2, 3, 4]
    for strand in STRANDS:
        for vertex in strand.vertices:
            point = strand.points[vertex["index"]]
            assert distance(point, (float(vertex["l2"]), float(vertex["l3"]))) < 1e-8  # of ten digits


def test_samples_are_on_the_curve_and_more_are_found_between() -> None:
    for strand in STRANDS:
        [line] = drawn(strand, FLOATS, lambda pose: (100 * FLOATS.lengths(pose)[0], FLOATS.lengths(pose)[1]))
        assert len(line) > 1.5 * len(strand.points)


def test_only_what_is_near_a_window_is_drawn() -> None:
    cusp = cusps_of(STRANDS)[0]
    centre = float(cusp["l2"]), float(cusp["l3"])
    box = Box.around([centre]).grown(0.01)

    def place(pose: Point) -> Point:
        return FLOATS.lengths(pose)

    lines = [line for strand in STRANDS for line in drawn(strand, FLOATS, place, box)]
    assert any(distance(point, centre) < 1e-9 for line in lines for point in line)
    assert sum(map(len, lines)) < sum(len(strand.points) for strand in STRANDS) / 2
