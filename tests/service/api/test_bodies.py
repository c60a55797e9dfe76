"""Bodies: questions that were read are known by them, and those of batches come in pieces of any size."""

from __future__ import annotations

import io
import json
import re
from collections.abc import Mapping
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rpr_solver.errors import InputError
from rpr_solver.notebook.tables import csv_text
from service.api.batches import bodies
from service.api.batches.bodies import Elements, lines
from service.api.batches.rows import COLUMNS, Rows, item_of, read_item
from service.api.problems import ProblemError
from service.schemas.limits import Limits
from service.schemas.questions import EXAMPLE_GEOMETRY
from service.schemas.registry import all_questions
from service.schemas.resources import KIND_NAMES
from tests.support.processes import ROOT


def body(**asked: Any) -> bytes:
    return json.dumps({"geometry": EXAMPLE_GEOMETRY, **asked}).encode()


TEXTS = st.text(st.sampled_from('a"\\[]{},:\n é'), max_size=12)
VALUES = st.recursive(TEXTS | st.booleans(), lambda inner: st.lists(inner, max_size=3), max_leaves=5)
ITEMS = st.lists(st.dictionaries(TEXTS, VALUES, max_size=3), min_size=1, max_size=4)
URL = "http://[::1]/a,b"


def unlimited(_size: int) -> None:
    """Takes items of any size."""


def elements(body: bytes) -> Elements:
    return Elements(io.BytesIO(body), 1 << 20, unlimited)


def rows(body: bytes) -> list[Mapping[str, str]]:
    return list(Rows(io.BytesIO(body), 1 << 20, unlimited))


@given(
    ITEMS,
    st.integers(1, 9),
    st.sampled_from(["array", "object", "callback before", "callback after"]),
    st.booleans(),
)
def test_elements_do_not_depend_on_the_blocks(
    items: list[Any], block: int, form: str, is_ascii: bool
) -> None:
    members: dict[str, Any] = {"items": items}
    if form == "callback before":
        members = {"callback_url": URL, **members}
    elif form == "callback after":
        members["callback_url"] = URL
    body = json.dumps(items if form == "array" else members, ensure_ascii=is_ascii).encode()
    found = elements(body)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(bodies, "_BLOCK", block)
        assert [json.loads(text) for text in found] == items
    assert found.callback_url == (URL if form.startswith("callback") else None)


def test_lines_have_their_numbers_and_rows_their_cells() -> None:
    body = b'{"a": 1}\n\n  \r\n{"b": 2}'
    assert list(lines(io.BytesIO(body), 100, unlimited)) == [(1, b'{"a": 1}'), (4, b'{"b": 2}')]
    sent = b"\xef\xbb\xbfid,a2x,a3x,a3y,d1,d2,d3\r\n" + "é0,1,2,3,4,5,6\r\né1,1,2,3,4,5,6".encode()
    assert [row["id"] for row in rows(sent)] == ["é0", "é1"]


GEOMETRY = {"a2x": "15.91", "a3x": "0", "a3y": "10", "d1": "17.04", "d2": "16.54", "d3": "20.84"}


HEAD = "id;a2x;a3x;a3y;d1;d2;d3;l1"


def rows_of(*texts: str) -> list[Mapping[str, str]]:
    return rows("\n".join(texts).encode())


def test_the_decimal_mark_is_the_point() -> None:
    [row] = rows_of(HEAD, "A;1250,5;0;900.25;300;300;300;14.98")
    item = read_item(row, 0, Limits())
    assert item.problem is not None
    assert "items[0].request.geometry.a2x: '1250,5'" in item.problem["detail"]


@pytest.mark.parametrize("mark", ["", "\ufeff"])
@pytest.mark.parametrize("first", ["sep=;", '"sep=;"'])
def test_a_spreadsheet_names_the_separator(mark: str, first: str) -> None:
    [row] = rows_of(mark + first, HEAD, "A;1250.5;600;900.25;300;300;300;30")
    assert (row["id"], row["a2x"]) == ("A", "1250.5")


@pytest.mark.parametrize("separator", [",", "\t"])
def test_the_named_separator_counts_not_the_most_frequent(separator: str) -> None:
    head = separator.join(["id", "a2x", "a3x", "a3y", "d1", "d2", "d3", "l1"])
    row = separator.join(["A", "1", "2", "3", "4", "5", "6", "7;8;9;10;11;12;13;14;15"])
    [read] = rows_of(f"sep={separator}", head, row)
    assert read["l1"].count(";") == 8
    with pytest.raises(ProblemError, match="line 1 names the separator"):
        rows_of("sep=|", head, row)


def test_an_id_is_read_as_it_was_before_a_spreadsheet() -> None:
    text = csv_text(["id", *GEOMETRY], ({"id": name, **GEOMETRY} for name in ("=1+1", "'a", "-5", "b")))
    assert [row["id"] for row in rows_of(text)] == ["=1+1", "'a", "-5", "b"]


