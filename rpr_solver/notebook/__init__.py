"""How answers are shown in notebooks and as text: tables, CSV, figures."""

from rpr_solver.notebook.style import Style
from rpr_solver.notebook.tables import (
    Row,
    counted,
    csv_text,
    degenerate_words,
    html_table,
    near_words,
    read_cell,
    shortened,
    text_table,
    with_floats,
)

__all__ = [
    "Row",
    "Style",
    "counted",
    "csv_text",
    "degenerate_words",
    "html_table",
    "near_words",
    "read_cell",
    "shortened",
    "text_table",
    "with_floats",
]
