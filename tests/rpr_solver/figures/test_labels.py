"""Labels and boxes go where they hide nothing."""

from rpr_solver.figures.labels import OccupancyGrid
from rpr_solver.figures.sheet import box_of
from rpr_solver.notebook.scene import Box
from tests.support.pictures import meet


def test_labels_near_one_point_do_not_cover_each_other_or_lines() -> None:
    room = OccupancyGrid(Box(0, 0, 200, 200))
    line = [(0.0, 100.0), (200.0, 100.0)]
    room.add_line(line)
    boxes = [box_of(room.near((100, 100), name, 14, 12)) for name in "ABC"]
    for k, box in enumerate(boxes):
        assert not (box.y0 < 100 < box.y1)
        assert not any(meet(box, other) for other in boxes[:k])


def test_a_label_in_a_corner_stays_inside() -> None:
    room = OccupancyGrid(Box(0, 0, 200, 200))
    box = box_of(room.near((1, 1), "L1 = 20", 14, 10))
    assert box.x0 >= 0
    assert box.y0 >= 0


def test_a_label_without_any_room_is_at_its_point() -> None:
    assert OccupancyGrid(Box(0, 0, 5, 5)).near((2, 2), "L1 = 20", 14, 10).at == (2, 2)


def test_a_free_box_is_the_nearest_one() -> None:
    room = OccupancyGrid(Box(0, 0, 300, 300))
    room.add_box(Box(0, 0, 300, 100))
    box = room.free_box(80, 60, (150, 0))
    assert box is not None
    assert room.hidden(box) == 0
    assert 100 < box.y0 < 124
    assert abs(box.centre[0] - 150) < 12
    assert room.hidden(Box(0, 0, 20, 20)) > 0
    room.add_line([(0, 0), (300, 300)])
    assert room.free_box(290, 190, (150, 0)) is None


def test_the_middle_of_a_ring_with_a_hole_is_beside_the_hole() -> None:
    room = OccupancyGrid(Box(0, 0, 400, 300))
    ring, hole = Box(100, 50, 300, 250).corners, Box(110, 60, 220, 240).corners
    for line in (ring, hole):
        room.add_line([*line, line[0]])
    place = room.inside([ring, hole], 30)
    assert place is not None
    assert 250 < place[0] < 270
    assert room.inside([Box(100, 50, 120, 60).corners], 30) is None
