"""Scripts for Maple; they count and compare the cusps of slices."""

from __future__ import annotations

from rpr_solver.exports.problem import Leg, Problem
from rpr_solver.exports.text import filled

_SCRIPT = r"""
Digits := @PRECISION@:
ZERO := Float(1, -iquo(@PRECISION@, 4)):

# c, s: cosine and sine of alpha; d, e: of theta. A moving leg, seen from the fixed one, has the base point
# (ax, ay) and the platform point (x, y*h); h is the height of the platform.
SQUARE := @SQUARE@: ROOT := @SIGN@*sqrt(evalf(SQUARE)):
modulo := (F, G, x) -> expand(rem(expand(F), G, x)):
reduced := F -> modulo(modulo(modulo(F, c^2 + s^2 - 1, c), d^2 + e^2 - 1, d), h^2 - SQUARE, h):
da := F -> reduced(c*diff(F, s) - s*diff(F, c)):
dt := F -> reduced(d*diff(F, e) - e*diff(F, d)):
along := (F, G) -> reduced(da(F)*dt(G) - dt(F)*da(G)):
square := (L, ax, ay, x, y) -> reduced((L*d + x*c - y*h*s - ax)^2 + (L*e + x*s + y*h*c - ay)^2):

# Half tangents t, u of alpha, theta are counted from these turns, given by cosine and sine.
TURNS := [@TURNS@]:
cosine := (x, k) -> (TURNS[k][1]*(1 - x^2) - 2*TURNS[k][2]*x)/(1 + x^2):
sine := (x, k) -> (TURNS[k][2]*(1 - x^2) + 2*TURNS[k][1]*x)/(1 + x^2):
places := (a, b) -> [c = cosine(a, 1), s = sine(a, 1), d = cosine(b, 2), e = sine(b, 2)]:
halved := F -> numer(normal(subs(places(t, u), F))):

small := (x, k, l) -> evalb(abs(x) < (@SIZE@ + l)^k*ZERO):
near := (x, y) -> evalb(abs(x - y) <= Float(1, 2 - @DIGITS@)*max(1, abs(y))):
in_degrees := proc(x, y)
  local a;
  a := evalf(arctan(y, x)*180/Pi);
  if a < Float(1, 2 - @DIGITS@) - 180 then a + 360 else a end if
end proc:

cusps := proc(l)
  local f, g, J, Ef, Eg, Vf, Vg, j, r, b, a, p, at, found, along_g, u0, t0;
  f := square(l, @FIRST@): g := square(l, @SECOND@):
  # J = 0: the pose is singular. E = 0 as well, along f or g: three poses coalesce. V = 0 as well: four.
  J := along(f, g): Ef := along(f, J): Eg := along(g, J): Vf := along(f, Ef): Vg := along(g, Eg):
  j := halved(J):
  # the norm is rational; roots of the conjugate are no common zeros of J and E
  r := modulo(resultant(j, halved(Ef), t), h^2 - SQUARE, h):
  r := modulo(r*subs(h = -h, r), h^2 - SQUARE, h):
  if r = 0 then error "J and E share a curve of poses" end if:
  found := []:
  at := F -> evalf(subs(p, h = ROOT, F)):
  for u0 in [seq(fsolve(b[1], u), b in sqrfree(r, u)[2])] do
    for t0 in [fsolve(evalf(subs(u = u0, h = ROOT, j)), t, complex)] do
      if abs(Im(t0)) > ZERO*(1 + abs(t0)) then next end if:
      p := op(evalf(places(Re(t0), u0))):
      along_g := small(at(da(f)), 2, l) and small(at(dt(f)), 2, l):
      if along_g and small(at(da(g)), 2, l) and small(at(dt(g)), 2, l) then next end if:
      if small(at(da(J)), 4, l) and small(at(dt(J)), 4, l) then next end if:
      if not small(at(J), 4, l) then next end if:
      if not small(at(`if`(along_g, Eg, Ef)), 6, l) then next end if:
      if small(at(`if`(along_g, Vg, Vf)), 8, l) then next end if:
      a := [in_degrees(at(c), at(s)), in_degrees(at(d), at(e)), sqrt(abs(at(f))), sqrt(abs(at(g)))]:
      found := [op(found), a]:
    end do:
  end do:
  found
end proc:

same := (x, y) -> andmap(k -> near(x[k], y[k]), [1, 2, 3, 4]):
right_ones := 0:
check_slice := proc(label, l, wanted, expected)
  global right_ones; local found, right, y;
  found := cusps(l): right := evalb(nops(found) = wanted):
  for y in expected do right := right and evalb(nops(select(same, found, y)) = 1) end do:
  if right then right_ones := right_ones + 1 end if:
  printf("%s: %d cusps, %d expected: %s\n", label, nops(found), wanted, `if`(right, "agrees", "differs"))
end proc:
@CHECKS@
printf("%s\n", `if`(right_ones = @SLICES@, "agrees", "differs")):
`quit`(`if`(right_ones = @SLICES@, 0, 1)):
"""


def script(problem: Problem) -> str:
    """The script for ``maple -q``."""
    checks = [
        f'check_slice("L{problem.fixed_leg} = {part.length}", {part.exact}, {part.count}, '
        f"[{', '.join(map(_row, part.cusps or ()))}]):"
        for part in problem.slices
    ]
    first, second = (_leg(leg) for leg in problem.legs)
    parts = {
        "TURNS": ", ".join(f"[{c}, {s}]" for c, s in problem.turns),
        "FIRST": first,
        "SECOND": second,
        "CHECKS": "\n".join(checks),
        "SLICES": str(len(checks)),
    }
    return filled(_SCRIPT, problem, parts, "# ")


def _row(numbers: tuple[str, ...]) -> str:
    return f"[{', '.join(numbers)}]"


def _leg(leg: Leg) -> str:
    return f"{leg.ax}, {leg.ay}, {leg.x}, {leg.y}"
