"""A path as a document, as rows, backwards and with other samples.

From a route and its proof to a path.
"""

from __future__ import annotations

import json
from fractions import Fraction
from functools import cache

import pytest

from rpr_solver import EXAMPLES, InputError, Path, cusp_loop


@cache
def the_loop() -> Path:
    return cusp_loop(EXAMPLES["innocenti"], 27, "B", samples=5)


def test_the_document() -> None:
    document = the_loop().to_json()
    assert json.loads(json.dumps(document)) == document
    assert (document["cusp"], document["closed"], document["winding"], document["sign"]) == (2, True, 1, 1)
    assert [document[name] for name in ("l1", "l2", "l3")] == ["27", "15.5", "16.9"]
    assert [sample["time"] for sample in document["samples"]] == ["0", "0.25", "0.5", "0.75", "1"]
    assert document["from"]["alpha_deg"] == document["samples"][0]["alpha_deg"]
    assert document["certificate"]["arcs"][0][0] == "from"


def test_backwards() -> None:
    back = the_loop().reversed()
    assert (back.start, back.stop, back.winding, back.sign) == (
        the_loop().stop,
        the_loop().start,
        -1,
        the_loop().sign,
    )
    assert back.samples[0].to_json(1) == the_loop().samples[-1].to_json(1) | {"time": "0", "place": "0"}
    assert back.reversed() == the_loop()


@pytest.mark.parametrize("samples", [2, 10])
def test_other_samples_of_the_same_path(samples: int) -> None:
    again = the_loop().resampled(samples, duration=Fraction(1, 3))
    assert len(again.samples) == samples
    assert again.samples[-1].time == Fraction(1, 3)
    assert again.route is the_loop().route


@pytest.mark.parametrize("samples", [1, 10_002, True])
def test_a_bad_number_of_samples_is_named(samples: int) -> None:
    with pytest.raises(InputError, match="samples"):
        the_loop().resampled(samples)
