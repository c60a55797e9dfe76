"""Documents with one fault: each mutation of a right document, which a verification must refuse."""

from __future__ import annotations

import random
from collections.abc import Callable, Iterator
from copy import deepcopy
from typing import Any

Document = dict[str, Any]
Mutation = Callable[[random.Random, Document], str | None]
"""Changes a document in place; returns what it did, or None where that is impossible."""

COORDINATES = ("alpha_deg", "theta1_deg", "theta2_deg", "theta3_deg", "l1", "l2", "l3", "b1_x", "b1_y")


def other_digit(draw: random.Random, text: str) -> str:
    """The number with one significant digit changed."""
    mantissa = text.partition("e")[0]
    first = next(i for i, c in enumerate(mantissa) if c in "123456789")
    place = draw.choice([i for i, c in enumerate(mantissa) if i >= first and c.isdigit()])
    digit = draw.choice([d for d in "0123456789" if d != text[place] and (d != "0" or place > first)])
    return text[:place] + digit + text[place + 1 :]


def _slice(draw: random.Random, document: Document) -> Document | None:
    parts = [part for part in document["slices"] if part.get("cusps")]
    return draw.choice(parts) if parts else None


def digit_of_a_cusp(draw: random.Random, document: Document) -> str | None:
    """One digit of one coordinate of a cusp."""
    if (part := _slice(draw, document)) is None:
        return None
    point = draw.choice(part["cusps"])
    name = draw.choice([name for name in COORDINATES if name in point and point[name] != "0"])
    point[name] = other_digit(draw, point[name])
    return f"a digit of {name}"


def missing_cusp(draw: random.Random, document: Document) -> str | None:
    """A cusp left out, and the count less."""
    if (part := _slice(draw, document)) is None:
        return None
    del part["cusps"][draw.randrange(len(part["cusps"]))]
    part["count"] -= 1
    return "a missing cusp"


def doubled_cusp(draw: random.Random, document: Document) -> str | None:
    """A cusp twice, and the count more."""
    if (part := _slice(draw, document)) is None:
        return None
    n = draw.randrange(len(part["cusps"]))
    part["cusps"].insert(n, dict(part["cusps"][n]))
    part["count"] += 1
    return "a doubled cusp"


def other_count(draw: random.Random, document: Document) -> str:
    """Another count."""
    draw.choice(document["slices"])["count"] += draw.choice([-2, -1, 1, 2])
    return "another count"


def other_length(draw: random.Random, document: Document) -> str | None:
    """Another length of the fixed leg."""
    if (part := _slice(draw, document)) is None:
        return None
    name = f"l{document['fixed_leg']}"
    part[name] += "01" if "." in part[name] else ".001"
    return f"another {name}"


def other_geometry(draw: random.Random, document: Document) -> str:
    """Another side of the platform."""
    geometry = document["geometry"]
    name = draw.choice(["a2x", "a3y", "d1"])
    geometry[name] += "01" if "." in geometry[name] else ".001"
    return f"another {name}"


def other_factor(draw: random.Random, document: Document) -> str | None:
    """Another multiplicity or number of real roots in the certificate."""
    if (part := _slice(draw, document)) is None:
        return None
    certificate = part["certificate"]
    if draw.random() < 0.5:
        certificate["real_roots"] += 2
    else:
        draw.choice(certificate["factors"])["multiplicity"] += 1
    return "another certificate"


OF_TABLES: tuple[Mutation, ...] = (
    digit_of_a_cusp,
    missing_cusp,
    doubled_cusp,
    other_count,
    other_length,
    other_geometry,
    other_factor,
)


def _pose(draw: random.Random, document: Document) -> Document | None:
    return draw.choice(document["poses"]) if document["poses"] else None


def digit_of_a_pose(draw: random.Random, document: Document) -> str | None:
    """One digit of one coordinate of a pose."""
    if (pose := _pose(draw, document)) is None:
        return None
    name = draw.choice([name for name in COORDINATES if name in pose and pose[name] != "0"])
    pose[name] = other_digit(draw, pose[name])
    return f"a digit of {name}"


def missing_pose(draw: random.Random, document: Document) -> str | None:
    """A pose left out, and both counts less."""
    if (pose := _pose(draw, document)) is None:
        return None
    document["poses"].remove(pose)
    document["count"] -= 1
    document["count_with_multiplicity"] -= pose["multiplicity"]
    return "a missing pose"


def other_multiplicity(draw: random.Random, document: Document) -> str | None:
    """Another multiplicity, and the sum."""
    if (pose := _pose(draw, document)) is None:
        return None
    change = 1 if pose["multiplicity"] < 3 else -1
    pose["multiplicity"] += change
    document["count_with_multiplicity"] += change
    return "another multiplicity"


def other_leg(draw: random.Random, document: Document) -> str:
    """Another length of a leg."""
    name = draw.choice(["l1", "l2", "l3"])
    document[name] += "01" if "." in document[name] else ".001"
    return f"another {name}"


def other_coefficient(draw: random.Random, document: Document) -> str:
    """Another coefficient of the polynomial."""
    coefficients = document["polynomial"]["coefficients"]
    n = draw.randrange(len(coefficients))
    coefficients[n] = str(int(coefficients[n]) + 1)
    return "another coefficient"


OF_POSES: tuple[Mutation, ...] = (
    digit_of_a_pose,
    missing_pose,
    other_multiplicity,
    other_leg,
    other_coefficient,
    other_geometry,
)


def mutated(
    document: Document, mutations: tuple[Mutation, ...], count: int, seed: int
) -> Iterator[tuple[str, Document]]:
    """Yields ``count`` mutations of a document, of each kind in turn, with what was done."""
    draw = random.Random(seed)
    for n in range(count):
        wrong = deepcopy(document)
        done = mutations[n % len(mutations)](draw, wrong)
        if done is not None:
            yield done, wrong
