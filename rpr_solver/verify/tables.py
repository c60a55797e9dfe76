"""Cusp tables: documents of several slices."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from rpr_solver.contract import Progress, check_digits, check_leg
from rpr_solver.errors import InputError
from rpr_solver.verify.claims import Claim
from rpr_solver.verify.manipulator import Geometry
from rpr_solver.verify.slices import slice_claims


def table_claims(geometry: Geometry, document: Mapping[str, Any], progress: Progress) -> Iterator[Claim]:
    """The claims of all slices of a cusp table.

    Raises:
        InputError: naming a member that cannot be read.
    """
    fixed = check_leg(document.get("fixed_leg", 1))
    digits = check_digits(document["digits"]) if "digits" in document else 0
    slices = document["slices"]
    if not isinstance(slices, list) or not all(isinstance(part, Mapping) for part in slices):
        raise InputError.of("slices", "is not a list of slices")
    for n, part in enumerate(slices):
        progress(n, len(slices))
        yield from slice_claims(geometry, fixed, part, digits, f"/slices/{n}")
    progress(len(slices), len(slices))
