"""The commands that need no service."""

from __future__ import annotations

import csv
import json
import re
from fractions import Fraction
from pathlib import Path

import pytest

from rpr_solver import (
    EXAMPLES,
    aspects,
    census,
    census_csv,
    curves_csv,
    cusp_loop,
    joint_path,
    leg_poses,
    path_csv,
    pose_connections,
    pose_path,
    poses,
    restrict_census,
    sensed_poses,
    singular_curves,
    table_csv,
    with_condition,
    with_sensitivities,
    workspace,
    workspace_csv,
    workspace_sweep,
)
from rpr_solver.article.table import article_document
from rpr_solver.notebook.style import Style
from service.cli.main import main
from tests.support.cli_process import Run
from tests.support.shared import curves_of

LEGS = ("--l1", "14.98", "--l2", "15", "--l3", "30")


def test_poses_as_json_and_as_text(run_here: Run) -> None:
    done = run_here("poses", "innocenti", *LEGS, "--digits", "20", "--format", "json")
    assert (done.returncode, done.stderr) == (0, "")
    expected = poses(EXAMPLES["innocenti"], "14.98", 15, 30, digits=20).to_json()
    assert json.loads(done.stdout) == expected
    lines = run_here("poses", "innocenti", *LEGS, "--digits", "20").stdout.splitlines()
    assert lines[2] == "L1 = 14.98, L2 = 15, L3 = 30: 2 poses"
    assert lines[4].split()[:2] == [expected["poses"][0]["alpha_deg"], expected["poses"][0]["theta1_deg"]]  # type: ignore[index]


def test_aspects_of_a_range(run_here: Run) -> None:
    args = ("aspects", "innocenti", "--l1-range", "27:30")
    document = json.loads(run_here(*args, "--format", "json").stdout)
    assert document["range"] == {"from": "27", "to": "30"}
    assert document["aspects"] == [x.to_json() for x in aspects(EXAMPLES["innocenti"], 27, 30)]
    lines = run_here(*args).stdout.splitlines()
    assert lines[2:5] == [
        "L1 from 27 up to 30: 2 aspects",
        "sign of J  aspects at 27  aspects at 30",
        "+          2              1",
    ]
    assert "L3 from 0: 2 aspects" in run_here("aspects", "innocenti", "--l3-range", ":").stdout


@pytest.mark.parametrize(
    ("options", "status", "shown"),
    [
        (("--l1", "28.1", "--tolerance", "0.0005"), 0, "Margin of 10 cusps at L1 = 28.1;"),
        (("--l1", "28.1", "--tolerance", "0.0007"), 1, "Counter-example: 8 cusps at L1 = 28.1"),
        (
            ("--l1", "28.1", "--window", "28.1"),
            2,
            "--window: is given beside --l1; give exactly one of",
        ),
    ],
)
def test_margins(run_here: Run, options: tuple[str, ...], status: int, shown: str) -> None:
    done = run_here("margin", "innocenti", *options)
    assert done.returncode == status
    assert shown in (done.stderr if status == 2 else done.stdout)


MIRRORED = {"a2x": 30, "a3x": 0, "a3y": 40, "d1": 30, "d2": 50, "d3": 40, "orientation": "cw"}


@pytest.mark.parametrize(
    ("options", "status", "shown"),
    [
        (
            ("--l1", "0.3", "--l2-limits", "90:95"),
            0,
            "L1 = 0.3, within the joint limits: a change of assembly",
        ),
        ((), 2, "--l1: is missing; give exactly one of --l1 and --l1-range"),
    ],
)
def test_changes_of_assembly_mode(run_here: Run, options: tuple[str, ...], status: int, shown: str) -> None:
    done = run_here("assembly-modes", "-", *options, stdin=json.dumps(MIRRORED))
    assert done.returncode == status
    assert shown in (done.stderr if status == 2 else done.stdout)


