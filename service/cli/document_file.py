"""A document of rpr-cusps from a file or standard input."""

from __future__ import annotations

import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from rpr_solver.errors import InputError
from service.cli import arguments
from service.schemas.exact_json import JsonError, parse_json, plain


def read_document(name: str) -> Mapping[str, Any]:
    """Returns the document.

    Raises:
        InputError: the file cannot be read, or holds no object.
    """
    shown = arguments.shown_name(name)
    try:
        body = sys.stdin.buffer.read() if name == arguments.STANDARD_INPUT else Path(name).read_bytes()
        document = plain(parse_json(body, shown))
    except OSError as error:
        raise InputError.of("FILE", f"{shown} cannot be read: {error.strerror}") from None
    except JsonError as error:
        raise InputError.of("FILE", error.detail) from None
    if not isinstance(document, dict):
        raise InputError.of("FILE", f"{shown} holds no object; give a document of rpr-cusps")
    return document
