"""The reference vectors: true answers to 96 digits, found by an independent method."""

import json
from pathlib import Path

CASES = json.loads((Path(__file__).parents[1] / "data" / "cusps.json").read_text(encoding="utf-8"))["cases"]