def test_workspaces(run_here: Run) -> None:
    options = ("--l1-limits", "5:30", "--l2-limits", ":25")
    bounds = {"l1": (5, 30), "l2": (None, 25)}
    expected = workspace(EXAMPLES["innocenti"], -30, bounds).to_json()
    asked = ("workspace", "innocenti", "--phi", "-30", *options)
    assert json.loads(run_here(*asked, "--json").stdout) == expected
    shown = run_here(*asked).stdout
    assert all(region["area"] in shown for region in expected["regions"])
    swept = workspace_sweep(EXAMPLES["innocenti"], -30, 30, 15, bounds).to_json()
    done = run_here("workspace", "innocenti", "--phi", "-30:30:15", *options, "--format", "csv")
    assert done.stdout == workspace_csv(swept)
    assert run_here("plot", "innocenti", "--kind", "workspace", "--phi", "-30", *options).stdout.startswith(
        "<svg"
    )
    assert run_here("workspace", "innocenti", "--phi", "x", *options).stderr.startswith(
        "rpr-cusps workspace: --phi"
    )


def test_poses_with_angles(run_here: Run) -> None:
    expected = sensed_poses(
        EXAMPLES["innocenti"], {"l1": 15}, {"angle2": 150, "angle3": 45}, digits=15
    ).to_json()
    asked = ("poses", "innocenti", "--l1", "15", "--angle2", "150", "--angle3", "45", "--digits", "15")
    assert json.loads(run_here(*asked, "--json").stdout) == expected
    assert all(pose["l2"] in run_here(*asked).stdout for pose in expected["poses"])
    contradicting = ("--angle1", "0", "--angle-tolerance", "0.5")
    assert "No pose agrees with angle" in run_here(*asked, *contradicting).stdout
    assert run_here(*asked, "--angle1", "0").returncode == 2


def test_poses_along_a_leg(run_here: Run) -> None:
    expected = leg_poses(EXAMPLES["innocenti"], {"l1": 17, "l3": 15}, 10, 20, digits=20).to_json()
    asked = ("poses", "innocenti", "--l1", "17", "--l3", "15", "--digits", "20")
    for option in ("--l2-range", "--l2"):
        done = run_here(*asked, option, "10:20", "--format", "json")
        assert (done.returncode, json.loads(done.stdout)) == (0, expected)
    shown = run_here(*asked, "--l2-range", "10:20").stdout
    assert all(end["l2"] in shown for end in expected["ends"])
    assert len(run_here(*asked, "--l2-range", "10:20", "--format", "csv").stdout.splitlines()) == 5
    refused = run_here("poses", "innocenti", "--l1", "17", "--l2-range", ":5", "--l3-range", "1:2")
    assert refused.returncode == 2
    assert "--l3" in refused.stderr


def test_which_poses_are_joined(run_here: Run) -> None:
    legs = ("innocenti", "--l1", "27", "--l2", "20", "--l3", "20")
    limits = ("--to", "l1=27,l2=21,l3=19", "--l2-limits", "5:21")
    done = run_here("pose-connections", *legs, *limits, "--format", "json")
    expected = pose_connections(EXAMPLES["innocenti"], 27, 20, 20, to=(27, 21, 19), limits={"l2": (5, 21)})
    assert json.loads(done.stdout) == expected.to_json()
    shown = run_here("pose-connections", *legs).stdout
    assert "Joined with each other: 1-2, 3-4." in shown
    assert re.search(r"^3 +opposite-signs +opposite-signs +joined +joined$", shown, re.MULTILINE)
    refused = run_here("pose-connections", *legs, "--to", "l1=27,l2=20")
    assert (refused.returncode, refused.stderr.count("--to")) == (2, 1)
    refused = run_here("pose-connections", *legs, "--between", "28:29")
    assert (refused.returncode, "--between: is 28 to 29" in refused.stderr) == (2, True)


def test_a_loop_round_a_cusp_in_every_form(run_here: Run) -> None:
    args = ("path", "innocenti", "--l1", "27", "--cusp", "B", "--samples", "41", "--timing", "trapezoid")
    expected = cusp_loop(EXAMPLES["innocenti"], 27, 2, samples=41, timing="trapezoid").to_json()
    assert json.loads(run_here(*args, "--format", "json").stdout) == expected
    assert run_here(*args, "--format", "csv").stdout == path_csv(expected)
    lines = run_here(*args).stdout.splitlines()
    ends = (expected[end]["pose"] for end in ("from", "to"))
    legs = "L1 = 27, L2 = 15.5, L3 = 16.9"
    assert lines[2] == "Loop round cusp B, from pose {} to pose {} of {}: J > 0".format(*ends, legs)
    assert lines[-1].strip() == "41 samples, of which 21 are shown."
    others = run_here("path", "innocenti", "--l1", "27", "--samples", "2", "--others").stdout.splitlines()[
        -3:
    ]
    assert others[0].strip().startswith("Pose 2 ends on a fold at L1 = 27.0000000000000, L2 = 24.461706")
    assert others[2].strip() == "Pose 4 is carried to pose 4."


