"""Programs of manipulators with roots: run where their systems are installed, and equations that hold."""

import json
import shutil
from pathlib import Path
from typing import Any

import mpmath as mp
import pytest

from rpr_solver import InputError, Manipulator, census, export, table_document
from tests.rpr_solver.exports.test_msolve import System
from tests.support.sampling import long, sample
from tests.support.scripts import said

ROWS = json.loads((Path(__file__).parents[2] / "data" / "irrational.json").read_text())["rows"]
ROOTS = Manipulator(
    base={"points": [[0, 0], [3, "4*sqrt(7)"], [10, 0]]},
    platform={"points": [[1, 0], [5, 0], [3, "-4*sqrt(7)"]]},
)
"""Both triangles are over ℚ, so that SymPy is quick."""
TURNED = Manipulator(base={"points": [[1, 2], [11, 3], [4, 9]]}, platform={"sides": [7, 8, 6]})
"""The article's axes are not those of the plane."""
needs_pari = pytest.mark.skipif(shutil.which("gp") is None, reason="needs PARI/GP: apt-get install pari-gp")


@pytest.mark.parametrize("row", sample(ROWS[::4], 0, 3))
@needs_pari
def test_pari_finds_the_same_cusps(row: dict[str, Any], tmp_path: Path) -> None:
    document = table_document(Manipulator.from_json(row["geometry"]), row["l1"], digits=20)
    count = row["count"]
    status, lines = said(document, "pari", tmp_path)
    assert (status, lines) == (0, [f"L1 = {row['l1']}: {count} cusps, {count} expected: agrees", "agrees"])


@pytest.mark.parametrize("m", [ROOTS, TURNED], ids=["roots", "turned"])
@needs_pari
def test_pari_agrees_with_transitions(m: Manipulator, tmp_path: Path) -> None:
    document = census(m, digits=20, start=9, stop=14).to_json()
    assert document["transitions"]
    status, lines = said(document, "pari", tmp_path)
    assert (status, lines[-1]) == (0, "agrees")


@pytest.mark.parametrize("leg", [1, long(2)])
def test_sympy_finds_the_same_cusps(leg: int, tmp_path: Path) -> None:
    status, lines = said(table_document(ROOTS, 8, fixed_leg=leg, digits=20), "sympy", tmp_path)
    assert (status, lines[-1]) == (0, "agrees")


@pytest.mark.parametrize("m", [ROOTS, TURNED], ids=["roots", "turned"])
def test_the_equations_of_msolve_hold_at_the_cusps_and_not_beside_them(m: Manipulator) -> None:
    document = table_document(m, 8, digits=60)
    system, frame = System(export(document, "msolve")), m.frame
    with mp.workdps(60):
        root = mp.sqrt(frame.rho)
        base, platform = (mp.mpc(_number(axis.x), _number(axis.y) * root) for axis in frame.axes)
        for cusp in document["slices"][0]["cusps"]:
            values = []
            for step in (0, mp.mpf("1e-3")):
                alpha, theta = (mp.radians(mp.mpf(cusp[x])) for x in ("alpha_deg", "theta1_deg"))
                z = mp.expj(alpha + step) * base / abs(base) * mp.conj(platform) / abs(platform)
                e = mp.expj(theta) * base / abs(base)
                pose = [z.real, z.imag / root, e.real, e.imag / root]
                pose += [mp.sqrt(frame.radicand)] if "h" in system.names else []
                values.append(list(map(abs, system.values(pose, *system.gradient(pose)))))
            assert max(values[0]) < mp.mpf("1e-20")
            assert min(values[1][:3]) > mp.mpf("1e-9")


def _number(z: Any) -> Any:
    return mp.mpf(z.a.numerator) / z.a.denominator + mp.mpf(z.b.numerator) / z.b.denominator * mp.sqrt(
        z.radicand
    )


def test_maple_is_refused_by_name() -> None:
    with pytest.raises(InputError, match=r"geometry\.a2x: is sqrt\(101\), but a program in Maple needs six"):
        export(table_document(TURNED, 8, digits=20), "maple")
