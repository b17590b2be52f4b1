"""Test modules here share scenes on a line."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))
