"""The errors of the stack; each message is for the user.

RuntimeError
└── StackError          the port is taken, Redis cannot be reached, or a setting is invalid
    └── EmbeddedError   the embedded server cannot be started
"""

from __future__ import annotations


class StackError(RuntimeError):
    """The stack cannot run."""


class EmbeddedError(StackError):
    """The embedded server cannot be started."""
