"""Processor time of paths: loops round all cusps of some slices, paths from pose to pose, assembly modes.

    python -P benchmarks/paths.py

The slice is known beforehand; a loop is then searched, proved, numbered by direct kinematics and sampled.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from functools import partial
from statistics import median
from typing import Any

from rpr_solver import EXAMPLES, assembly_modes, eliminate, joint_path, pose_connections, pose_path
from rpr_solver.paths.loops import loop_in_slice, slice_for_loops
from rpr_solver.paths.question import PathTerms

SLICES = (("innocenti", "14.98"), ("innocenti", "27"), ("innocenti", "28.1"), ("fourteen-cusps", "5.96"))
POSES = (("27", "20", "20", 1, 2), ("14.98", "15", "12", 3, 6), ("14.98", "15", "12", 1, 5))
HERE = {"l1": 27, "l2": 20, "l3": 20, "pose": 1}
PAIRS: tuple[dict[str, Any], ...] = (
    {"stop": {"l1": 27, "l2": 21, "l3": 19, "pose": 2}},
    {"stop": {"alpha_deg": -40, "theta1_deg": 140, "l1": 27}},
    {"stop": {"l1": 30, "l2": 21, "l3": 19, "pose": 1}},
    {"stop": {"alpha_deg": -40, "theta1_deg": 140, "l1": 27}, "limits": {"l2": (15, 30)}},
)
WIDE: tuple[tuple[Any, ...], ...] = (("27", "25.7", "9.2", 1, 3), *POSES)
MODES: tuple[dict[str, Any], ...] = (
    {"length": 27},
    {"length": "0.1"},
    {"length": 27, "limits": {"l2": (20, 30), "l3": (20, 30)}},
    {"between": (20, 30)},
    {"between": ("0.05", "0.1")},
)
PLAIN = (PathTerms.of(samples=2), PathTerms.of(samples=101))
REPEATS = 3


def milliseconds(call: Callable[[], object]) -> float:
    """Returns the least processor time of several calls."""
    times = []
    for _ in range(REPEATS):
        start = time.process_time()
        call()
        times.append(time.process_time() - start)
    return 1000 * min(times)


def loops(name: str, length: str, asked: Sequence[PathTerms] = PLAIN) -> str:
    """Returns a line on the loops of one slice."""
    eliminant = eliminate(EXAMPLES[name])
    table = slice_for_loops(eliminant, length)
    line = f"{name:15s} L1 = {length:6s} {table.count:2d} loops"
    for terms in asked:
        times = [
            milliseconds(partial(loop_in_slice, eliminant, table, cusp, terms))
            for cusp in range(1, table.count + 1)
        ]
        line += f"   {terms.plan.count:4d} samples: median {median(times):5.1f} ms, most {max(times):5.1f} ms"
    return line


def main() -> None:
    """Print the table."""
    for name, length in SLICES:
        print(loops(name, length))
    for pair in POSES:
        spent = milliseconds(partial(joint_path, EXAMPLES["innocenti"], *pair))
        print(f"innocenti, L1, L2, L3, from, to = {pair}: {spent:5.1f} ms")
    for ends in PAIRS:
        path = pose_path(EXAMPLES["innocenti"], HERE, **ends)
        spent = milliseconds(partial(pose_path, EXAMPLES["innocenti"], HERE, **ends))
        print(f"{path}: {spent:5.1f} ms")
    for pair in WIDE:
        ask = partial(joint_path, EXAMPLES["innocenti"], *pair, clearance="best")
        print(f"innocenti {pair}, widest, {ask().clearance}: {milliseconds(ask):5.1f} ms")
    widest = PathTerms.of(samples=101, clearance="best")
    print(loops("innocenti", "27", [widest]))
    for with_parts in (False, True):
        within = {"limits": {"l2": (5, 21)}, "parts": with_parts}
        ask_all = partial(pose_connections, EXAMPLES["innocenti"], 27, 20, 20, **within)
        print(f"{ask_all()}, {'with' if with_parts else 'without'} parts: {milliseconds(ask_all):5.1f} ms")
    for asked in MODES:
        answer = assembly_modes(EXAMPLES["innocenti"], **asked)
        times = [
            milliseconds(partial(assembly_modes, EXAMPLES["innocenti"], **asked, with_regions=with_regions))
            for with_regions in (False, True)
        ]
        print(f"{answer}: {times[0]:5.1f} ms, with regions {times[1]:5.1f} ms")


if __name__ == "__main__":
    main()
