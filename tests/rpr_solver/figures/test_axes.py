"""A frame places values, and its ticks lie in it."""

from rpr_solver.figures.axes import Frame
from rpr_solver.notebook.scene import Box, Text


def test_ticks_are_where_their_values_are() -> None:
    frame = Frame.of(Box(60, 20, 660, 420), Box(0, 0, 50, 30))
    texts = [shape for shape in frame.shapes("L2", "L3") if isinstance(shape, Text)]
    by_words = {text.words: text.at for text in texts if text.at[1] > 420}
    assert {"0", "10", "20", "30", "40", "50", "L2"} <= by_words.keys()
    assert by_words["20"][0] == frame.place((20, 0))[0] == 300
    assert [text.turn for text in texts if text.words == "L3"] == [-90]


def test_square_frames_have_one_scale() -> None:
    frame = Frame.square(Box(0, 0, 400, 200), Box(0, 0, 10, 10))
    assert frame.x.pixel == frame.y.pixel
    assert frame.values == Box(-5, 0, 15, 10)
    assert frame.line([(5, 5)]) == [(200, 100)]
