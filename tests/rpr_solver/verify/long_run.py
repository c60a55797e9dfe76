"""True documents of every kind, verified: none may be refused.

    python -m tests.rpr_solver.verify.long_run [--documents 100] [--seed 1] [KIND ...]

Prints what is refused, what is open with its reason, and for each kind how many documents had which verdict,
and the median and the greatest processor time. Exits with 1 if a document is refused.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections import Counter
from statistics import median

from rpr_solver import verify_document
from tests.rpr_solver.verify.true_documents import KINDS, question, true_document


def run(kind: str, documents: int, seed: int) -> bool:
    """Verify documents of one kind; whether none is refused."""
    verdicts, times = Counter[str](), []
    for n in range(documents):
        document = true_document(kind, n, seed)
        if document is None:
            continue
        start = time.process_time()
        verification = verify_document(document)
        times.append(time.process_time() - start)
        verdicts[verification.verdict.value] += 1
        if not verification:
            sort = question(seed, kind, n).sort
            why = sorted({claim.reason for claim in (*verification.refused, *verification.open)})
            print(f"{kind} {n} ({sort}): {verification.summary[:200]}: {'; '.join(why)[:300]}")
    if times:
        counts = ", ".join(f"{count} {verdict}" for verdict, count in sorted(verdicts.items()))
        print(f"{kind}: {counts}; {median(times):.2f} s, at most {max(times):.2f} s", flush=True)
    return not verdicts["refused"]


def main() -> int:
    """Verify all that is asked for."""
    parser = argparse.ArgumentParser(prog="python -m tests.rpr_solver.verify.long_run")
    parser.add_argument("kinds", nargs="*", metavar="KIND", default=list(KINDS))
    parser.add_argument("--documents", type=int, default=100)
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    refused = [kind for kind in options.kinds if not run(kind, options.documents, options.seed)]
    return 1 if refused else 0


if __name__ == "__main__":
    sys.exit(main())