def test_a_motion_within_limits_in_every_form(run_here: Run) -> None:
    limits = "--speed", "10", "--acceleration", "l2=20,l3=30", "--jerk", "200", "--chord", "0.2"
    args = ("path", "innocenti", "--l1", "27", "--cusp", "B", *limits)
    motion = {"speed": 10, "acceleration": {"l2": 20, "l3": 30}, "jerk": 200}
    expected = cusp_loop(EXAMPLES["innocenti"], 27, 2, motion=motion, sampling={"chord": "0.2"}).to_json()
    assert json.loads(run_here(*args, "--json").stdout) == expected
    assert run_here(*args, "--format", "csv").stdout == path_csv(expected)
    lines = run_here(*args, "--format", "ndjson").stdout.splitlines()
    assert [json.loads(line) for line in lines] == expected["samples"]
    page = run_here(*args).stdout
    assert f"All legs keep the limits of motion for the {expected['duration']} units of time" in page
    assert "Moving linearly between samples, legs deviate at most: L1 by 0, L2 by 0." in page


def test_a_path_from_pose_to_pose_or_why_there_is_none(run_here: Run) -> None:
    args = ("path", "innocenti", "--l1", "27", "--l2", "25.7", "--l3", "9.2", "--from", "2")
    legs = "L1 = 27, L2 = 25.7, L3 = 9.2"
    joined = run_here(*args, "--to", "4", "--between", "27:30", "--samples", "3").stdout.splitlines()
    assert joined[2] == f"Path from pose 2 to pose 4 of {legs}: J > 0"
    apart = run_here(*args, "--to", "1")
    assert (apart.returncode, apart.stdout.splitlines()[2]) == (
        0,
        f"No path from pose 2 to pose 1 of {legs}: opposite-signs",
    )
    assert "J has different signs" in apart.stdout
    document = json.loads(run_here(*args, "--to", "1", "--format", "json").stdout)
    assert document == joint_path(EXAMPLES["innocenti"], 27, "25.7", "9.2", 2, 1).to_json()


def test_the_clearance_of_a_path(run_here: Run) -> None:
    args = ("path", "innocenti", "--l1", "27", "--l2", "20", "--l3", "20", "--from", "1", "--to", "2")
    wide = run_here(*args, "--samples", "2", "--clearance", "best").stdout.splitlines()
    found = joint_path(EXAMPLES["innocenti"], 27, 20, 20, 1, 2, samples=2, clearance="best").to_json()
    least, most = found["clearance"]["proved"], found["clearance"]["bound"]
    assert wide[-2].strip() == f"Its clearance is at least {least}°; no path has more than {most}°."
    assert wide[-1].strip().startswith("No fold is met while L2 and L3 change by less than")
    narrow = run_here(*args, "--clearance", "25").stdout.splitlines()
    assert narrow[2].endswith("too-narrow")
    refused = run_here(*args, "--clearance", "0")
    assert (refused.returncode, "--clearance: is 0" in refused.stderr) == (2, True)


