"""`rpr-cusps check`: requirements of files, and the forms of their outcome for other programs."""

from service.cli.check.command import COMMANDS

__all__ = ["COMMANDS"]
