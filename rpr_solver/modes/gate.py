"""Checks of requirements that are also about changes of assembly mode.

The numbers of cusps are those of :mod:`rpr_solver.transitions.check_report`. The fixed leg may move in the
whole range of which a change is required or excluded; it begins at a length > 0, and may have no upper end.
"""

from __future__ import annotations

from dataclasses import replace

from rpr_solver.contract import CHECK_DIGITS, Progress
from rpr_solver.model.manipulator import Manipulator
from rpr_solver.modes.modes import assembly_modes
from rpr_solver.transitions import Requirement
from rpr_solver.transitions.check_report import CheckReport, check_counts


def check(
    manipulator: Manipulator,
    requirement: Requirement,
    *,
    digits: int = CHECK_DIGITS,
    progress: Progress | None = None,
) -> CheckReport:
    """Proves or refutes a requirement on the cusps of a range of lengths, and on changes of assembly mode.

    The range is cut at every transition, and at every length at which a cusp reaches a joint limit; one exact
    slice between two neighbouring cuts gives the number of cusps of all slices there. Whether the assembly
    mode can change while the fixed leg keeps the range is decided as by :func:`assembly_modes`; a requirement
    about it fails if that is undecided.

    Args:
        manipulator: the geometry.
        requirement: the fixed leg, the range, the numbers of cusps, the joint limits, and whether a change of
            assembly mode is required or excluded.
        digits: significant digits of every printed number, 15 to 10000; all are proved.
        progress: callback ``progress(done, total)``; ``total`` may grow.

    Raises:
        InputError: naming ``manipulator``, ``requirement`` or ``digits``.
        SolverError: a cut could not be decided, or cusps keep the length of a joint limit over a range.

    >>> from rpr_solver import EXAMPLES
    >>> report = check(EXAMPLES["zein-flat"], Requirement(start=30, stop=40, max_cusps=6), digits=15)
    >>> report.passed, [(v.start, v.stop, v.count) for v in report.violations]
    (False, [('31.8632047694475', '31.8635738939382', 8), ('34.0716802345821', '35.2127837717642', 8)])
    >>> safe = Requirement(start="0.1", stop="0.3", mode_change="excluded")
    >>> check(EXAMPLES["zein-flat"], safe, digits=15).passed
    True
    """
    report = check_counts(manipulator, requirement, digits=digits, progress=progress)
    if requirement.mode_change is None:
        return report
    found = assembly_modes(
        manipulator,
        between=(requirement.start, requirement.stop),
        limits=requirement.limits,
        fixed_leg=requirement.fixed_leg,
        with_regions=False,
    ).to_json()
    part = {name: found[name] for name in ("change", "witness", "reason", "certificate")}
    return replace(report, mode_change=part)