def test_condition_numbers_of_poses_and_paths(run_here: Run) -> None:
    asked = ("poses", "innocenti", *LEGS, "--digits", "20", "--length-scale", "5/2")
    expected = with_condition(poses(EXAMPLES["innocenti"], "14.98", 15, 30, digits=20), "5/2").to_json()
    assert json.loads(run_here(*asked, "--json").stdout) == expected
    page = run_here(*asked).stdout
    assert all(pose["condition"] in page for pose in expected["poses"])
    args = ("path", "innocenti", "--l1", "27", "--l2", "20", "--l3", "20", "--from", "1", "--to", "2")
    kept = run_here(*args, "--samples", "2", "--max-condition", "12").stdout
    found = joint_path(EXAMPLES["innocenti"], 27, 20, 20, 1, 2, samples=2, max_condition=12).to_json()
    assert f"from {found['condition']['min']} to {found['condition']['max']}" in kept
    assert run_here(*args, "--max-condition", "7").stdout.splitlines()[2].endswith("ill-conditioned")
    rows = csv.DictReader(run_here(*args, "--samples", "2", "--condition", "--format", "csv").stdout.split())
    assert [row["condition"] for row in rows] == [sample["condition"] for sample in found["samples"]]
    refused = run_here(*args, "--max-condition", "0.5")
    assert (refused.returncode, "--max-condition: is 0.5" in refused.stderr) == (2, True)


@pytest.mark.slow
def test_the_articles_method_shows_its_factors(run_here: Run, base_url: str) -> None:
    args = ("solve", "innocenti", "--l1", "14.98", "--digits", "20", "--method", "article")
    lines = run_here(*args).stdout.splitlines()
    assert "L1 = 14.98: 6 cusps" in lines
    head = lines.index("The article's eliminant of degree 96, factor by factor")
    assert lines[head + 1].split("  ")[0] == "factor"
    assert sum(line.startswith("  rejected (") for line in lines) > 0
    here = run_here(*args, "--format", "json")
    assert (here.returncode, here.stderr) == (0, "")
    document = json.loads(here.stdout)
    assert document == article_document(EXAMPLES["innocenti"], [Fraction("14.98")], 20)
    assert run_here(*args, "--format", "csv").stdout == table_csv(document)
    assert run_here(*args, "--format", "json", "--url", base_url).stdout == here.stdout


def test_a_census_in_every_form(run_here: Run) -> None:
    m, start, stop = EXAMPLES["zein-flat"], Fraction(22), Fraction(32)
    part = ("census", "zein-flat", "--l1-range", "22:32", "--digits", "20")
    done = run_here(*part, "--format", "json")
    assert (done.returncode, done.stderr) == (0, "")
    document = json.loads(done.stdout)
    assert document == census(m, digits=20, start=start, stop=stop).to_json()
    cut = restrict_census(census(m, digits=20).to_json(), start, stop)
    assert {**document, "certificate": None} == {**(cut or {}), "certificate": None}
    assert run_here(*part, "--format", "csv").stdout == census_csv(document)
    lines = run_here(*part).stdout.splitlines()
    assert "L1 from 22 up to 32: 4 to 8 cusps, 7 transitions" in lines
    assert sum("swallowtail" in line for line in lines) == 4


def test_a_census_with_sensitivities_in_every_form(run_here: Run) -> None:
    part = ("census", "zein-flat", "--l1-range", "30:33", "--digits", "15", "--sensitivities")
    document = json.loads(run_here(*part, "--format", "json").stdout)
    plain = census(EXAMPLES["zein-flat"], digits=15, start=30, stop=33)
    assert document == with_sensitivities(plain.to_json())
    [head, first, _, last] = csv.reader(run_here(*part, "--format", "csv").stdout.splitlines())
    assert head[5:] == [f"sensitivity_{g}" for g in ("a2x", "a3x", "a3y", "d1", "d2", "d3")]
    moves = document["transitions"][0]["events"][0]["sensitivity"]
    assert first[5:] == [moves["a2x"], moves["a3x"], moves["a3y"], "", "", ""]
    assert last[5:] == [""] * 6
    text = run_here(*part).stdout
    assert "Sensitivities: how fast L1 of each transition changes with each length" in text
    assert moves["a3y"] in text


@pytest.mark.slow
def test_cusp_curves_in_every_form(run_here: Run) -> None:
    args = ("cusp-curves", "zein-flat", "--l1-range", "3:3.2:0.1", "--l1", "3.15", "--digits", "20")
    done = run_here(*args, "--format", "json")
    assert (done.returncode, done.stderr) == (0, "")
    document = json.loads(done.stdout)
    lengths = [Fraction(x) for x in ("3", "3.1", "3.15", "3.2")]
    expected = curves_of(EXAMPLES["zein-flat"], digits=20).sampled(lengths).within(lengths[0], lengths[-1])
    assert document == expected.to_json()
    assert run_here(*args, "--format", "csv").stdout == curves_csv(document)
    lines = run_here(*args).stdout.splitlines()
    assert "L1: 4 cusp curves" in lines
    assert sum(line.startswith("C3 ") for line in lines) == 1 + len(lengths)


