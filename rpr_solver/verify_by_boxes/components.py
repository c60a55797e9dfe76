"""Connected components of a graph."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Integers = NDArray[np.int64]


def components(count: int, pairs: Integers) -> Integers:
    """For each of so many nodes the least one with which pairs, of shape (2, pairs), connect it.

    Invariant: a node is connected with the one that it points to, which is not greater. It ends since each
    round has fewer nodes that point to themselves, unless no pair is left in two components.
    """
    found = np.arange(count)
    while (apart := (ends := found[pairs])[0] != ends[1]).any():
        np.minimum.at(found, ends[:, apart].max(0), ends[:, apart].min(0))
        while (found != found[found]).any():
            found = found[found]
    return found
