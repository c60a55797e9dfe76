"""A path as a message of ROS 2, ``trajectory_msgs/msg/JointTrajectory``: when each leg has which length.

The joints are the legs, with their lengths as positions, in metres; a unit of time is a second. If the path
keeps limits of motion, points have velocities and accelerations, too: the derivatives of the leg lengths by
the law of the certificate (mathematics.md#motions-within-limits). With V the vector of a leg and ' its
derivative by τ on an arc,

    L' = V·V' / L,    L'' = (V'·V' + V·V'' − L'²) / L,    dL/dt = L' τ̇,    d²L/dt² = L'' τ̇² + L' τ̈.

These are computed in doubles, from exact control points, and not proved.
"""

from __future__ import annotations

import json
from bisect import bisect_right
from cmath import rect
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from itertools import accumulate
from math import radians
from typing import Any

from rpr_solver.errors import InputError
from rpr_solver.exact.numerals import double
from rpr_solver.exports.metres import metres_of
from rpr_solver.model.manipulator import Manipulator
from rpr_solver.model.slice_map import SliceMap
from rpr_solver.paths.motion import Law
from rpr_solver.paths.routes import by_leg

JOINTS = ("leg1", "leg2", "leg3")
"""The joints: the prismatic joints of the legs."""
_NANO = 10**9
_LATEST = 2**31
"""In seconds; ``sec`` of a duration is a 32-bit integer."""


def joint_trajectory(
    document: Mapping[str, Any], unit: str | None, *, relative: bool = False
) -> dict[str, Any]:
    """The message, as JSON has it.

    Args:
        document: a path, as JSON.
        unit: that of its lengths: ``"m"``, ``"cm"``, ``"mm"`` or ``"in"``.
        relative: whether positions are changes of lengths since the start of the path, as the joints of the
            model at its first pose (:mod:`rpr_solver.exports.model`) have them.

    Raises:
        InputError: naming ``document``, which is no path, or ``unit``.

    >>> from rpr_solver import EXAMPLES, cusp_loop
    >>> loop = cusp_loop(EXAMPLES["innocenti"], 27, "B", samples=3, duration=10)
    >>> joint_trajectory(loop.to_json(), "mm")["points"][1]["time_from_start"]
    {'sec': 5, 'nanosec': 0}
    """
    metres = metres_of(unit)
    try:
        points = list(_points(document, metres, relative=relative))
    except (KeyError, TypeError, ValueError, IndexError) as error:
        if isinstance(error, InputError):
            raise
        raise InputError.of("document", "is no path; give one as JSON") from None
    return {
        "header": {"stamp": {"sec": 0, "nanosec": 0}, "frame_id": ""},
        "joint_names": list(JOINTS),
        "points": points,
    }


def trajectory_json(document: Mapping[str, Any], unit: str | None, *, relative: bool = False) -> str:
    """The message as JSON."""
    return json.dumps(joint_trajectory(document, unit, relative=relative), indent=1) + "\n"


def trajectory_yaml(document: Mapping[str, Any], unit: str | None, *, relative: bool = False) -> str:
    """The message as YAML: each list of numbers is a line, and all texts are quoted as JSON quotes them."""
    message = joint_trajectory(document, unit, relative=relative)
    lines = [
        f"header: {_flow(message['header'])}",
        f"joint_names: {_flow(message['joint_names'])}",
        "points:",
    ]
    for point in message["points"]:
        first, *others = (f"{name}: {_flow(value)}" for name, value in point.items())
        lines += [f"- {first}", *(f"  {other}" for other in others)]
    return "".join(f"{line}\n" for line in lines)


def _flow(value: Any) -> str:
    """A value in YAML's flow style. A float has a point, without which YAML 1.1 reads 1e-05 as a text."""
    if isinstance(value, Mapping):
        return f"{{{', '.join(f'{name}: {_flow(part)}' for name, part in value.items())}}}"
    if isinstance(value, list):
        return f"[{', '.join(map(_flow, value))}]"
    text = json.dumps(value)
    if isinstance(value, float) and "." not in text:
        return text.replace("e", ".0e")
    return text


def _points(document: Mapping[str, Any], metres: Fraction, *, relative: bool) -> Sequence[dict[str, Any]]:
    samples = document["samples"]
    if not document["connected"]:
        raise InputError.of("document", "has no path; give one that is connected")
    starts = [samples[0][name] if relative else "0" for name in ("l1", "l2", "l3")]
    motion = _Motion.of(document) if document["timing"] == "motion" else None
    points, last = [], -1
    for sample in samples:
        time = Fraction(sample["time"])
        nanoseconds = round(time * _NANO)
        if nanoseconds <= last or nanoseconds >= _LATEST * _NANO:
            message = "has samples less than a nanosecond apart, or later than the seconds of a message"
            raise InputError.of("document", f"{message}; ask for another duration or for fewer samples")
        last = nanoseconds
        lengths = [Fraction(sample[f"l{leg}"]) - Fraction(start) for leg, start in enumerate(starts, 1)]
        point: dict[str, Any] = {"positions": [double(length * metres) for length in lengths]}
        if motion is not None:
            velocities, accelerations = motion.rates(sample, time)
            scale = double(metres)
            point["velocities"] = [scale * x for x in velocities]
            point["accelerations"] = [scale * x for x in accelerations]
        sec, nanosec = divmod(nanoseconds, _NANO)
        points.append({**point, "time_from_start": {"sec": sec, "nanosec": nanosec}})
    return points