@pytest.mark.parametrize(
    ("args", "said"),
    [
        (("poses", "innocenti", "--l1", "1"), "--l2: is missing; give a number"),
        (
            ("path", "innocenti", *LEGS, "--from", "1", "--to", "6"),
            "to: is 6; give the number of a pose, 1 to 2",
        ),
        (
            ("path", "innocenti", "--l1", "27", "--l2-limits", ":9", "--l2-limits", ":8"),
            "--l2-limits: is given twice",
        ),
        (
            ("path", "innocenti", "--l1", "27", "--cusp", "B", "--l2-limits", "20:"),
            "--l2-limits: exclude cusp 2",
        ),
        (("census", "innocenti", "--l2-range", "1:", "--fixed-leg", "1"), "the range is --l1-range"),
        (
            ("path", "innocenti", "--l1", "27", "--speed", "l1=3", "--acceleration", "1"),
            "--speed.l2: is missing",
        ),
        (("census", "innocenti", "--json", "--format", "csv"), "is csv, but json is given already"),
        (
            (
                "check",
                "innocenti",
                "--l1",
                "1",
                "--expect-cusps",
                "2",
                "--jobs",
                "2",
                "--url",
                "http://127.0.0.1:1",
            ),
            "--jobs: is for checks that are computed here",
        ),
    ],
)
def test_bad_input_is_one_line_and_status_2(run_here: Run, args: tuple[str, ...], said: str) -> None:
    done = run_here(*args)
    assert (done.returncode, done.stdout) == (2, "")
    assert said in done.stderr
    assert done.stderr.count("\n") == 1


INNOCENTI = EXAMPLES["innocenti"]


