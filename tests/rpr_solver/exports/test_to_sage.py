"""Scripts for SageMath, which is not run here: they are Python."""

from rpr_solver import EXAMPLES, export
from tests.support.scripts import table


def test_the_script_is_python() -> None:
    compile(export(table(EXAMPLES["innocenti"], "14.98"), "sage"), "sage", "exec")
