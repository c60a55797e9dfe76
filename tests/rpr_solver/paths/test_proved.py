"""From a route and its proof to a path."""

from rpr_solver import EXAMPLES, cusp_loop
from rpr_solver.paths.path import SamplingPlan
from rpr_solver.paths.proofs import prove
from rpr_solver.paths.proved import PROOF_BITS, path_of

LOOP = cusp_loop(EXAMPLES["innocenti"], 27, 4, samples=2)


def test_a_route_and_its_proof_make_the_path() -> None:
    route = LOOP.route
    proof = prove(route.slice_map, route.at(PROOF_BITS), LOOP.sign)
    assert proof is not None
    plan = SamplingPlan.of(2, "cosine", 1)
    path = path_of(LOOP.manipulator, route, proof, plan, 15)
    assert (path.cusp, path.winding) == (None, None)
    assert (path.start, path.stop, path.lengths) == (LOOP.start, LOOP.stop, LOOP.lengths)
    again = path_of(LOOP.manipulator, route, proof, plan, 15, (4, 1, ()))
    assert again.samples == LOOP.samples
