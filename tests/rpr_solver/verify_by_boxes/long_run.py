"""Random true documents of each kind: how many are verified, which are not, and how long it takes.

    python -m tests.rpr_solver.verify_by_boxes.long_run --kinds tables --documents 1000

Each document that is not verified is named, with what is left open; none may be refused.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections import Counter
from statistics import median

from rpr_solver.verify_by_boxes.claims import Verdict
from rpr_solver.verify_by_boxes.documents import verify_document
from tests.rpr_solver.verify_by_boxes.true_documents import KINDS, question, true_document


def run(kind: str, first: int, documents: int, seed: int) -> bool:
    """Whether no document of a kind is refused."""
    verdicts, seconds = Counter[Verdict](), []
    for n in range(first, first + documents):
        document = true_document(kind, n, seed)
        if document is None:
            continue
        begun = time.process_time()
        verification = verify_document(document)
        seconds.append(time.process_time() - begun)
        verdicts[verification.verdict] += 1
        if not verification:
            sort = question(seed, kind, n).sort
            print(f"{kind} {n} ({sort}), {seconds[-1]:.2f} s: {verification.summary[:300]}", flush=True)
    counts = ", ".join(f"{number} {verdict}" for verdict, number in verdicts.items())
    print(f"{kind}: {counts}; median {median(seconds):.3f} s, longest {max(seconds):.2f} s", flush=True)
    return not verdicts[Verdict.REFUSED]


def main() -> int:
    """Runs all kinds that are asked for."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--kinds", nargs="+", choices=[*KINDS], default=["tables", "censuses", "reports"])
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--documents", type=int, default=100)
    parser.add_argument("--seed", type=int, default=1)
    asked = parser.parse_args()
    sound = [run(kind, asked.first, asked.documents, asked.seed) for kind in asked.kinds]
    return 0 if all(sound) else 1


if __name__ == "__main__":
    sys.exit(main())
