"""Test modules here share the oracle, the effect that a stranger might write, and the stability ladder."""

import sys
from pathlib import Path

HERE = Path(__file__).parent
sys.path[:0] = [str(HERE), str(HERE.parent / "effects"), str(HERE.parents[1] / "benchmarks")]
