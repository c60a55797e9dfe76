"""Scripts are filled, and begin with what they are to find."""

import pytest

from rpr_solver import EXAMPLES, export
from rpr_solver.exports.export import SYSTEMS
from tests.support.scripts import table


@pytest.mark.parametrize("system", sorted({*SYSTEMS} - {"msolve"}))
def test_every_script_has_the_expected_cusps_as_comments_and_no_place_left_open(system: str) -> None:
    document = table(EXAMPLES["innocenti"], "14.98")
    script = export(document, system)
    assert "@" not in script
    for cusp in document["slices"][0]["cusps"]:
        assert script.count(cusp["alpha_deg"]) == 2
