"""Print what makes a shell complete the commands, options and files of rpr-cusps at the Tab key."""

from __future__ import annotations

import argparse
import os
from collections.abc import Sequence

from service.cli import output

DESCRIPTION = __doc__
EXAMPLES = """\
examples:
  eval "$(rpr-cusps completion bash)"              in ~/.bashrc
  eval "$(rpr-cusps completion zsh)"               in ~/.zshrc, after compinit
  rpr-cusps completion fish > ~/.config/fish/completions/rpr-cusps.fish
"""

SHELLS = ("bash", "zsh", "fish")
_ASKED = "_ARGCOMPLETE"


def configure(parser: argparse.ArgumentParser) -> None:
    """Add the options."""
    parser.add_argument("shell", metavar="SHELL", choices=SHELLS, help="bash, zsh or fish")


def run(args: argparse.Namespace) -> int:
    """Run the command; returns the exit status."""
    from argcomplete.shell_integration import shellcode  # few need it, and a start is to be quick

    output.write(shellcode(["rpr-cusps"], shell=args.shell))
    return 0


def typed() -> Sequence[str] | None:
    """The words that are to be completed, if a shell asks for that."""
    return os.environ.get("COMP_LINE", "").split()[1:] if _ASKED in os.environ else None


def complete(parser: argparse.ArgumentParser) -> None:
    """Answer a shell, and exit."""
    import argcomplete

    argcomplete.autocomplete(parser)
