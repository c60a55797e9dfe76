"""The errors of the stack; each message is for the user.

RuntimeError
└── StackError            the port is taken, or Redis cannot be reached
    ├── BadAddressError   the address of Redis cannot be understood
    └── EmbeddedError     the embedded server cannot be started
"""

from __future__ import annotations


class StackError(RuntimeError):
    """The stack cannot run."""


class BadAddressError(StackError):
    """The address of Redis cannot be understood."""


class EmbeddedError(StackError):
    """The embedded server cannot be started."""
