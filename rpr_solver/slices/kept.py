"""The eliminants of the manipulators asked for last, so that a loop of single slices eliminates once."""

from __future__ import annotations

from collections import OrderedDict
from dataclasses import dataclass, field, replace
from threading import Lock

from rpr_solver.contract import check_leg, check_type
from rpr_solver.model.manipulator import Manipulator
from rpr_solver.slices.eliminant import Eliminant, eliminate

MOST_BYTES = 8 << 20
"""The size of the coefficients that are kept: those of about 200 manipulators of ordinary sides."""

_Key = tuple[Manipulator, int]


@dataclass
class KeptEliminants:
    """Eliminants by geometry and fixed leg, the last used ones; safe for threads.

    Each call gets an :class:`Eliminant` of its own, which shares nothing that changes.

    >>> from rpr_solver import EXAMPLES
    >>> store = KeptEliminants()
    >>> first, second = (store.eliminant(EXAMPLES["innocenti"], 1) for _ in range(2))
    >>> first is second, first.a is second.a, len(store)
    (False, True, 1)
    """

    most_bytes: int = MOST_BYTES
    _found: OrderedDict[_Key, tuple[Eliminant, int]] = field(default_factory=OrderedDict, repr=False)
    _bytes: int = 0
    _lock: Lock = field(default_factory=Lock, repr=False)

    def __len__(self) -> int:
        return len(self._found)

    def eliminant(self, manipulator: Manipulator, fixed_leg: int) -> Eliminant:
        """As :func:`eliminate`, which is only called for what is not kept.

        Raises:
            InputError: naming ``manipulator`` or ``fixed_leg``.
            SolverError: the resultant lacks one of its known factors.
        """
        check_type(manipulator, Manipulator, "manipulator")
        key = manipulator, check_leg(fixed_leg)
        with self._lock:
            if key in self._found:
                self._found.move_to_end(key)
                return replace(self._found[key][0])
        # without the lock: another thread may want another manipulator meanwhile
        found = eliminate(manipulator, fixed_leg)
        size = sum(int(x).bit_length() // 8 + 32 for part in (found.a, found.b) for x in part.entries())
        with self._lock:
            if size <= self.most_bytes and key not in self._found:
                self._found[key] = found, size
                self._bytes += size
            while self._bytes > self.most_bytes:
                _, (_, freed) = self._found.popitem(last=False)
                self._bytes -= freed
        return replace(found)


kept_eliminant = KeptEliminants().eliminant
"""As :func:`eliminate`, for calls that are likely to come again with the same geometry and leg."""
