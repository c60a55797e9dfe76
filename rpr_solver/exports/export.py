"""The script of a document for another system."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from rpr_solver.errors import InputError, shown
from rpr_solver.exports import to_maple, to_msolve, to_pari, to_sage, to_sympy
from rpr_solver.exports.problem import Problem, problem_of

_SCRIPTS: Mapping[str, Callable[[Problem], str]] = {
    "maple": to_maple.script,
    "msolve": to_msolve.script,
    "pari": to_pari.script,
    "sage": to_sage.script,
    "sympy": to_sympy.script,
}
SYSTEMS = tuple(_SCRIPTS)


def export(document: Mapping[str, Any], system: str) -> str:
    """A cusp table or a census as a script that computes the same anew in another system.

    The script derives J and E from the geometry, eliminates, and finds the cusps of each slice by the means
    of that system. It compares them with those of the document; its last line is ``agrees`` or ``differs``.
    msolve gets a system of equations instead, whose real solutions are the cusps.

    Args:
        document: a cusp table or a census, as JSON; for msolve a table of one slice.
        system: ``"maple"``, ``"msolve"``, ``"pari"``, ``"sage"`` or ``"sympy"``.

    Raises:
        InputError: naming ``document`` or ``system``.

    >>> from rpr_solver import EXAMPLES, table_document
    >>> print(export(table_document(EXAMPLES["zein-flat"], 10, digits=15), "pari").splitlines()[3])
    \\\\ Expected at L1 = 10: alpha_deg, theta1_deg, l2, l3
    """
    if system not in _SCRIPTS:
        raise InputError.of("system", f"is {shown(system)}; it must be one of {', '.join(SYSTEMS)}")
    return _SCRIPTS[system](problem_of(document))
