"""The curve of a pose that is carried along: its slopes against differences, its points, its fold."""

from flint import arb, ctx

from rpr_solver import EXAMPLES, cusp_loop
from rpr_solver.paths.folds import Carrier, Place

LOOP = cusp_loop(EXAMPLES["innocenti"], 27, "A", samples=2)
PLACE = (0.3, -1.2, 0.4)
STEP = 2.0**-60


def carrier() -> Carrier:
    return Carrier(LOOP.route.slice_map, LOOP.route.at(200)[0])


def balls(place: tuple[float, ...]) -> Place:
    alpha, theta, tau = map(arb, place)
    return alpha, theta, tau


def test_slopes_are_those_of_differences() -> None:
    with ctx.workprec(256):
        own = carrier()
        rows = own.slopes(balls(PLACE))
        for k in range(3):
            moved = [[x + s * arb(STEP) * (i == k) for i, x in enumerate(balls(PLACE))] for s in (1, -1)]
            places: list[Place] = [(p[0], p[1], p[2]) for p in moved]
            gaps = [own.image_gap(place) for place in places]
            for row, (high, low) in zip(rows, zip(*gaps, strict=True), strict=False):
                difference = (high - low) / (2 * arb(STEP))
                assert abs(difference - row[k]) < abs(row[k]) * 1e-15 + 1e-3
            lengths = [own.arc.length(place[2]) for place in places]
            high, low = (own.singularity(p) / length for p, length in zip(places, lengths, strict=True))
            assert abs((high - low) / (2 * arb(STEP)) - rows[2][k]) < abs(rows[2][k]) * 1e-15 + 1e-3


def test_the_path_itself_arrives() -> None:
    with ctx.workprec(160):
        own = carrier()
        stop = LOOP.route.stop.refined(120)
        near = stop[0] + arb(0.001), stop[1] - arb(0.001)
        arrived = own.arrival(near)
        assert arrived is not None
        assert all(x.overlaps(y) for x, y in zip(arrived, stop, strict=True))