@pytest.mark.parametrize("kind", ["cusp-table", "article-table"])
def test_a_row_of_a_table_has_lists_and_steps(kind: str) -> None:
    row = {**GEOMETRY, "kind": kind, "digits": "20"}
    several, steps = ({"l1": "27;28.1"}, {"l1_from": "1", "l1_to": "2", "l1_step": "0.5"})
    assert item_of({**row, **several})["request"]["l1"] == ["27", "28.1"]
    assert item_of({**row, **steps})["request"]["l1"] == {"from": "1", "to": "2", "step": "0.5"}
    ends = {"l1_from": "1", "l1_to": "2"}
    assert item_of({**row, **ends, "kind": "census"})["request"]["range"] == {"from": "1", "to": "2"}
    legs = {"kind": "poses", "l1": "17", "l3": "15", "l2_from": "0", "l2_to": "40"}
    along = item_of({**row, **legs})["request"]
    assert (along["l1"], along["l2"]) == ("17", {"from": "0", "to": "40"})
    check = item_of({**row, **ends, "kind": "check", "max_cusps": "4", "fixed_leg": "1"})["request"]
    assert check["requirement"] == {"range": {"from": "1", "to": "2"}, "max_cusps": "4", "fixed_leg": "1"}


@pytest.mark.parametrize(
    ("cells", "said"),
    [
        ({"kind": "census", "l2_from": "1"}, "l2_from: with fixed_leg 1 the range is that of l1"),
        ({"l1": "2", "l1_from": "1", "l1_to": "3"}, "l1_from: is given beside l1; leave one of them out"),
    ],
)
def test_a_range_that_would_not_count_is_refused_in_its_place(cells: dict[str, str], said: str) -> None:
    row = {**GEOMETRY, "id": "a", "kind": "cusp-table", **cells}
    item = read_item(row, 3, Limits())
    assert (item.id, item.request) == ("a", None)
    assert item.problem is not None
    assert item.problem["detail"].startswith(f"items[3].{said}")


def test_the_page_names_every_kind_and_every_column() -> None:
    page = (ROOT / "docs/batches.md").read_text(encoding="utf-8")
    assert {*KIND_NAMES, *COLUMNS} <= set(re.findall(r"`(\w[\w-]*)`", page))
    rows = [line for line in page.splitlines() if line.startswith("| `")]
    for question in all_questions():
        [row] = [row for row in rows if f"`POST {question.path}`" in row]
        assert all(f"`{kind.name}`" in row for kind in question.kinds)


@pytest.mark.parametrize(
    "table",
    [
        "ID,A2X,a3x,a3y,d1,d2,d3,L1,digits\na,15.91,0,10,17.04,16.54,20.84,27;28.1,20\n",
        'id;a2x;a3x;a3y;d1;d2;d3;L1;Digits\na;15.91;0;10;17.04;16.54;20.84;"27;28.1";20\n',
        "id\ta2x\ta3x\ta3y\td1\td2\td3\tl1\tdigits\na\t15.91\t0\t10\t17.04\t16.54\t20.84\t27;28.1\t20\n",
    ],
    ids=["capitals", "semicolons", "tabs"],
)
def test_tables_as_spreadsheets_write_them(table: str) -> None:
    [item] = map(item_of, rows(table.encode()))
    assert item == {
        "id": "a",
        "kind": "cusp-table",
        "request": {"geometry": GEOMETRY, "l1": ["27", "28.1"], "digits": "20"},
    }


def test_a_name_with_a_comma_stays_as_it_is() -> None:
    head, row = "id;a2x;a3x;a3y;d1;d2;d3;cusp", "a,b;1;2;3;4.5;5;6;B"
    [item] = map(item_of, rows(f"{head}\n{row}\n".encode()))
    assert (item["id"], item["request"]["cusp"], item["request"]["geometry"]["d1"]) == ("a,b", "B", "4.5")


@pytest.mark.parametrize(
    ("head", "row", "said"),
    [
        ("a2x,a3x,a3y,d1,d2,d3,l11", "", "l11: unknown column; did you mean l1?"),
        ("a2x,a3x,a3y,d1,d2,d3,l1,L1", "", "l1: this column is given twice"),
        (
            "a2x,a3x,a3y,d1,d2,d3,l1",
            "1,2,3,4,5,6,14,98",
            "write numbers with a decimal point",
        ),
    ],
)
def test_what_is_wrong_with_a_table_is_one_sentence(head: str, row: str, said: str) -> None:
    with pytest.raises((InputError, ProblemError)) as caught:
        rows(f"{head}\n{row}\n".encode())
    assert said in str(caught.value)
    assert str(caught.value).count("column") <= 2


@pytest.mark.parametrize(
    ("body", "said"),
    [
        (b" " * 40_000, "does not begin"),
        (b'{"a": [1], "items": []}', "does not begin"),
        (b'{"items": [1], "items": []}', "members beside"),
        (b'[{"a": 1},\n{"b" 2}]', "items[1] is not JSON: Expecting ':' delimiter in line 2"),
        (b'[{"a": "' + b"b" * 200_000, "items[0] is not JSON: Unterminated string"),
        (b"[" + b"[" * 200_000, "items[0] is nested too deeply"),
        (b"[1] 2", "continues after the items"),
    ],
    ids=["spaces", "another member", "items twice", "a fault", "no end", "brackets", "more"],
)
def test_a_body_that_is_no_list_of_items(body: bytes, said: str) -> None:
    with pytest.raises(ProblemError) as caught:
        list(elements(body))
    assert said in str(caught.value)


@pytest.mark.parametrize("body", [b'["' + b"a" * 300_000 + b'"]', b"[" + b"1," * 10 + b'"' + b"a" * 300_000])
def test_an_item_that_is_too_long_is_not_read_to_its_end(body: bytes) -> None:
    def refused(size: int) -> None:
        raise InputError.of("items", f"has {size} bytes")

    file = io.BytesIO(body + b" " * 1_000_000)
    with pytest.raises(InputError, match="has"):
        list(Elements(file, 100_000, refused))
    assert file.tell() < 600_000
