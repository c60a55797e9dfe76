"""The price of a question, as a limit on it."""

from __future__ import annotations

from dataclasses import replace

from rpr_solver.errors import FieldProblem
from service.schemas.limits import LimitError, Limits
from worker.answers.cost import Sizes
from worker.answers.documents import VERIFICATION
from worker.answers.plots import PLOT
from worker.answers.requests import JobRequest

_SHORT = 40
"""Bits of numbers that are not worth shortening."""


def check_price(request: JobRequest, limits: Limits) -> None:
    """Refuse a question whose answer takes too long, whatever is known already.

    Raises:
        LimitError: naming what to reduce: whatever suffices alone, or else what saves most.
    """
    size = request.sizes
    price = request.kind.seconds(size)
    limit = limits.max_cost_seconds
    if price <= limit:
        return
    ways = _ways(request, size)
    prices = {field: request.kind.seconds(smaller) for field, (smaller, _) in ways.items()}
    enough = [field for field in ways if prices[field] <= limit] or [min(prices, key=prices.__getitem__)]
    cost = f"would take about {_rounded(price)} s of one core; the limit max_cost_seconds is {limit}"
    problems = [FieldProblem(field, f"{cost}; {ways[field][1]}") for field in enough]
    raise LimitError(problems, "max_cost_seconds", limit)


def _ways(request: JobRequest, size: Sizes) -> dict[str, tuple[Sizes, str]]:
    """Returns the fields that can be reduced, each with the sizes at best and what to do."""
    content = request.content
    long = f"in their smallest common unit its sides have up to {_digits(size.geometry)} digits"
    shape = (
        ", and its triangles are nearly, but not quite, of a special shape" if size.nearness > _SHORT else ""
    )
    plain = replace(size, geometry=min(size.geometry, _SHORT), nearness=0)
    ways = {
        "geometry": (plain, f"shorten its numbers: {long}{shape}"),
        "digits": (replace(size, digits=15), f"ask for fewer than {size.digits} digits"),
    }
    if request.kind is VERIFICATION:
        part = replace(size, count=1, objects=0, lengths=min(size.lengths, _SHORT))
        has = f"its numbers have up to {_digits(size.lengths)} digits, and {size.objects} objects are listed"
        ways["document"] = (part, f"verify a part of it: {has}")
    elif size.count > 1 and request.kind is not PLOT:
        listed = isinstance(content.get("l1"), list) or content.get("lengths")
        leg = f"l{content.get('fixed_leg', 1)}" if listed else "samples"
        ways[leg] = (replace(size, count=1), f"ask for fewer than {size.count}")
    return ways


def _digits(bits: int) -> int:
    return int(bits * 0.30103) + 1


def _rounded(price: float) -> str:
    return f"{float(f'{price:.2g}'):.0f}"