@dataclass(frozen=True)
class _Run:
    """A run from rest to rest: its law, the time of its tick, and the shares of its arcs in its parameter."""

    law: Law
    tick: Fraction
    shares: tuple[Fraction, ...]

    @property
    def duration(self) -> Fraction:
        return self.tick * (len(self.law.nodes) - 1)

    def rates(self, time: Fraction, arc: int) -> tuple[float, float]:
        """The speed and the acceleration of τ on one of its arcs."""
        ticks = min(max(time / self.tick, Fraction(0)), Fraction(len(self.law.nodes) - 1))
        k = min(int(ticks), len(self.law.nodes) - 2)
        _, u, a, j = self.law.nodes[k]
        x = ticks - k
        share = self.shares[arc] * self.tick
        return double((u + x * (a + x * j / 2)) / share), double((a + x * j) / (share * self.tick))


@dataclass(frozen=True)
class _Motion:
    """The legs along the arcs, and the law of time.

    Attributes:
        legs: m and a of the free legs, in the user's unit.
        arcs: the control points: α and θ in radians, and the length of the fixed leg.
        fixed: the fixed leg.
        runs: the laws of all runs.
    """

    legs: tuple[tuple[complex, complex], ...]
    arcs: tuple[tuple[tuple[float, float, float], ...], ...]
    fixed: int
    runs: tuple[_Run, ...]

    @classmethod
    def of(cls, document: Mapping[str, Any]) -> _Motion:
        """That of a document."""
        fixed, certificate = document["fixed_leg"], document["certificate"]
        slice_map = SliceMap.of(Manipulator.from_json(document["geometry"], max_digits=1 << 20), fixed)
        names = "alpha_deg", f"theta{fixed}_deg", f"l{fixed}"

        def control(point: Any) -> tuple[float, float, float]:
            turns = (0, 0)
            if isinstance(point, str):
                turns = tuple(certificate["turns"][point].values())
                point = {**document, **document[point]}
            alpha, theta, length = (Fraction(point[name]) for name in names)
            first, second = (radians(double(x + 360 * n)) for x, n in zip((alpha, theta), turns, strict=True))
            return first, second, double(length)

        runs = tuple(
            _Run(
                Law(tuple(run["speeds"]), run["window"]),
                Fraction(run["tick"]),
                tuple(map(Fraction, run["shares"])),
            )
            for run in certificate["motion"]
        )
        arcs = tuple(tuple(map(control, arc)) for arc in certificate["arcs"])
        return cls(
            tuple(leg.doubles(slice_map.scale) for leg in (slice_map.f, slice_map.g)), arcs, fixed, runs
        )

    @cached_property
    def _starts(self) -> list[Fraction]:
        """The times at which the runs begin."""
        return [Fraction(0), *accumulate(run.duration for run in self.runs)]

    @cached_property
    def _firsts(self) -> list[int]:
        """The numbers of their first arcs."""
        return [0, *accumulate(len(run.shares) for run in self.runs)]

    def rates(self, sample: Mapping[str, str], time: Fraction) -> tuple[Sequence[float], Sequence[float]]:
        """The velocities and the accelerations of the legs at a sample."""
        number = min(bisect_right(self._starts, time), len(self.runs)) - 1
        place = Fraction(sample["place"])
        first, after = self._firsts[number], self._firsts[number + 1]
        arc = min(max(int(place), first), after - 1)
        speed, rise = self.runs[number].rates(time - self._starts[number], arc - first)
        slopes = self._slopes(arc, double(place - arc))
        velocities = [one * speed for one, _ in slopes]
        return velocities, [two * speed**2 + one * rise for one, two in slopes]

    def _slopes(self, arc: int, tau: float) -> tuple[tuple[float, float], ...]:
        """L' and L'' of L1, L2 and L3."""
        (alpha, alpha1, alpha2), (theta, theta1, theta2), (length, length1, length2) = (
            _bezier(p, tau) for p in zip(*self.arcs[arc], strict=True)
        )
        e, z = rect(1, theta), rect(1, alpha)
        # L e^iθ and its derivatives, without e^iθ
        tip = length * e
        tip1 = e * complex(length1, length * theta1)
        tip2 = e * complex(length2 - length * theta1**2, 2 * length1 * theta1 + length * theta2)
        found = [(length1, length2)]
        for m, a in self.legs:
            turned = z * m
            v, v1 = tip + turned - a, tip1 + 1j * alpha1 * turned
            v2 = tip2 + (1j * alpha2 - alpha1**2) * turned
            size = abs(v)
            first = (v.conjugate() * v1).real / size
            found.append((first, (abs(v1) ** 2 + (v.conjugate() * v2).real - first**2) / size))
        return by_leg(self.fixed, found)


def _bezier(points: Sequence[float], tau: float) -> tuple[float, float, float]:
    """A Bézier curve of two or three control points, and its first two derivatives."""
    if len(points) == 2:
        first, last = points
        return first + tau * (last - first), last - first, 0.0
    first, middle, last = points
    slope, bend = 2 * (middle - first), 2 * (first - 2 * middle + last)
    return first + tau * (slope + tau * bend / 2), slope + tau * bend, bend
