"""Help, suggestions, and completion at the Tab key."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from rpr_solver import EXAMPLES
from service.cli.main import COMMANDS
from tests.support.cli_process import ENVIRONMENT, Run
from tests.support.processes import PATIENCE

BIN = Path(sys.executable).parent
POSE = ("--l1", "27", "--l2", "20", "--l3", "20")


def test_without_a_command_the_help_is_printed_and_it_is_no_success(run_here: Run) -> None:
    bare, asked, option = run_here(), run_here("help"), run_here("--help")
    assert bare.stdout == asked.stdout == option.stdout
    assert (bare.returncode, asked.returncode, bare.stderr) == (2, 0, "")
    assert all(f"\n    {name}" in bare.stdout for name in COMMANDS)


@pytest.mark.parametrize("words", [("census",), ("keys", "create")])
def test_help_of_a_command(run_here: Run, words: tuple[str, ...]) -> None:
    asked, option = run_here("help", *words), run_here(*words, "--help")
    assert (asked.returncode, asked.stdout) == (0, option.stdout)
    assert asked.stdout.startswith(f"usage: rpr-cusps {' '.join(words)} ")


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("sovle", "innocenti"), "'sovle'; did you mean solve?"),
        (("help", "cencus"), "'cencus'; did you mean census?"),
        (("keys", "creat"), "'creat'; did you mean create?"),
        (("solve", "innocenti", "--l1", "1", "--format", "jsno"), "'jsno'; did you mean json?"),
        (("solve", "innocenti", "--l1", "1", "--digitss", "20"), "--digitss; did you mean --digits?"),
        (("xyzzy",), "'xyzzy'; choose from solve, census, "),
        (("check", "innocenti", "--l1-range", "-1:5", "--max-cusps", "3"), "--l1-range.from: is -1"),
        (("solve", "innocenti", "--l1", "-1/2"), "--l1: is -0.5; a leg length must be > 0"),
        (("paths", "innocenti", *POSE, "--from", "1", "--to", "1"), "--to: is 1, where the path begins"),
    ],
)  # fmt: skip
def test_what_is_mistyped_is_told_in_one_line(run_here: Run, words: tuple[str, ...], said: str) -> None:
    done = run_here(*words)
    assert (done.returncode, done.stdout, done.stderr.count("\n")) == (2, "", 1)
    assert said in done.stderr


@pytest.mark.parametrize(
    "words",
    [
        ("solve", "zein-flat", "--l1", "1", "--digits", "15"),
        ("check", "zein-flat", "--l1", "1", "--expect-cusps", "2"),
        ("poses", "zein-flat", "--l1", "20", "--l2", "20", "--l3", "20"),
    ],
)
def test_json_has_a_short_option_in_every_command(run_here: Run, words: tuple[str, ...]) -> None:
    assert run_here(*words, "--json").stdout == run_here(*words, "--format", "json").stdout


def in_bash(line: str, folder: Path) -> set[str]:
    """What bash offers for a line, by the script that the command prints."""
    script = f"""
        source <(rpr-cusps completion bash)
        read -ra COMP_WORDS <<< "{line}x"; COMP_CWORD=$((${{#COMP_WORDS[@]}} - 1))
        COMP_LINE="{line}"; COMP_POINT={len(line)}; COMP_TYPE=9
        _python_argcomplete rpr-cusps
        printf '%s\\n' "${{COMPREPLY[@]}}"
    """
    path = os.pathsep.join([str(BIN), ENVIRONMENT["PATH"]])
    done = subprocess.run(
        ["bash", "-c", script],
        cwd=folder,
        env={**ENVIRONMENT, "PATH": path},
        capture_output=True,
        text=True,
        timeout=PATIENCE,
        check=True,
    )
    assert done.stderr == ""
    return {word.strip() for word in done.stdout.splitlines() if word.strip()}


def test_bash_completes_commands_options_choices_and_geometries(tmp_path: Path) -> None:
    (tmp_path / "robots").mkdir()
    for name in ("robots/gripper.json", "robots/notes.txt", "robot.json"):
        (tmp_path / name).write_text("{}")
    assert in_bash("rpr-cusps c", tmp_path) == {name for name in COMMANDS if name.startswith("c")}
    assert in_bash("rpr-cusps check innocenti --max", tmp_path) == {"--max-cusps"}
    assert in_bash("rpr-cusps solve innocenti --format c", tmp_path) == {"csv"}
    assert in_bash("rpr-cusps solve ", tmp_path) >= {*EXAMPLES, "robot.json", "robots/"}
    assert in_bash("rpr-cusps solve robots/", tmp_path) == {"robots/gripper.json"}
    assert in_bash("rpr-cusps completion ", tmp_path) >= {"bash", "zsh", "fish"}


@pytest.mark.parametrize("shell", ["bash", "zsh", "fish"])
def test_each_shell_has_its_script(run_here: Run, shell: str) -> None:
    done = run_here("completion", shell)
    assert (done.returncode, done.stderr) == (0, "")
    assert "rpr-cusps" in done.stdout
    if program := shutil.which(shell):
        subprocess.run([program, "-n"], input=done.stdout, text=True, timeout=PATIENCE, check=True)
