"""The reference vectors: correct answers to 96 digits, computed by an independent method."""

import json
from pathlib import Path

CASES = json.loads((Path(__file__).parents[1] / "data" / "cusps.json").read_text(encoding="utf-8"))["cases"]
