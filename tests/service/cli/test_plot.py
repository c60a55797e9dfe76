"""`rpr-cusps plot`: files of each form, the same pictures as the library's, clear refusals."""

from __future__ import annotations

from pathlib import Path

import pytest

from rpr_solver import EXAMPLES, poses, singular_curves
from service.cli.main import main

INNOCENTI = EXAMPLES["innocenti"]


def test_a_slice_as_a_file_and_as_text(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    target = tmp_path / "slice.svg"
    assert main(["plot", "innocenti", "--l1", "14.98", "-o", str(target)]) == 0
    expected = singular_curves(INNOCENTI, "14.98").figure().svg()
    assert target.read_text(encoding="utf-8") == expected
    assert main(["plot", "innocenti", "--l1", "14.98"]) == 0
    assert capsys.readouterr().out == expected


def test_poses_as_png_and_pdf(tmp_path: Path) -> None:
    pytest.importorskip("matplotlib")
    legs = ["--l1", "14.98", "--l2", "16", "--l3", "20"]
    for suffix, start in ((".png", b"\x89PNG"), (".pdf", b"%PDF")):
        target = tmp_path / f"pose{suffix}"
        assert (
            main(["plot", "innocenti", "--kind", "mechanism", *legs, "--pose", "2", "-o", str(target)]) == 0
        )
        assert target.read_bytes().startswith(start)
    figure = poses(INNOCENTI, "14.98", 16, 20, digits=15).figure(2)
    assert (tmp_path / "pose.png").read_bytes() == figure.png()


def test_the_leg_of_the_length_is_fixed(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["plot", "zein-flat", "--kind", "torus", "--l2", "20", "--theme", "light"]) == 0
    text = capsys.readouterr().out
    assert ">θ2</text>" in text
    assert "<style>" not in text


@pytest.mark.long
@pytest.mark.parametrize("kind", ["census", "locus"])
def test_pictures_of_all_lengths(kind: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["plot", "zein-flat", "--kind", kind, "--l1-range", "20:40"]) == 0
    assert capsys.readouterr().out.startswith("<svg ")


@pytest.mark.parametrize(
    ("args", "said"),
    [
        (("--l1", "27", "-o", "a.jpg"), "--output: 'a.jpg' does not end in .svg, .png or .pdf"),
        (("--l1", "27", "-o", "/none/a.svg"), "--output: '/none/a.svg' cannot be written: No such file"),
        (("--l1", "27", "-o", "a.png", "--url", "http://127.0.0.1:9"), "--output: a service draws SVG"),
        ((), "--l1: is missing; give a number"),
        (("--l1", "27", "--cusp", "A"), "--cusp: says nothing about the plot 'slice'; leave it out"),
        (("--kind", "census", "--l1", "27"), "--l1: says nothing about the plot 'census'; leave it out"),
        (("--kind", "loop", "--l1", "27", "--cusp", "Z"), "--cusp: is 'Z'; give its number"),
        (("--kind", "mechanism", "--l1", "27", "--cusp", "K"), "--cusp: is 11 (K); give 1 to 8"),
        (
            ("--kind", "mechanism", "--l1", "1", "--l2", "1", "--l3", "1"),
            "--pose: is 1; these legs have no pose",
        ),
    ],
)
def test_refusals(args: tuple[str, ...], said: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["plot", "innocenti", *args]) == 2
    error = capsys.readouterr().err
    assert f"rpr-cusps plot: {said}" in error
    assert error.count("\n") == 1
