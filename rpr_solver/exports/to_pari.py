"""Scripts for PARI/GP."""

from __future__ import annotations

from rpr_solver.exports.problem import Leg, Problem
from rpr_solver.exports.text import filled

_SCRIPT = r"""
default(realprecision, @PRECISION@); default(parisizemax, 2^32);
['v, 'w, 't, 'u, 'c, 's, 'd, 'e, 'L, 'h];  \\ the order of the variables

\\ c, s: cosine and sine of alpha; d, e: of theta. A moving leg, seen from the fixed one, has the base point
\\ (ax, ay) and the platform point (x, y); h is the height of the platform.
SQUARE = @SQUARE@; H = @HEIGHT@; ROOT = @SIGN@*sqrt(SQUARE);
square(ax, ay, x, y) = ('L*'d + x*'c - y*'s - ax)^2 + ('L*'e + x*'s + y*'c - ay)^2;
f = square(@FIRST@);
g = square(@SECOND@);

\\ J = 0: the pose is singular. E = 0 as well, along f or g: three poses coalesce. V = 0 as well: four.
da(F) = 'c*deriv(F, 's) - 's*deriv(F, 'c);
dt(F) = 'd*deriv(F, 'e) - 'e*deriv(F, 'd);
along(F, G) = da(F)*dt(G) - dt(F)*da(G);
J = along(f, g)/'L; Ja = da(J); Jt = dt(J);
Ef = along(f, J); Eg = along(g, J); Vf = along(f, Ef); Vg = along(g, Eg);

\\ Half tangents t, u of alpha, theta are counted from these turns, given by cosine and sine.
TURNS = [@TURNS@];
turned(t, k) = [TURNS[k][1]*(1 - t^2) - 2*TURNS[k][2]*t, TURNS[k][2]*(1 - t^2) + 2*TURNS[k][1]*t];
{halved(F, degree) =  \\ of a form of this degree in (c, s) and in (d, e); v, w: 1/(1 + t^2), 1/(1 + u^2)
  my(P = substvec(F, ['c, 's, 'd, 'e], concat('v*turned('t, 1), 'w*turned('u, 2))));
  my(m = poldegree(P, 'v), n = poldegree(P, 'w));
  P = sum(i = 0, m, sum(k = 0, n, polcoef(polcoef(P, i, 'v), k, 'w)*(1 + 't^2)^(m - i)*(1 + 'u^2)^(n - k)));
  P \ (1 + 't^2)^(m - degree) \ (1 + 'u^2)^(n - degree);
}

\\ Numbers: h put in; and whether a value is 0, for a form of degree k in the lengths.
num(F) = subst(lift(F), 'h, ROOT);
SIZE = @SIZE@;
small(x, k, l) = abs(x) < (SIZE + l)^k*10^-(@PRECISION@\4);
near(x, y) = abs(x - y) <= 10^(2 - @DIGITS@)*max(1, abs(y));
same(x, y) = #x == #y && #[k | k <- [1..#x], near(x[k], y[k])] == #x;
degrees(x, y) = my(a = arg(x + I*y)*180/Pi); if(a < 10^(2 - @DIGITS@) - 180, a + 360, a);

{cusps(l) =
  my(j = halved(subst(J, 'L, l), 2), E = halved(subst(Ef, 'L, l), 3), p = ['c, 's, 'd, 'e], us = []);
  my(at = [num(subst(F, 'L, l)) | F <- [da(f), dt(f), da(g), dt(g), J, Ja, Jt, Ef, Eg, f, g]]);
  my(V = [num(subst(F, 'L, l)) | F <- [Vf, Vg]], found = List(), r, ts, x, y, by_g);
  r = simplify(lift(polresultant(j, E, 't)));
  if (r == 0, error("J and E share a curve of poses"));
  \\ its norm is rational; roots of the conjugate are no common zeros of J and E
  if (#variables(r) > 1, r = simplify(lift(r*Mod(1, 'h^2 - SQUARE)*subst(r, 'h, -'h))));
  foreach(factor(r)[, 1], F, us = concat(us, polrootsreal(F)));
  j = num(j);
  for (k = 1, #us,
    ts = [real(z) | z <- polroots(subst(j, 'u, us[k])), abs(imag(z)) < 10^-(@PRECISION@\4)*(1 + abs(z))];
    for (i = 1, #ts,
      x = concat(turned(ts[i], 1)/(1 + ts[i]^2), turned(us[k], 2)/(1 + us[k]^2));
      y = substvec(at, p, x);
      by_g = small(y[1], 2, l) && small(y[2], 2, l);
      if (by_g && small(y[3], 2, l) && small(y[4], 2, l), next);
      if (small(y[6], 3, l) && small(y[7], 3, l), next);
      if (!small(y[5], 3, l) || !small(y[8 + by_g], 5, l), next);
      if (small(substvec(V[1 + by_g], p, x), 7, l), next);
      listput(found, [degrees(x[1], x[2]), degrees(x[3], x[4]), sqrt(abs(y[10])), sqrt(abs(y[11]))])));
  Vec(found);
}

\\ The answer that is expected.
right_ones = 0;
say(what, right) = {right_ones += right; print(what, if(right, ": agrees", ": differs"))};
{check_slice(name, l, count, expected) =
  my(found = cusps(l), right = #found == count);
  for (k = 1, #expected, right = right && #[x | x <- found, same(x, expected[k])] == 1);
  say(Str(name, ": ", #found, " cusps, ", count, " expected"), right);
}
{check_event(name, l, kind, expected) =  \\ Newton's method from the printed pose
  my(F = if(kind == "swallowtail", [J, Ef, Vf], [J, Ja, Jt]), M, x, p, y);
  F = [num(G) | G <- F];
  M = Mat([[da(G), dt(G), deriv(G, 'L)]~ | G <- F])~;
  x = [expected[1]*Pi/180, expected[2]*Pi/180, l];
  for (step = 1, 12,
    p = [cos(x[1]), sin(x[1]), cos(x[2]), sin(x[2]), x[3]];
    y = substvec(F, ['c, 's, 'd, 'e, 'L], p);
    if (step < 12, x -= matsolve(substvec(M, ['c, 's, 'd, 'e, 'L], p), y~)~));
  p = [degrees(p[1], p[2]), degrees(p[3], p[4]), sqrt(abs(substvec(num(f), ['c, 's, 'd, 'e, 'L], p))),
    sqrt(abs(substvec(num(g), ['c, 's, 'd, 'e, 'L], p)))];
  y = small(y[1], 3, l) && small(y[2], 5, l) && small(y[3], 7, l);
  say(Str(name, ": ", kind), y && near(x[3], l) && same(p, expected));
}
@CHECKS@
print(if(right_ones == @TOTAL@, "agrees", "differs"));
quit(right_ones != @TOTAL@);
"""


def script(problem: Problem) -> str:
    """The script for ``gp -q``."""
    height = "Mod('h, 'h^2 - SQUARE)" if problem.height is None else problem.height
    checks = [
        f'check_slice("L{problem.fixed_leg} = {part.length}", {part.exact}, {part.count}, '
        f"[{', '.join(map(_row, part.cusps or ()))}]);"
        for part in problem.slices
    ]
    checks += [
        f'check_event("L{problem.fixed_leg} = {event.length}", {event.length}, "{event.system}", '
        f"{_row(event.numbers)});"
        for event in problem.events
    ]
    first, second = (_leg(leg) for leg in problem.legs)
    turns = ", ".join(f"[{c}, {s}]" for c, s in problem.turns)
    parts = {"HEIGHT": height, "TURNS": turns, "FIRST": first, "SECOND": second, "CHECKS": "\n".join(checks)}
    return filled(_SCRIPT, problem, parts, r"\\ ")


def _row(numbers: tuple[str, ...]) -> str:
    return f"[{', '.join(numbers)}]"


def _leg(leg: Leg) -> str:
    return f"{leg.ax}, {leg.ay}, {leg.x}, {leg.y}*H"
