"""Files of other programs: each is recognised, and the message says what to save instead."""

from __future__ import annotations

import io
import zipfile

import numpy as np
import pytest

from service.api.batches.rows import Rows
from service.api.problems import ProblemError
from service.schemas.document import JsonError, parse_json
from service.schemas.foreign import foreign

MATLAB = "writelines(jsonencode(struct("
YAML = "it looks like YAML"
SCRIPT = "it looks like a MATLAB script"
POINTS = '{"base": {"points": ['


def zipped(*names: str) -> bytes:
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w") as file:
        for name in names:
            file.writestr(name, "<x/>" * 100)
    return out.getvalue()


def as_numpy() -> bytes:
    out = io.BytesIO()
    np.save(out, np.zeros(3))
    return out.getvalue()


FILES = {
    "robot.xlsx": (zipped("[Content_Types].xml", "xl/workbook.xml"), "it is a workbook", "CSV UTF-8"),
    "robot.zip": (zipped("robot.json"), "it is a ZIP archive", POINTS),
    "robot.mat": (
        b"MATLAB 5.0 MAT-file, Platform: GLNXA64" + b"\x00\x01IM\xff",
        "it is a MATLAB data",
        MATLAB,
    ),
    "robot.npy": (as_numpy(), "it is a NumPy file", POINTS),
    "base.m": (b"% base\nA = [0 0; 40 10; 90 -20];\nd = [30, 30, 30]\n", SCRIPT, MATLAB),
    "robot.yaml": (b"# gripper\na2x: 15.91\na3x: 0\nbase:\n  - [0, 0]\n  - [40, 10]\n", YAML, "yq -o=json"),
    "robot.urdf": (b'<?xml version="1.0"?>\n<robot name="r"><link name="a"/></robot>', "it is URDF", POINTS),
    "robot.toml": (b"[robot]\na2x = 15.91\na3x = 0\n", "it looks like a program or settings", POINTS),
}


@pytest.mark.parametrize("name", FILES)
def test_what_it_is_and_what_to_save_instead(name: str) -> None:
    content, what, instead = FILES[name]
    with pytest.raises(JsonError) as caught:
        parse_json(content, "The file")
    assert caught.value.detail.startswith("The file is not JSON: ")
    assert what in caught.value.detail
    assert instead in caught.value.detail


@pytest.mark.parametrize("head", ["id,a2x,a3x,a3y,d1,d2,d3", "A2x;A3x;A3y", "sep=;\nx;y;z", "x\ty\tz\t"])
def test_a_table_is_for_a_batch(head: str) -> None:
    said = foreign(f"{head}\n1,2,3\n".encode())
    assert said is not None
    assert "rpr-cusps submit" in said
    assert foreign(head.encode(), is_table=True) is None


@pytest.mark.parametrize("name", FILES)
def test_in_the_place_of_a_table(name: str) -> None:
    content, what, instead = FILES[name]
    with pytest.raises(ProblemError) as caught:
        [*Rows(io.BytesIO(content + b"\n"), 1 << 20, lambda _: None)]
    assert what in caught.value.detail
    assert instead in caught.value.detail


@pytest.mark.parametrize(
    "text",
    [
        *(b"", b" ", b"{", b'{"a2x": 15.91,', b"{a2x: 15.91}", b"[1, 2", b"15.91", b'"a2x": 15.91,', b"NaN"),
        *(b"hello", b"\xff\xfe", b"a2x=15.91&a3x=0", b"{\n// a comment\n}", b"innocenti"),
    ],
)
def test_faulty_json_is_called_that(text: bytes) -> None:
    assert foreign(text) is None
