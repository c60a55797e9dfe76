"""Certified cusp points of planar 3-RPR parallel manipulators.

>>> from rpr_solver import EXAMPLES, cusp_table
>>> [table] = cusp_table(EXAMPLES["innocenti"], "14.98", digits=15)
>>> table
<SliceTable L1=14.98: 6 cusps, 15 digits>
>>> table.cusps[0].theta1_deg, table.cusps[0].l2
('-69.1293760614883', '0.845282018280357')

Every input number is exact (:data:`Exact`): an integer, a ``Fraction``, a ``Decimal``, or a text such as
``"14.98"`` or ``"749/50"``. Lengths are in the user's unit, angles in degrees.
"""

from typing import Any

from lazy_loader import attach_stub

from rpr_solver.notebook.figure import Figure, draw_with

__getattr__, __dir__, __all__ = attach_stub(__name__, __file__)

__version__ = "0.1.0"
__all__ += ["__version__"]


@draw_with
def _figure_of(document: dict[str, Any], **options: Any) -> Figure:
    from rpr_solver.figures import figure_of  # a start need not load what draws

    return figure_of(document, **options)