def test_a_slice_as_a_file_and_as_text(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    target = tmp_path / "slice.svg"
    assert main(["plot", "innocenti", "--l1", "14.98", "-o", str(target)]) == 0
    expected = singular_curves(INNOCENTI, "14.98").figure().svg()
    assert target.read_text(encoding="utf-8") == expected
    assert main(["plot", "innocenti", "--l1", "14.98"]) == 0
    assert capsys.readouterr().out == expected


@pytest.mark.parametrize(("suffix", "start"), [(".png", b"\x89PNG"), (".pdf", b"%PDF")])
def test_poses_as_png_and_pdf(tmp_path: Path, suffix: str, start: bytes) -> None:
    """The same bytes as the library's."""
    legs, target = ["--l1", "14.98", "--l2", "16", "--l3", "20", "--pose", "2"], tmp_path / f"pose{suffix}"
    assert main(["plot", "innocenti", "--kind", "mechanism", *legs, "-o", str(target)]) == 0
    figure = poses(INNOCENTI, "14.98", 16, 20, digits=15).figure(2)
    assert target.read_bytes().startswith(start)
    assert target.read_bytes() == figure.encoded(suffix)


def test_a_figure_for_a_column_of_a_journal(capsys: pytest.CaptureFixture[str]) -> None:
    options = ["--width", "3.5in", "--style", "paper", "--unit", "mm", "--no-title", "--no-caption"]
    assert main(["plot", "innocenti", "--l1", "14.98", *options]) == 0
    text = capsys.readouterr().out
    style = Style(width_mm=88.9, has_symbols=True, unit="mm", has_title=False, has_caption=False)
    assert text == singular_curves(INNOCENTI, "14.98").figure().styled(style).svg()
    assert 'width="88.9mm"' in text
    assert "[mm]" in text.split("</desc>")[1]
    assert "A3 = (0" not in text.split("</desc>")[1]


SIDES = ("a2x", "a3x", "a3y", "d1", "d2", "d3")
NO_MARGIN = {
    "similar": ((30, 0, 40, 15, 25, 20), "degenerate"),
    "flat platform": ((30, 11, 27, 13, 9, 4), "the least change makes it no manipulator"),
}


@pytest.mark.parametrize("name", NO_MARGIN)
@pytest.mark.parametrize("what", [("--l1", "14"), ("--l1-range", "14:15", "--max-cusps", "8")])
def test_a_margin_of_0_says_why_without_a_search(run_here: Run, name: str, what: tuple[str, ...]) -> None:
    lengths, why = NO_MARGIN[name]
    geometry = json.dumps(dict(zip(SIDES, lengths, strict=True)))
    done = run_here("margin", "-", *what, "--json", stdin=geometry)
    answer = json.loads(done.stdout)
    assert (done.returncode, answer["proved"], answer["certificate"]["boxes"]) == (1, "0", 0)
    assert why in answer["reason"]
    gate = run_here("margin", "-", *what, "--tolerance", "1e-9", stdin=geometry)
    assert gate.returncode == 1
    assert re.search(rf"verdict +open\nwhy not more +.*{why}", gate.stdout)


def test_a_picture_of_margins_of_a_degenerate_family_needs_no_search(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    geometry = {"a2x": 30, "a3x": 0, "a3y": 40, "d1": 30, "d2": 50, "d3": 40}
    (tmp_path / "a.json").write_text(json.dumps(geometry))
    assert main(["plot", str(tmp_path / "a.json"), "--kind", "margin"]) == 0
    assert "degenerate throughout: the margin is 0" in capsys.readouterr().out


@pytest.mark.long
@pytest.mark.parametrize("kind", ["census", "locus", "projections", "margin"])
def test_pictures_of_all_lengths(kind: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["plot", "zein-flat", "--kind", kind, "--l1-range", "20:40"]) == 0
    assert capsys.readouterr().out.startswith("<svg ")


@pytest.mark.parametrize(
    ("args", "said"),
    [
        (("--l1", "27", "-o", "a.jpg"), "--output: 'a.jpg' does not end in .svg, .png or .pdf"),
        (("--l1", "27", "-o", "/none/a.svg"), "--output: '/none/a.svg' cannot be written: No such file"),
        (("--l1", "27", "-o", "a.png", "--url", "http://127.0.0.1:9"), "--output: a service draws SVG"),
        (("--l1", "27", "--width", "86"), "--width: is '86'; give a length with its unit, such as 86mm"),
        (("--l1", "27", "--cusp", "A"), "--cusp: says nothing about the plot 'slice'; leave it out"),
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


TO = ("--to", "alpha=-40,theta1=140,l1=28", "--samples", "3")


def test_a_path_between_any_poses(run_here: Run) -> None:
    start = {"l1": 27, "l2": 20, "l3": 20, "pose": 1}
    numbered = ("--l1", "27", "--l2", "20", "--l3", "20", "--from", "1")
    named = ("--from", "l1=27,l2=20,l3=20,pose=1")
    expected = pose_path(
        EXAMPLES["innocenti"], start, {"alpha_deg": -40, "theta1_deg": 140, "l1": 28}, samples=3
    )
    for args in (numbered, named):
        done = run_here("path", "innocenti", *args, *TO, "--format", "json")
        assert json.loads(done.stdout) == expected.to_json()
    title = run_here("path", "innocenti", *named, *TO).stdout.splitlines()[2]
    assert title.startswith("Path from pose 1 of L1 = 27, L2 = 20, L3 = 20 to a given pose of L1 = 28, L2 = ")
    same = run_here("path", "innocenti", *named, "--to", "l1=27,l2=20,l3=20,pose=2", "--samples", "3")
    assert same.stdout == run_here("path", "innocenti", *numbered, "--to", "2", "--samples", "3").stdout


@pytest.mark.parametrize(
    ("args", "said"),
    [
        (("--from", "1", "--to", "2"), "--l1: is missing; give a number; --l2: is missing"),
        (("--from", "alpha=1,theta2=2,l2=3", *TO), "--from.theta1_deg: is missing"),
        (("--from", "l1=27,l2=20,l3=20,pose=1", *TO, "--others"), "--others: are followed"),
    ],
)
def test_what_is_wrong_with_a_pose_is_named(run_here: Run, args: tuple[str, ...], said: str) -> None:
    done = run_here("path", "innocenti", *args)
    assert (done.returncode, said in done.stderr) == (2, True), done.stderr
