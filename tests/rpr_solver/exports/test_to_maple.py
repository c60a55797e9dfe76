"""Scripts for Maple, which is not run here: what is opened is closed."""

from rpr_solver import EXAMPLES, export
from tests.support.scripts import table


def test_brackets_procedures_and_loops_are_closed() -> None:
    script = export(table(EXAMPLES["innocenti"], "14.98"), "maple")
    assert script.count("proc(") == script.count("end proc") > 0
    assert script.count(" do") - script.count("end do") == script.count("end do") > 0
    assert script.count(" if ") - script.count("end if") >= 0
    assert all(script.count(a) == script.count(b) > 0 for a, b in ("()", "[]"))


def test_it_ends_with_the_exit_status() -> None:
    *_, said, status = export(table(EXAMPLES["innocenti"], "14.98", "27"), "maple").splitlines()
    assert said == 'printf("%s\\n", `if`(right_ones = 2, "agrees", "differs")):'
    assert status == "`quit`(`if`(right_ones = 2, 0, 1)):"
