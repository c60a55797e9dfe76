"""Numbers of documents become floats and short texts of the same value.

Every picture names what it shows and its geometry.
"""

from __future__ import annotations

from decimal import Decimal

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rpr_solver.errors import InputError
from rpr_solver.figures.sheet import box_of, caption_of, exact, listed, number, sheet, short, width
from rpr_solver.notebook.figure import Figure, drawing
from rpr_solver.notebook.scene import Scene, Text
from rpr_solver.notebook.tables import Style
from tests.support.pictures import GEOMETRY, check, words


@given(st.decimals(min_value=-(10**9), max_value=10**9, places=6))
def test_short_numbers_are_near(value: Decimal) -> None:
    text = short(str(value), 5).replace("−", "-")
    assert len(text) <= 16
    assert float(text) == pytest.approx(float(value), rel=1e-4)


def test_short_numbers_of_any_size() -> None:
    assert [short(x) for x in ("1e-400", "-12345678e400", "0", "0.00100", "99999.7", "2/3")] == [
        "1e−400", "−1.235e407", "0", "0.001", "100000", "0.6667",
    ]  # fmt: skip


def test_numbers() -> None:
    assert [number(x) for x in ("1/3", "sqrt(2)", "-4.5e1")] == [1 / 3, 2**0.5, -45.0]
    assert exact("426/25") == Decimal("17.04")
    with pytest.raises(InputError, match=r"1e400 is too large to be drawn"):
        number("1e400")


def test_the_box_of_a_text_is_where_its_anchor_says() -> None:
    wide = width("L2 = 16", 14)
    boxes = [box_of(Text((100, 50), "L2 = 16", 14, anchor=anchor)) for anchor in ("start", "middle", "end")]
    assert [box.x0 for box in boxes] == [100, 100 - wide / 2, 100 - wide]
    assert width("W", 10, bold=True) > width("W", 10) > width("i", 10)
    assert boxes[0].height == pytest.approx(15.4)


def test_title_caption_and_description() -> None:
    figure = empty(700)
    check(figure)
    assert words(figure) == ["Nothing", caption_of(GEOMETRY)]
    assert figure.scene.description == f"An empty picture. Geometry: {caption_of(GEOMETRY)}."


@drawing
def empty(style: Style, wide: float) -> Scene:
    return sheet(
        style, "Nothing", {"geometry": GEOMETRY}, "An empty picture.", (), (style.width or wide, 200)
    )


def test_a_narrow_picture_has_its_caption_in_more_lines() -> None:
    wide, narrow = empty(700).scene, empty(700).styled(Style(width=300)).scene
    check(Figure(narrow))
    lines = words(Figure(narrow))[1:]
    assert len(lines) > 1
    assert " ".join(lines) == caption_of(GEOMETRY)
    assert narrow.height > wide.height
    bare = empty(700).styled(Style(has_title=False, has_caption=False)).scene
    assert words(Figure(bare)) == []
    assert bare.height - bare.top < wide.height - 50
    assert bare.title == "Nothing"


def test_enumerations() -> None:
    assert [listed(x) for x in (["A"], ["A", "B"], ["A", "B", "C"])] == ["A", "A and B", "A, B and C"]
