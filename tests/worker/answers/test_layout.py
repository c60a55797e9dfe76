"""Slices as they are stored."""

from __future__ import annotations

from worker.answers.layout import HEAD_BYTES, measured, measured_by, pack, unpack

SLICE = b'{"l1":"14.98","count":1,"cusps":[{"alpha_deg":"12.5"}]}'
ERROR = b'{"l1":"2","error":{"type":"solver-error","detail":"undecided"}}'


def test_a_slice_is_stored_and_read_byte_for_byte() -> None:
    for text in (SLICE, ERROR, SLICE * 100, b""):
        assert unpack(pack(text)) == text


def test_the_head_says_what_the_whole_would() -> None:
    for text in (SLICE, ERROR):
        assert measured_by(pack(text)[:HEAD_BYTES]) == measured(text)
    assert [measured(text).is_error for text in (SLICE, ERROR)] == [False, True]
    assert measured(SLICE).size == len(SLICE)
    assert measured(SLICE).digest != measured(SLICE.replace(b"12.5", b"12.6")).digest


def test_text_takes_half_the_bytes() -> None:
    assert 2 * len(pack(SLICE * 40)) < len(SLICE * 40)
