"""Tables in LaTeX have the digits of the document, rounded once; references name what was asked."""

from __future__ import annotations

import re
import shutil
import subprocess
from decimal import Decimal
from functools import cache
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rpr_solver import EXAMPLES, InputError, Manipulator, census, poses, singular_curves, table_document
from rpr_solver.exports.latex import bibtex, latex_table
from rpr_solver.notebook.style import Style


@cache
def the_table() -> dict[str, Any]:
    return table_document(EXAMPLES["zein-flat"], [10, "1/100"], digits=15)


def with_number(text: str) -> dict[str, Any]:
    cusp = {**the_table()["slices"][0]["cusps"][0], "l2": text}
    return {**the_table(), "digits": 60, "slices": [{**the_table()["slices"][0], "cusps": [cusp]}]}


def printed(document: dict[str, Any], digits: int | None) -> str:
    """The L2 of the first cusp in the table."""
    [row] = [line for line in latex_table(document, digits).splitlines() if " & A & " in line]
    return row.split(" & ")[4].strip("$")


@given(st.decimals("1e-8", "1e8", places=None, allow_nan=False), st.integers(1, 20))
def test_a_number_is_the_nearest_with_its_digits(value: Decimal, digits: int) -> None:
    text = f"{value:.29e}"
    try:
        shown = printed(with_number(text), digits)
    except InputError:
        return  # it ends in zeros after a 5
    mantissa, _, power = shown.partition(r" \times 10^")
    rounded = Decimal(mantissa).scaleb(int(power.strip("{}") or 0))
    unit = Decimal(1).scaleb(Decimal(text).adjusted() - digits + 1)
    assert abs(rounded - Decimal(text)) <= unit / 2
    assert len(Decimal(mantissa).as_tuple().digits) == digits


def test_a_number_that_may_lie_on_both_sides_of_a_tie_is_not_rounded() -> None:
    for text in ("1.2345500", "1.23454999999999999999999999999999999999"):
        if text.endswith("00"):
            with pytest.raises(
                InputError, match=r"^digits: is 5; 1\.2345500 is too near to a tie; ask for more"
            ):
                printed(with_number(text), 5)
        else:
            assert printed(with_number(text), 5) == "1.2345"
    assert printed(with_number("1.2345500"), None) == "1.2345500"


def test_rows_of_slices_with_cusps_without_and_without_an_answer() -> None:
    error = {"l1": "3", "error": {"type": "solver-error", "detail": "…"}}
    text = latex_table({**the_table(), "slices": [*the_table()["slices"], error]}, 6)
    rows = text.split("\\midrule\n")[1].split("    \\bottomrule")[0].splitlines()
    assert [row.split("&")[0].strip() for row in rows] == ["10", "", "", "", "0.01", "3"]
    assert "no cusp" in rows[4]
    assert "no answer" in rows[5]
    assert all(row.endswith(r" \\") for row in rows)


@pytest.mark.parametrize(
    ("document", "said"),
    [
        (the_table(), "cusps of slices, $L_1 = 10, 0.01$}"),
        (
            poses(EXAMPLES["innocenti"], "14.98", 16, 20, digits=15).to_json(),
            "solutions of the direct kinematics, $L_1 = 14.98$, $L_2 = 16$, $L_3 = 20$}",
        ),
        (
            census(EXAMPLES["zein-flat"], start=1, digits=15).to_json(),
            r"census of cusps, $L_1$ from 1 to $\infty$}",
        ),
        (
            table_document(Manipulator(30, 11, 27, 13, 9, 4, "cw"), range(1, 9), digits=15),
            r"$L_1 = 1, \dots, 8$}",
        ),
    ],
)
def test_references(document: dict[str, Any], said: str) -> None:
    entry = bibtex(document, "0.1.0", 2026)
    assert re.match(r"@software\{rpr-cusps-[0-9a-f]{8},\n", entry)
    assert entry.count("{") == entry.count("}")
    assert said in entry
    assert document["geometry_hash"] in entry
    assert "version = {0.1.0, solver version " in entry


needs_latex = pytest.mark.skipif(
    shutil.which("pdflatex") is None or shutil.which("bibtex") is None,
    reason="needs LaTeX: apt-get install texlive-latex-base texlive-latex-recommended",
)


def typeset(folder: Path, body: str, *programs: str) -> str:
    """Typeset a document of one column, and return the log of LaTeX's last run."""
    head = "\\documentclass{article}\n\\usepackage{booktabs,graphicx}\n\\begin{document}\n"
    (folder / "paper.tex").write_text(f"{head}{body}\\end{{document}}\n", encoding="ascii")
    for program in programs:
        options = ["-halt-on-error", "-interaction=nonstopmode"] if program == "pdflatex" else []
        run = subprocess.run([program, *options, "paper"], cwd=folder, capture_output=True, text=True)
        assert run.returncode == 0, run.stdout[-2000:]
    assert (folder / "paper.pdf").read_bytes().startswith(b"%PDF")
    return (folder / "paper.log").read_text(encoding="latin-1")


@needs_latex
def test_latex_takes_a_table_that_fits_into_its_column(tmp_path: Path) -> None:
    error = {"l1": "3", "error": {"type": "solver-error", "detail": "…"}}
    tiny = {**the_table()["slices"][0]["cusps"][0], "l2": "1.23456789012345e-12"}
    slices = [*the_table()["slices"], error, {"l1": "4", "cusps": [tiny]}]
    log = typeset(tmp_path, latex_table({**the_table(), "slices": slices}, 6), "pdflatex")
    assert "Overfull" not in log
    assert "Output written on paper.pdf (1 page" in log


@needs_latex
@pytest.mark.long
def test_a_paper_with_a_figure_a_table_and_references(tmp_path: Path) -> None:
    """As an author does it: the figure as wide as it says, the table referred to, every answer cited."""
    pytest.importorskip("matplotlib")
    first = EXAMPLES["innocenti"]
    answers = [
        table_document(first, "14.98", digits=15),
        census(EXAMPLES["zein-flat"], start=1, stop=2, digits=15).to_json(),
        poses(EXAMPLES["fourteen-cusps"], 10, 12, 9, digits=15).to_json(),
    ]
    style = Style(width_mm=86, has_symbols=True, unit="mm", has_title=False)
    singular_curves(first, "14.98").figure().styled(style).save(tmp_path / "slice.pdf")
    entries = [bibtex(answer, "0.1.0", 2026) for answer in answers]
    (tmp_path / "refs.bib").write_text("\n".join(entries), encoding="ascii")
    keys = [entry.partition("{")[2].partition(",")[0] for entry in entries]
    body = (
        f"\\begin{{figure}}\\includegraphics{{slice}}\\caption{{A slice.}}\\end{{figure}}\n"
        f"{latex_table(answers[0], 8)}"
        f"See Table~\\ref{{tab:cusps-{keys[0].removeprefix('rpr-cusps-')}}} and \\cite{{{','.join(keys)}}}.\n"
        "\\bibliographystyle{plain}\\bibliography{refs}\n"
    )
    log = typeset(tmp_path, body, "pdflatex", "bibtex", "pdflatex", "pdflatex")
    for fault in ("Overfull", "undefined", "multiply defined", "Warning"):
        assert fault not in log, re.findall(rf"^.*{fault}.*$", log, re.MULTILINE)
    set_ = (tmp_path / "paper.bbl").read_text(encoding="ascii")
    assert set_.count("\\bibitem") == len(keys)
    for answer in answers:
        assert answer["geometry_hash"].removeprefix("sha256:")[:16] in set_
    assert set_.count("$A_2 = ") == len(keys)
