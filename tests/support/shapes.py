"""Whether an object of a document has just the members, of just the types, that a TypedDict declares."""

from collections.abc import Iterator
from types import NoneType, UnionType
from typing import Any, get_args, get_origin, get_type_hints, is_typeddict


def misfits(value: Any, shape: Any, where: str = "") -> Iterator[str]:
    """Every place at which a value departs from its declared type."""
    if is_typeddict(shape):
        hints = get_type_hints(shape)
        if not isinstance(value, dict):
            yield f"{where} is no object"
            return
        yield from (f"{where}.{name}" for name in value.keys() ^ hints.keys())
        for name in value.keys() & hints.keys():
            yield from misfits(value[name], hints[name], f"{where}.{name}")
    elif get_origin(shape) is list:
        if not isinstance(value, list):
            yield f"{where} is no list"
            return
        for place, item in enumerate(value):
            yield from misfits(item, get_args(shape)[0], f"{where}[{place}]")
    elif get_origin(shape) is dict:
        names, values = get_args(shape)
        for name, item in value.items():
            yield from misfits(name, names, f"{where}, a name")
            yield from misfits(item, values, f"{where}.{name}")
    elif get_origin(shape) is UnionType:
        if all(list(misfits(value, option, where)) for option in get_args(shape)):
            yield f"{where} is a {type(value).__name__}"
    elif type(value) is not (NoneType if shape is None else shape):
        yield f"{where} is a {type(value).__name__}"
