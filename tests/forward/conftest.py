"""Test modules here share the oracle, and the effect that a stranger might write."""

import sys
from pathlib import Path

HERE = Path(__file__).parent
sys.path[:0] = [str(HERE), str(HERE.parent / "effects")]
